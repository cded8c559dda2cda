"""Cases of the nineteenth series, which was sealed until a version was run on it."""

from paper.cases.case import Case
from paper.cases.opened.nineteenth import instruments, life

CASES: dict[str, list[Case]] = {"simulated": [*instruments.CASES, *life.CASES], "measured": []}
"""By what made the events."""
