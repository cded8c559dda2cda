"""Cases that were written without sight of the code: sealed until a finished version is run on them, once."""

from paper.cases.case import Case
from paper.cases.sealed import counts, measured_fields, measured_nature, measured_people, one_feature, several

CASES: dict[str, list[Case]] = {
    "simulated": [*counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": [*measured_nature.CASES, *measured_people.CASES, *measured_fields.CASES],
}
"""By what made the events."""
