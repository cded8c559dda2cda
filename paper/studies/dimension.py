"""How each method fares with the number of parameters, where the mean of an event says nothing and where all."""

from avobench.bench.cells.cell import Cell
from paper.studies.paper import NUM_OBSERVATIONS

BUDGET = 160_000
"""Simulated events, as in the benchmark."""
DIMENSIONS = (2, 5, 10, 20)
FAMILIES = ("warped", "means")
DETECTOR, DETECTOR_METHODS = "alignment-3", ("smm", "avo")
"""A detector's three parameters stand beside them, for the two methods that reach its limit along the beam alone; a
cell is a minute of Pythia."""
REACHED: dict[str, tuple[int, ...]] = {
    "smm": (2, 5, 10),
    "avo": DIMENSIONS,
    "abc-smc-tuned": DIMENSIONS,
    "bolfi-tuned": (2, 5, 10),
}
"""With how many parameters each method is tried. One cell of smm takes ten minutes with 20. abc-smc and bolfi are there
with their tuned settings alone: with the paper's, one cell of bolfi takes 16 minutes with 5 parameters."""
TARGETS = 5
"""Enough to see a ratio of two; what is sought grows by thousands."""


def cells(seed: int = 0) -> list[Cell]:
    """All cells: few parameters first, so that an interrupted study is a complete one of fewer."""
    tried = [
        (p, f"{family}-{p}", method, target)
        for p in DIMENSIONS
        for method, reached in REACHED.items()
        if p in reached
        for target in range(TARGETS)
        for family in FAMILIES
    ]
    tried += [(3, DETECTOR, method, target) for target in range(TARGETS) for method in DETECTOR_METHODS]
    return [
        Cell(task, {}, method, {}, target, 0, BUDGET, NUM_OBSERVATIONS, seed)
        for _, task, method, target in sorted(tried, key=lambda one: one[0])
    ]
