"""Cases of the eighteenth series, which was sealed until a version was run on it."""

from paper.cases.case import Case
from paper.cases.opened.eighteenth import (
    counts,
    measured_fields,
    measured_nature,
    measured_people,
    one_feature,
    several,
)

CASES: dict[str, list[Case]] = {
    "simulated": [*counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": [*measured_nature.CASES, *measured_people.CASES, *measured_fields.CASES],
}
"""By what made the events."""
