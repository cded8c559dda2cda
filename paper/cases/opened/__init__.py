"""Cases on which the diagnosis is developed: those of ten simulators and ten tables, and a series that was sealed."""

from paper.cases.case import Case
from paper.cases.opened import counts, measured, one_feature, several, ten_measured, ten_simulators

CASES: dict[str, list[Case]] = {
    "simulated": [*ten_simulators.CASES, *counts.CASES, *one_feature.CASES, *several.CASES],
    "measured": [*ten_measured.CASES, *measured.CASES],
}
"""By what made the events."""
