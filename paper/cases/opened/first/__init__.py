"""Cases of ten simulators of other fields, and of ten tables: the first that were not of our kind."""

from paper.cases.case import Case
from paper.cases.opened.first import measured, simulated

CASES: dict[str, list[Case]] = {"simulated": simulated.CASES, "measured": measured.CASES}
"""By what made the events."""
