"""The paper's single experiments (Sections 4.1 and 4.2) and a check of its reasoning: cells beside the benchmark."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import stream
from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import SCHEMA_VERSION, decode, encode
from avobench.bench.store.versions import versions
from avobench.tasks.alignment import CHUNK, NUM_COLUMNS, NUM_ROWS, Alignment
from avobench.tasks.contract import NUM_TARGETS, Box
from avobench.tasks.errors import StoreError
from avobench.tasks.poisson import Poisson

THETA_ITSELF = Box((-np.sqrt(3),), (np.sqrt(3),))
"""The prior in whose standardised coordinates (see TruncatedGaussian) a parameter is itself: the paper's experiments
give the proposal's start and learning rate in theta. The prior has no other part in them."""

NUM_OBSERVATIONS = 100_000
"""The paper does not say how many events its examples observe; this is the number of its benchmark."""
REPETITIONS = {"poisson": 5, "alignment": 2}
"""The paper shows one run each."""
SUMMARY_TARGETS = 5
"""Enough for a paired test to reject; Pythia takes most of a minute a cell."""
ABLATION_TARGETS = 5
"""Runs of each row: they tell factors, not per cents."""
CHEAP_TASKS = ("poisson", "carl", "weinberg")
BEYOND_MEANS = ("warped-5", "warped-10")
"""Tasks in which the mean of an event says next to nothing."""
ABLATION_TASKS = (*CHEAP_TASKS, *BEYOND_MEANS, "alignment")
ABLATIONS: dict[str, tuple[dict[str, Any], tuple[str, ...]]] = {
    "without the local phase": ({"local_share": 0.0}, ABLATION_TASKS),
    "without polish and local phase": ({"polish": False}, ABLATION_TASKS),
    "means of last layers matched": ({"matched": "layers"}, ABLATION_TASKS),
    "means of inputs matched": ({"matched": "inputs"}, ABLATION_TASKS),
    "no adversary: one iteration": ({"iterations": 1}, ABLATION_TASKS),
    "all events from the proposal": ({"wide_share": 0.0}, (*CHEAP_TASKS, *BEYOND_MEANS)),
    "each d used on its own events": ({"cross_fit": False}, (*CHEAP_TASKS, "alignment")),
    "images not summed": ({"symmetric": False}, ("alignment",)),
    "fresh events only": ({"replay": 160, "proposal_replay": 160}, CHEAP_TASKS),
    "features not decorrelated": ({"whiten": False}, CHEAP_TASKS),
    "R1 with lambda = 10": ({"r1": 10.0}, CHEAP_TASKS),
    "no bonus on the entropy": ({"entropy": 0.0}, CHEAP_TASKS),
    "std free": ({"min_std": 1e-3, "max_std": 1.0}, CHEAP_TASKS),
    "constant learning rates": (
        {"learning_rate": [1e-3, 1e-3], "proposal_learning_rate": [0.1, 0.1]},
        CHEAP_TASKS,
    ),
    "the paper's network": ({"hidden": [100] * 4}, ("carl",)),
}
"""Differences of avo from avo-paper, each undone alone: the settings, and the tasks on which that is done.

160 events are those of one iteration. The paper's networks for the other tasks cost ten times the time and more; on
alignment, with a minute of Pythia a cell, only what was found to matter there is undone.
"""


@dataclass(frozen=True)
class PoissonExample(Poisson):
    """Section 4.1: x ~ Poisson(exp theta), theta* = log 7."""

    name: ClassVar = "poisson-example"
    prior: ClassVar = THETA_ITSELF

    def targets(self, n: int = 1) -> NDArray[np.float64]:
        return np.full((n, 1), np.log(7))


@dataclass(frozen=True)
class AlignmentExample(Alignment):
    """Section 4.2: the task alignment at theta* = 1 mm."""

    name = "alignment-example"
    prior = THETA_ITSELF

    def targets(self, n: int = 1) -> NDArray[np.float64]:
        return np.ones((n, 1))

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        return Alignment().floor(theta, num_observations, num_simulations)


@dataclass(frozen=True)
class AlignmentRows(Alignment):
    """The benchmark's alignment with another summary statistic, which knows that nothing depends on the azimuth."""

    name = "alignment-rows"

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """The sums of an average image over azimuth: (n, 1024) -> (32,)."""
        return super().summary(x).reshape(NUM_ROWS, NUM_COLUMNS).sum(axis=1)

    def targets(self, n: int = NUM_TARGETS) -> NDArray[np.float64]:
        return Alignment().targets(n)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        return Alignment().floor(theta, num_observations, num_simulations)


