"""Cases that were written without sight of the code: sealed until a finished version is run on them, once."""

from paper.cases.case import Case

CASES: dict[str, list[Case]] = {"simulated": [], "measured": []}
"""By what made the events. None are sealed at present."""
