"""How often the tests of a diagnosis see that features depend on one another: `python -m paper.studies.dependence`."""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.goodness_of_fit.gates import ExtendedModel
from avobench.effects.model import Model
from avobench.tasks import Task
from avobench.tasks.carl import Carl
from avobench.tasks.function import task
from avobench.tasks.weinberg import Weinberg

SETS = 60
"""Data sets of each case: a rate of 5 % is then known to 3 %."""
ALPHA = 0.05
EFFORT = Effort(sharpen=6, covariance=30_000)
"""Half of that of a diagnosis of few events, whose p-values it leaves as they are."""


def normals(d: int) -> Task:
    """Independent standard normals (n, d), of which theta shifts the first."""
    return task(
        lambda theta, rng: rng.standard_normal((len(theta), d)) + np.pad(theta, ((0, 0), (0, d - 1))),
        prior={"shift": (-1, 1)},
        name=f"normals-{d}",
    )


def correlated(rho: float) -> Callable[[NDArray, np.random.Generator], NDArray]:
    """The second feature of independent normals (n, d) gets a correlation with the first."""

    def change(x: NDArray, rng: np.random.Generator) -> NDArray:
        return np.c_[x[:, :1], rho * x[:, :1] + np.sqrt(1 - rho**2) * x[:, 1:2], x[:, 2:]]

    return change


def common_gain(size: float) -> Callable[[NDArray, np.random.Generator], NDArray]:
    """All features of an event (n, d) are stretched by one factor, which scatters by `size` from event to event."""
    return lambda x, rng: x * (1 + size * rng.standard_normal((len(x), 1)))


def common_scale(size: float) -> Callable[[NDArray, np.random.Generator], NDArray]:
    """All features (n, d) are stretched by the same factor."""
    return lambda x, rng: x * (1 + size)


@dataclass(frozen=True)
class Case:
    """Data sets of one kind."""

    task: Task
    theta: tuple[float, ...]
    num_events: int
    """Fitted: three quarters of those measured."""
    change: Callable[[NDArray, np.random.Generator], NDArray] | None = None
    """What the simulator lacks; None where it is right."""


CASES = {
    "nothing in two normals": Case(normals(2), (0.0,), 750),
    "nothing in five normals": Case(normals(5), (0.0,), 750),
    "nothing in carl": Case(Carl(), (0.5, -1.0), 1500),
    "nothing in carl, with bins of pairs": Case(Carl(), (0.5, -1.0), 3000),
    "nothing in weinberg": Case(Weinberg(), (45.5, 1.0), 1500),
    "rho = 0.3 in two normals": Case(normals(2), (0.0,), 750, correlated(0.3)),
    "rho = 0.2 in two normals": Case(normals(2), (0.0,), 1500, correlated(0.2)),
    "rho = 0.2 in twelve normals": Case(normals(12), (0.0,), 1500, correlated(0.2)),
    "a gain of 1 ± 0.1 of twelve normals": Case(normals(12), (0.0,), 1500, common_gain(0.1)),
    "a scale of 1.03 of twelve normals": Case(normals(12), (0.0,), 1500, common_scale(0.03)),
}


def rejections(case: Case, sets: int = SETS) -> dict[str, int]:
    """In how many data sets each test, and all together, reject the simulator at 5 %."""
    counts: dict[str, int] = {}
    for k in range(sets):
        rng = np.random.default_rng([sets, k])
        x = case.task.simulate(np.tile(case.theta, (case.num_events, 1)), rng)
        x = x if case.change is None else case.change(x, rng)
        fit, target = fit_null(Model(case.task), x, rng, EFFORT, None)
        tested = ExtendedModel.of(fit, target, x, rng, EFFORT)
        for name, gate in tested.gates.items():
            counts[name] = counts.get(name, 0) + (gate.p_value < ALPHA)
        counts["together"] = counts.get("together", 0) + (tested.p_value < ALPHA)
    return counts


if __name__ == "__main__":
    for name in sys.argv[1:] or CASES:
        found = ", ".join(f"{test} {count}" for test, count in rejections(CASES[name]).items())
        print(f"{name}: of {SETS} data sets {found}", flush=True)
