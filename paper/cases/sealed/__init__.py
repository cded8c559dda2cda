"""Cases that were written without sight of the code: sealed until a finished version is run on them, once."""

from paper.cases.case import Case
from paper.cases.sealed import counts, one_feature, several

CASES: dict[str, list[Case]] = {
    "simulated": [*counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": [],
}
"""By what made the events."""
