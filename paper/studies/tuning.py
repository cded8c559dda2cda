"""The settings of the rivals at their best, chosen on development targets: `python -m paper.study tuning`.

Each candidate is run on the same targets, which are not the benchmark's; `paper.tables.tuning` prints the table
from which `abc-smc-tuned` and `bolfi-tuned` have their defaults.
"""

from typing import Any

from avobench.bench.cells.cell import Cell
from paper.studies import development
from paper.studies.paper import NUM_OBSERVATIONS

BUDGET = 160_000
"""That of the benchmark."""
NUM_TARGETS = {"abc-smc": 4, "bolfi": 2, "bsl": 2, "nre": 2, "nle": 2, "npe": 2, "tsnpe": 2}
"""Development targets of each task: the others take ten times as long as ABC-SMC."""
_LARGER = {"population_size": 20, "events_per_theta": 512}
_GROWING = {"growth": 1.5, "estimate": "regression"}
_STARTED = {"initial_evidence": 50}
CANDIDATES: dict[str, dict[str, dict[str, Any]]] = {
    "abc-smc": {
        "as pyABC has it: 100 x 128, mode": {},
        "100 x 128, mean": {"estimate": "mean"},
        "100 x 128, regression": {"estimate": "regression"},
        "20 x 512, mean": {**_LARGER, "estimate": "mean"},
        "20 x 512, regression": {**_LARGER, "estimate": "regression"},
        "30 x 128, regression": {"population_size": 30, "estimate": "regression"},
        "30 x 128 growing, regression": {"population_size": 30, **_GROWING},
        "20 x 256 growing, regression": {**_LARGER, "events_per_theta": 256, **_GROWING},
        "20 x 512 growing, regression": {**_LARGER, **_GROWING},
        "60 x 128 growing, regression": {"population_size": 60, **_GROWING},
    },
    "bolfi": {
        "as ELFI has it: 10 x 128": {},
        "50 x 128, log": {**_STARTED, "log_distance": True},
        "50 x 512": {**_STARTED, "events_per_theta": 512},
        "50 x 512, log": {**_STARTED, "events_per_theta": 512, "log_distance": True},
        "50 x 512, regression": {**_STARTED, "events_per_theta": 512, "regression": True},
        "50 x 256 growing, log, regression": {
            **_STARTED,
            "events_per_theta": 256,
            "growth": 8.0,
            "log_distance": True,
            "regression": True,
        },
    },
    "bsl": {
        "4 chains, to 2048 events": {"chains": 4},
        "3 chains, to 1024 events": {},
        "2 chains, to 512 events": {"chains": 2},
    },
    "nre": {"as it is": {}},
    "nle": {"as it is": {}},
    "npe": {"1250 sets of 128": {}, "312 sets of 512": {"events_per_set": 512}},
    "tsnpe": {"as it is": {}, "312 sets of 512": {"events_per_set": 512}},
}
"""By method and what the table calls them, settings; the first of abc-smc and bolfi is the paper's. N x M is a
population, or initial evidence, of N parameters with M events each."""


def candidate(method: str, settings: dict[str, Any], task: str) -> list[Cell]:
    """The cells of a candidate on the development targets of a task."""
    return [
        Cell(development.spec(task), {}, method, settings, target, 0, BUDGET, NUM_OBSERVATIONS, development.SEED)
        for target in range(NUM_TARGETS[method])
    ]


def cells() -> list[Cell]:
    """All of them, ordered so that an interrupted study has complete tables of fewer targets."""
    each = [
        cell
        for method, candidates in CANDIDATES.items()
        for settings in candidates.values()
        for task in development.TASKS
        for cell in candidate(method, settings, task)
    ]
    return sorted(each, key=lambda cell: cell.target)
