"""Cases that were written without sight of the code: sealed until a finished version is run on them, once.

At present there are none.
"""

from paper.cases.case import Case

CASES: dict[str, list[Case]] = {"simulated": [], "measured": []}
"""By what made the events."""
