"""Cases of the sixteenth series, which was sealed until a version was run on it."""

from paper.cases.case import Case
from paper.cases.opened.sixteenth import counts, measured_nature, measured_people, one_feature, several

CASES: dict[str, list[Case]] = {
    "simulated": [*counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": [*measured_nature.CASES, *measured_people.CASES],
}
"""By what made the events."""
