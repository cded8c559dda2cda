"""How often a fit by `avobench.infer` is doubted where its simulator is right, and where it is not, at many sizes."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.api.inference import infer
from avobench.bench.cells.streams import stream
from avobench.bench.plugins import registry
from avobench.tasks import Task
from avobench.tasks.function import task
from paper.studies.files import StudyFile

FILE = StudyFile("agreement")
NUM_SEEDS = 20
"""Fits of each case, each of other events: one doubt in twenty is what is allowed."""
THETA = {"poisson": (2.0,), "carl": (0.5, -1.0), "normal": (0.4, -0.2)}
"""Where the events of the sound cases are made."""


class Case(NamedTuple):
    """Fits of one kind: the task that is fitted, what makes the events, how many, and the budget."""

    task: Task
    events: Callable[[int, np.random.Generator], NDArray]
    sizes: tuple[tuple[int, int], ...]
    """Pairs of a number of observed events and a budget."""
    method: str = "smm"
    sound: bool = False
    """Whether the simulator makes such events."""


def normal(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """x ~ N(mean, exp(log_width)), and its square, so that means tell both parameters: (n, 2) -> (n, 2)."""
    x = rng.normal(theta[:, 0], np.exp(theta[:, 1]))
    return np.stack([x, x**2], axis=1)


def cases() -> dict[str, Case]:
    """The sound cases, and then those with something that the simulator does not make."""
    tasks = {name: registry.build("task", name, {}) for name in ("poisson", "carl")}
    tasks["normal"] = task(normal, prior={"mean": (-2, 2), "log_width": (-1, 1)}, name="normal")
    mean = task(lambda theta, rng: rng.normal(theta[:, 0], 1), prior={"mean": (-2, 2)}, name="mean")
    flat = task(lambda theta, rng: rng.beta(theta[:, 0], 1), prior={"power": (0.5, 2)}, name="flat")

    def sound(name: str) -> Callable[[int, np.random.Generator], NDArray]:
        return lambda n, rng: tasks[name].simulate(np.tile(THETA[name], (n, 1)), rng)

    def student(n: int, rng: np.random.Generator) -> NDArray:
        x = 0.4 + rng.standard_t(2.5, n)
        return np.stack([x, x**2], axis=1)

    def outliers(n: int, rng: np.random.Generator) -> NDArray:
        return np.where(rng.random(n) < 0.05, rng.normal(6, 0.5, n), rng.normal(0.5, 1, n))[:, None]

    def peak(n: int, rng: np.random.Generator) -> NDArray:
        return np.where(rng.random(n) < 0.02, rng.normal(0.5, 0.01, n), rng.uniform(0, 1, n))[:, None]

    sizes = ((100, 1000), (2000, 8000), (20_000, 80_000))
    return {
        **{name: Case(tasks[name], sound(name), sizes, sound=True) for name in tasks},
        "normal, avo": Case(tasks["normal"], sound("normal"), sizes[:2], "avo", sound=True),
        "5 % of outliers": Case(mean, outliers, sizes),
        "Student tails": Case(tasks["normal"], student, sizes),
        "a peak of 2 % is missing": Case(flat, peak, (*sizes[1:], (100_000, 160_000))),
    }


def made(path: Path, seed: int = 0, num_seeds: int = NUM_SEEDS) -> dict[str, Any]:
    """The record of the study at `path`, of which each fit that is lacking is made and written at once.

    `fits` holds for each the `case`, `num_events`, `budget`, the number `fit`, whether it is `sound`, and its `doubt`.
    Raises StoreError for a damaged file.
    """

    def one(name: str, case: Case, num_events: int, budget: int, number: int) -> dict[str, Any]:
        x = case.events(num_events, stream(seed, "observed", name, num_events, number))
        found = infer(case.task, x, case.method, budget=budget, seed=number, progress=False)
        return {"sound": case.sound, "doubt": found.estimate.doubt}

    wanted = [
        ({"case": name, "num_events": n, "budget": budget, "fit": number}, partial(one, name, case, n, budget, number))
        for number in range(num_seeds)
        for name, case in cases().items()
        for n, budget in case.sizes
    ]
    return FILE.completed(path, "fits", wanted, seed=seed)


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a case and size: the number of fits, and of those that were doubted, for whatever reason."""
    fits = pd.DataFrame(records[0]["fits"])
    fits["doubted"] = fits["doubt"] != ""
    grouped = fits.groupby(["case", "num_events", "budget", "sound"], sort=False)["doubted"]
    return grouped.agg(fits="size", doubted="sum").reset_index()
