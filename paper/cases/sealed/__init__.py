"""Cases that were written without sight of the code: sealed until a finished version is run on them, once.

At present they are the twentieth series.
"""

from paper.cases.case import Case
from paper.cases.sealed import nature, trades

CASES: dict[str, list[Case]] = {"simulated": [*trades.CASES, *nature.CASES], "measured": []}
"""By what made the events."""
