"""Heaping: what it makes, and how its step is read off the data."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import applied, entry, shape_of

from avobench.effects.catalogue import catalogue
from avobench.effects.heaping import Heaping, heaps
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson


def heaping(task, feature, shape):
    of = next(effect for effect in catalogue(task) if isinstance(effect, Heaping) and effect.feature == feature)
    return shape_of(of, shape)


@pytest.mark.parametrize(("shape", "phi"), [("heaped", [0.3, 5]), ("heaped_near", [0.8, 5, 0.2])])
def test_a_share_of_the_counts_is_the_nearest_round_number(shape, phi):
    x = np.random.default_rng(1).integers(20, 120, (200_000, 1))
    y = applied(heaping(Poisson(), None, shape), x, phi)
    assert y.dtype == x.dtype
    for away in (0, 1, 2):
        at = np.abs(x - 5 * np.rint(x / 5)) == away
        moved = 0 if away == 0 else 0.3 if shape == "heaped" else 0.8 * np.exp(-away / (0.2 * 5))
        assert (y[at] != x[at]).mean() == pytest.approx(moved, abs=0.01)
    assert (y[y != x] % 5 == 0).all()


def test_the_step_is_read_off_counts_and_off_real_numbers():
    rng = np.random.default_rng(2)
    counts = rng.poisson(40, (20_000, 1))
    effect = heaping(Poisson(), None, "heaped")
    adapted = effect.adapted(applied(effect, counts, [0.3, 10]))
    assert adapted.steps == pytest.approx((10, 10))
    assert [each.known for each in (*adapted.parameters, *effect.parameters)] == [False, True, False, False]
    assert adapted.guess(applied(effect, counts, [0.3, 10]))[0] == pytest.approx([0.3, 10], abs=0.03)
    x = rng.normal(7, 3, (20_000, 5))
    effect = heaping(Carl(), 1, "heaped")
    y = applied(effect, x, [0.1, 0.5])
    assert effect.adapted(y).steps == pytest.approx((0.5, 0.5))
    assert (y[:, [0, 2, 3, 4]] == x[:, [0, 2, 3, 4]]).all()
    tenths = np.round(x, 1)
    assert effect.adapted(applied(effect, tenths, [0.2, 1])).steps == pytest.approx((1, 1))


@given(st.integers(0, 2**32 - 1), st.floats(0.5, 60), st.booleans())
def test_what_nobody_heaped_shows_no_heaps(seed, scale, whole):
    rng = np.random.default_rng(seed)
    x = rng.poisson(scale, 20_000) if whole else rng.normal(scale, scale / 4, 20_000)
    assert heaps(x, whole).step == 0
    effect = heaping(Poisson() if whole else Carl(), None if whole else 0, "heaped_near")
    assert effect.guess(np.tile(x[:, None], 1 if whole else 5)).shape == (0, 3)


def test_heaps_are_another_shape_of_a_rounding():
    """With all values on multiples of the step, the same events."""
    x = np.random.default_rng(3).poisson(40, (10_000, 1))
    rounded = shape_of(entry(Poisson(), "quantisation", None), "7 nearest")
    np.testing.assert_array_equal(applied(heaping(Poisson(), None, "heaped"), x, [1, 7]), applied(rounded, x, [1]))