def cells(study: str, seed: int = 0) -> list[Cell]:
    """The cells of the study `poisson` or `alignment`, avo-paper with the experiment's own settings, or of another.

    `summary` is ABC-SMC and BOLFI on the first targets of alignment with AlignmentRows, all else as in the benchmark;
    `ablation` is avo on the first targets of every task with each of ABLATIONS.
    The paper's example has gamma = 0 and 1e-4; 1e-2, and 1e-4 with the gradient of the entropy as printed, are there to
    tell what gamma does. Both studies count 32 events an iteration, as Section 4.2 does with its 5 000 iterations for
    160 000 simulations: the schedule `shared`.
    """
    if study == "summary":
        spec = f"{__name__}:AlignmentRows"
        return [
            Cell(spec, {}, method, {}, target, 0, 160_000, NUM_OBSERVATIONS, seed)
            for target in range(SUMMARY_TARGETS)
            for method in ("abc-smc", "bolfi")
        ]
    if study == "ablation":
        each = [
            (ABLATION_TASKS.index(task), cell)
            for settings, tasks in ABLATIONS.values()
            for task in tasks
            for cell in ablation(task, settings, seed)
        ]
        return [cell for _, cell in sorted(each, key=lambda item: (item[0], item[1].target))]
    if study == "poisson":  # Section 4.1: 3 000 iterations
        spec, budget = f"{__name__}:PoissonExample", 3000 * 32
        common = {"schedule": "shared", "hidden": [20, 20, 20], "initial_std": 0.5}
        variants = [{**common, "entropy": gamma} for gamma in (0.0, 1e-4, 1e-2)]
        variants += [{**common, "entropy": 1e-4, "entropy_gradient": "as_printed"}]
    else:  # Section 4.2: 5 000 iterations
        spec, budget, variants = f"{__name__}:AlignmentExample", 5000 * 32, [{"schedule": "shared"}]
    return [
        Cell(spec, {}, "avo-paper", settings, 0, repetition, budget, NUM_OBSERVATIONS, seed)
        for repetition in range(REPETITIONS[study])
        for settings in variants
    ]


def ablation(task: str, settings: dict[str, Any], seed: int = 0) -> list[Cell]:
    """The cells of one of ABLATIONS on a task, or with {} those of the benchmark's avo to compare them with."""
    return [
        Cell(task, {}, "avo", settings, target, 0, 160_000, NUM_OBSERVATIONS, seed)
        for target in range(ABLATION_TARGETS)
    ]


DETECTOR_FILE = "detector.json"
DETECTOR_THETA = (0.0, 1.0)
DETECTOR_EVENTS = 200_000
"""Behind each average response (paper, Figure 2): a cell is then known to a few per cent."""
SINGLE_EVENTS = 3
"""Shown by themselves (paper, Figure 2)."""


def detector(path: Path, seed: int = 0, num_events: int = DETECTOR_EVENTS) -> dict[str, Any]:
    """The detector's response at each of DETECTOR_THETA, read from `path` or, if that is missing or of others, made.

    `responses` holds for each theta the `mean` image over `num_events` events, (1024,), and the first SINGLE_EVENTS of
    them as lists of the cells that were hit. No event serves twice. Raises StoreError when the file is damaged.
    """
    task = Alignment()
    identity = {"study": "detector", "theta": list(DETECTOR_THETA), "num_events": num_events, "seed": seed}
    identity |= {"task": task.name, "task_version": task.version}
    if path.exists():
        record = read_detector(path.parent)
        if {name: record[name] for name in identity} == identity:
            return record
    rng = stream(seed, "study", "detector")
    responses = []
    for theta in DETECTOR_THETA:
        total, events = np.zeros(task.num_features), []
        for start in range(0, num_events, CHUNK):
            x = task.simulate(np.full((min(CHUNK, num_events - start), 1), theta), rng)
            total += x.sum(axis=0, dtype=float)
            events += list(x[: SINGLE_EVENTS - len(events)])
        hits = [np.flatnonzero(event).tolist() for event in events]
        responses.append({"theta": theta, "mean": (total / num_events).tolist(), "events": hits})
    record = {"schema_version": SCHEMA_VERSION, **identity, "responses": responses, "versions": versions()}
    write_atomically(path, encode(record))
    return record


def read_detector(folder: Path) -> dict[str, Any]:
    """The record of the study `detector` in a results folder. Raises StoreError when it is missing or damaged."""
    path = folder / DETECTOR_FILE
    if not path.exists():
        raise StoreError(f"there is no {path}; `python -m paper.study detector --results {folder}` makes it")
    try:
        return decode(path.read_bytes())
    except ValueError as error:
        raise StoreError(f"{path} {error}; delete it, and `python -m paper.study detector` makes it again") from error
