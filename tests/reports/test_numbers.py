"""How numbers are printed."""

import math

import pytest

from avobench.reports.numbers import column, number, p_equals, p_value, with_error


@pytest.mark.parametrize(
    ("p", "alone", "sentence"),
    [
        (0.0, "< 1e-300", "p < 1e-300"),
        (5e-324, "< 1e-300", "p < 1e-300"),
        (9.9e-301, "< 1e-300", "p < 1e-300"),
        (1e-300, "1e-300", "p = 1e-300"),
        (6.07392e-33, "6.07e-33", "p = 6.07e-33"),
        (0.2124, "0.212", "p = 0.212"),
        (1.0, "1", "p = 1"),
    ],
)
def test_no_p_value_is_zero(p, alone, sentence):
    assert (p_value(p), p_equals(p)) == (alone, sentence)


def test_what_is_not_known_is_a_dash():
    assert [number(None), number(math.nan), p_value(None)] == ["-"] * 3


@pytest.mark.parametrize(
    ("value", "std", "told"),
    [
        (45.5521, 0.3609, "45.55 ± 0.36"),
        (867.42769, 0.01413, "867.428 ± 0.014"),
        (0.7765, 0.0995, "0.78 ± 0.10"),
        (0.0001, 1.234, "0.0 ± 1.2"),
        (1234.5, 123.4, "1230 ± 120"),
        (3.214e-6, 1.04e-7, "(3.21 ± 0.10)e-06"),
        (2.5e8, 3.1e6, "(2.500 ± 0.031)e+08"),
        (0.0, 0.0, "0 ± 0"),
        (45.5521, None, "45.5521"),
    ],
)
def test_a_value_is_printed_to_the_two_digits_of_its_error(value, std, told):
    assert with_error(value, std) == told


def test_the_numbers_of_a_column_have_as_many_decimals():
    assert column([]) == []
    assert column([1, 20, None]) == ["1", "20", "-"]
    assert column([1.0, None, math.nan, math.inf]) == ["1.00", "-", "-", "inf"]
    assert column([32.31, 3.84, 100.0]) == ["32.31", "3.84", "100.00"]
    assert column([0.25, -12.0]) == ["0.250", "-12.000"]
    assert column([150.0, 27.5]) == ["150.0", "27.5"]
    assert column([8.4e-6, 0.0564, 0.0]) == ["8.40e-06", "5.64e-02", "0.00e+00"]
    assert column([1.5, 100_000.0]) == ["1.50e+00", "1.00e+05"]
