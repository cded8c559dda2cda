"""Cases of the twentieth series, which was sealed until a version was run on it."""

from paper.cases.case import Case
from paper.cases.opened.twentieth import nature, trades

CASES: dict[str, list[Case]] = {"simulated": [*trades.CASES, *nature.CASES], "measured": []}
"""By what made the events."""
