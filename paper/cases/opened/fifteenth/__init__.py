"""Cases of the fifteenth series, which was sealed until a version was run on it."""

from paper.cases.case import Case
from paper.cases.opened.fifteenth import counts, measured, one_feature, several

CASES: dict[str, list[Case]] = {
    "simulated": [*counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": measured.CASES,
}
"""By what made the events."""
