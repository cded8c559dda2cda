"""Cases that were written without sight of the code: sealed until a finished version is run on them, once.

At present they are the twenty-first series.
"""

from paper.cases.case import Case
from paper.cases.sealed import wild, work

CASES: dict[str, list[Case]] = {"simulated": [*work.CASES, *wild.CASES], "measured": []}
"""By what made the events."""
