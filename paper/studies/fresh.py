"""A hundred targets a task that no setting was chosen on and no earlier version was run on."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.bench.cells.cell import Cell
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.contract import Task, stable_hash
from avobench.tasks.poisson import Poisson
from avobench.tasks.warped import Warped2, Warped5, Warped10
from avobench.tasks.weinberg import Weinberg
from paper.studies.paper import NUM_OBSERVATIONS

BUDGET = 160_000
"""Simulated events, as in the benchmark."""
NUM_FRESH = 100
"""A fault of one run in thirty is then missed with a probability of 3 %."""
METHODS = ("smm", "avo")
"""The simplest baseline and the method on trial."""


class Fresh(Task):
    """Other targets for a task: those of a seed of their own. What else there is stays the task's."""

    of: ClassVar[type[Task]]

    def targets(self, n: int = NUM_FRESH) -> NDArray[np.float64]:
        """Drawn from the prior: (n, p)."""
        return self.prior.sample(n, np.random.default_rng(stable_hash("fresh targets", self.of.name)))

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """The task's own: on alignment it is known for that class alone."""
        return self.of().floor(theta, num_observations, num_simulations)


class FreshPoisson(Fresh, Poisson):
    name = "poisson-fresh"
    of = Poisson


class FreshCarl(Fresh, Carl):
    name = "carl-fresh"
    of = Carl


class FreshWeinberg(Fresh, Weinberg):
    name = "weinberg-fresh"
    of = Weinberg


class FreshAlignment(Fresh, Alignment):
    name = "alignment-fresh"
    of = Alignment


class FreshWarped2(Fresh, Warped2):
    name = "warped-2-fresh"
    of = Warped2


class FreshWarped5(Fresh, Warped5):
    name = "warped-5-fresh"
    of = Warped5


class FreshWarped10(Fresh, Warped10):
    name = "warped-10-fresh"
    of = Warped10


TASKS = (FreshPoisson, FreshCarl, FreshWeinberg, FreshAlignment, FreshWarped2, FreshWarped5, FreshWarped10)


def cells(seed: int = 0) -> list[Cell]:
    """All cells, target by target, so that an interrupted study is a complete one of fewer targets."""
    return [
        Cell(f"{__name__}:{task.__name__}", {}, method, {}, target, 0, BUDGET, NUM_OBSERVATIONS, seed)
        for target in range(NUM_FRESH)
        for task in TASKS
        for method in METHODS
    ]
