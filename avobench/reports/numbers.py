"""The way in which numbers are printed: on both pages, in the figures and by the command line."""

import math
from collections.abc import Sequence

SMALLEST_P = 1e-300
"""A smaller p-value is told as smaller than this: near it floating-point numbers end, so that it may be kept as 0."""
SCIENTIFIC_BELOW = 1e-3
"""A column with a smaller number is printed in powers of ten: its digits would begin after too many zeros."""
SCIENTIFIC_FROM = 1e5
"""A column with a larger number is printed in powers of ten: it would have digits that say nothing."""

LARGE_POWER = 6
"""A value from this power of ten on is printed with one beside its error: it would have digits that say nothing."""
SMALL_POWER = -7
"""So is one whose error has its last digit below this power: its digits would begin after too many zeros."""


def number(value: float | None) -> str:
    """Three digits, or a dash where there is no number."""
    return "-" if value is None or math.isnan(value) else f"{value:.3g}"


def in_unit(unit: str) -> str:
    """A unit as it stands behind a number; nothing for a pure number."""
    return "" if unit == "1" else f" {unit}"


def p_value(p: float | None) -> str:
    """A p-value in a table: `0.212`, `6.07e-33`, or `< 1e-300` where it is too small to be told from 0."""
    return f"< {SMALLEST_P:.0e}" if p is not None and p < SMALLEST_P else number(p)


def p_equals(p: float) -> str:
    """A p-value in a sentence: `p = 0.212`, or `p < 1e-300`."""
    return f"p {p_value(p)}" if p < SMALLEST_P else f"p = {p_value(p)}"


def with_error(value: float, std: float | None) -> str:
    """A value with its error, to the two digits that the error leaves certain: `45.55 ± 0.36`; without one, six digits.

    Both have a common power of ten where one of them is large, or the error is small: `(3.21 ± 0.10)e-06`.
    """
    if std is None and math.isfinite(value):
        return f"{value:.6g}"
    if std is None or not (math.isfinite(value) and math.isfinite(std)):
        return number(value)
    if std == 0:
        return f"{value:.4g} ± 0"
    std = float(f"{std:.1e}")
    last, power = math.floor(math.log10(std)) - 1, math.floor(math.log10(max(abs(value), std)))
    if power >= LARGE_POWER or last < SMALL_POWER:
        return f"({value / 10.0**power:.{power - last}f} ± {std / 10.0**power:.{power - last}f})e{power:+03d}"
    decimals = max(-last, 0)
    return f"{round(value, -last):.{decimals}f} ± {round(std, -last):.{decimals}f}"


def column(values: Sequence[float | None]) -> list[str]:
    """The numbers of a table's column, all with as many decimals, so that they can be compared from row to row.

    The smallest of them has three digits, and at most three decimals. None and NaN are dashes.
    """
    present = [value for value in values if value is not None and not math.isnan(value)]
    if all(isinstance(value, int) for value in present):
        return [str(value) if isinstance(value, int) else "-" for value in values]
    sizes = [abs(value) for value in present if value != 0 and math.isfinite(value)]
    low, high = min(sizes, default=1.0), max(sizes, default=1.0)
    if low < SCIENTIFIC_BELOW or high >= SCIENTIFIC_FROM:
        form = ".2e"
    else:
        form = f".{min(max(2 - math.floor(math.log10(low)), 0), 3)}f"
    return ["-" if value is None or math.isnan(value) else f"{value:{form}}" for value in values]
