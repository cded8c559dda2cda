"""Cases that were written without sight of the code: sealed until a finished version is run on them, once.

At present they are the nineteenth series.
"""

from paper.cases.case import Case
from paper.cases.sealed import instruments, life

CASES: dict[str, list[Case]] = {"simulated": [*instruments.CASES, *life.CASES], "measured": []}
"""By what made the events."""
