"""Cases on which the diagnosis is developed: a folder for each series, all but the first once sealed."""

from paper.cases.case import Case
from paper.cases.opened import (
    eighteenth,
    eleventh,
    fifteenth,
    first,
    fourteenth,
    nineteenth,
    seventeenth,
    sixteenth,
    tenth,
    thirteenth,
    twelfth,
    twentieth,
)

SERIES = (
    first,
    tenth,
    eleventh,
    twelfth,
    thirteenth,
    fourteenth,
    fifteenth,
    sixteenth,
    seventeenth,
    eighteenth,
    nineteenth,
    twentieth,
)
CASES: dict[str, list[Case]] = {
    by: [case for series in SERIES for case in series.CASES[by]] for by in ("simulated", "measured")
}
"""By what made the events."""
