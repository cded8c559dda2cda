"""The benchmark of growth measures what it says."""

import pandas as pd
import pytest

from paper.speed.growth import exponent, sweep


@pytest.mark.parametrize("power", [-1.0, 0.0, 0.5, 2.0])
def test_the_exponent_of_a_power_law_is_its_power(power):
    x = pd.Series([1.0, 3.0, 10.0, 200.0])
    assert exponent(x, 7 * x**power) == pytest.approx(power, abs=1e-12)


def test_memory_does_not_grow_with_the_number_of_cells(tmp_path):
    """The leader keeps some kilobytes a cell: its records without their traces."""
    few = sweep(1, 2, 1, 480, tmp_path / "few")
    many = sweep(6, 3, 1, 480, tmp_path / "many")
    assert many["cells"] == 18
    assert many["of it new [MiB]"] < few["of it new [MiB]"] + 3
