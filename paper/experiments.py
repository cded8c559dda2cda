"""The grid of experiments: of each its cells, where its records are, and what it is for; `paper.study` runs them."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avobench.bench.cells.cell import Cell
from avobench.bench.store.store import Store
from paper import tasks
from paper.hard_tasks import HARD
from paper.sbibm_tasks import SBIBM

BUDGET = 160_000
"""The simulated events of a cell, which Section 4.3 gives to every method."""
NUM_OBSERVATIONS = 100_000
"""The observed events of a cell, those of the paper's benchmark; of its examples the paper does not tell the number."""

Settings = dict[str, Any]


@dataclass(frozen=True)
class Runs:
    """One row of an experiment: a method with its settings, on tasks and their first targets."""

    label: str
    method: str
    settings: Settings
    tasks: tuple[str, ...]
    targets: int = 15
    repetitions: int = 1
    budget: int = BUDGET

    def cells(self, task: str, seed: int = 0) -> tuple[Cell, ...]:
        """The cells on one of the tasks, in the order of repetitions, then of targets."""
        return tuple(
            Cell(task, {}, self.method, self.settings, target, repetition, self.budget, NUM_OBSERVATIONS, seed)
            for repetition in range(self.repetitions)
            for target in range(self.targets)
        )


@dataclass(frozen=True)
class Experiment:
    """Rows of cells whose records are kept in one folder of results."""

    says: str
    folder: Path
    runs: tuple[Runs, ...]
    seed: int | None = None
    """The root of all random streams where it is the experiment's own, so that development runs share none."""

    def cells(self, seed: int = 0) -> list[Cell]:
        """All cells by repetition and target, so that an interrupted experiment is a complete one of fewer targets."""
        each = [cell for run in self.runs for task in run.tasks for cell in run.cells(task, self.root(seed))]
        return sorted(each, key=lambda cell: (cell.repetition, cell.target))

    def root(self, seed: int = 0) -> int:
        """The seed of the cells: the experiment's own, or the one that is asked for."""
        return seed if self.seed is None else self.seed


def records_of(folders: Iterable[Path]) -> dict[str, dict[str, Any]]:
    """All records of results folders by their id. Raises UsageError where a folder is missing."""
    return {record["id"]: record for folder in folders for record in Store(folder).read_all()}


CHEAP = ("poisson", "carl", "weinberg")
PAPERS = (*CHEAP, "alignment")
"""The tasks of the paper's benchmark."""
DEVELOPMENT = {name: tasks.spec(task) for name, task in tasks.DEVELOPMENT.items()}
DEVELOPMENT_SEED = 20_251
"""The root of the streams of every run on development tasks: it is not that of the benchmark."""


def on(names: tuple[str, ...], *methods: str, **how: Any) -> tuple[Runs, ...]:
    """Rows of methods with their default settings on the same tasks."""
    return tuple(Runs(method, method, {}, names, **how) for method in methods)


# Section 4.1 has 3 000 iterations, Section 4.2 has 5 000; both count 32 events for each, the schedule `shared`.
POISSON = {"schedule": "shared", "hidden": [20, 20, 20], "initial_std": 0.5}
POISSON_VARIANTS: dict[str, Settings] = {
    **{f"gamma = {gamma:g}": {**POISSON, "entropy": gamma} for gamma in (0.0, 1e-4, 1e-2, 1e-1, 1.0)},
    "gradient as printed": {**POISSON, "entropy": 1e-4, "entropy_gradient": "as_printed"},
}
"""The paper has gamma = 0 and 1e-4; larger ones, and the gradient of the entropy as printed, tell what gamma does."""
OTHER_READING: Settings = {"schedule": "shared", "baseline": "as_printed"}
"""avo-paper simulates M/2 + M events an iteration, as Algorithm 1 prints; this makes 5 000 iterations of M, as Section
4.2 counts them, with Equation 13 as printed."""

BEYOND_MEANS = ("warped-5", "warped-10")
"""Tasks in which the mean of an event says next to nothing."""
ABLATION_TASKS = (*CHEAP, *BEYOND_MEANS, "alignment")
ABLATIONS: dict[str, tuple[Settings, tuple[str, ...]]] = {
    "without the local phase": ({"local_share": 0.0}, ABLATION_TASKS),
    "without polish and local phase": ({"polish": False}, ABLATION_TASKS),
    "means of last layers matched": ({"matched": "layers"}, ABLATION_TASKS),
    "means of inputs matched": ({"matched": "inputs"}, ABLATION_TASKS),
    "learnt-moments: one iteration": ({"iterations": 1}, ABLATION_TASKS),
    "three rounds, taught by all events": ({"refine": False}, (*CHEAP, *BEYOND_MEANS)),
    "all events from the proposal": ({"wide_share": 0.0}, (*CHEAP, *BEYOND_MEANS)),
    "each d used on its own events": ({"cross_fit": False}, (*CHEAP, "alignment")),
    "images not summed": ({"symmetric": False}, ("alignment",)),
    "fresh events only": ({"replay": 160, "proposal_replay": 160}, CHEAP),
    "features as they are": ({"inputs": "values"}, (*CHEAP, *BEYOND_MEANS)),
    "features not decorrelated": ({"whiten": False}, CHEAP),
    "R1 with lambda = 10": ({"r1": 10.0}, CHEAP),
    "no bonus on the entropy": ({"entropy": 0.0}, CHEAP),
    "std free": ({"min_std": 1e-3, "max_std": 1.0}, CHEAP),
    "constant learning rates": ({"learning_rate": [1e-3, 1e-3], "proposal_learning_rate": [0.1, 0.1]}, CHEAP),
    "the paper's network": ({"hidden": [100] * 4}, ("carl",)),
}
"""Differences of avo from avo-paper, each undone alone: the settings, and the tasks on which that is done.

160 events are those of one iteration. The paper's networks for the other tasks cost ten times the time and more; on
alignment, with a minute of Pythia a cell, only what was found to matter there is undone.
"""

LARGER = {"population_size": 20, "events_per_theta": 512}
GROWING = {"growth": 1.5, "estimate": "regression"}
STARTED = {"initial_evidence": 50}
TUNING: dict[str, tuple[int, dict[str, Settings]]] = {
    "abc-smc": (
        4,
        {
            "as pyABC has it: 100 x 128, mode": {},
            "100 x 128, mean": {"estimate": "mean"},
            "100 x 128, regression": {"estimate": "regression"},
            "20 x 512, mean": {**LARGER, "estimate": "mean"},
            "20 x 512, regression": {**LARGER, "estimate": "regression"},
            "30 x 128, regression": {"population_size": 30, "estimate": "regression"},
            "30 x 128 growing, regression": {"population_size": 30, **GROWING},
            "20 x 256 growing, regression": {**LARGER, "events_per_theta": 256, **GROWING},
            "20 x 512 growing, regression": {**LARGER, **GROWING},
            "60 x 128 growing, regression": {"population_size": 60, **GROWING},
        },
    ),
    "bolfi": (
        2,
        {
            "as ELFI has it: 10 x 128": {},
            "50 x 128, log": {**STARTED, "log_distance": True},
            "50 x 512": {**STARTED, "events_per_theta": 512},
            "50 x 512, log": {**STARTED, "events_per_theta": 512, "log_distance": True},
            "50 x 512, regression": {**STARTED, "events_per_theta": 512, "regression": True},
            "50 x 256 growing, log, regression": {
                **STARTED,
                **{"events_per_theta": 256, "growth": 8.0, "log_distance": True, "regression": True},
            },
        },
    ),
    "bsl": (
        2,
        {
            "4 chains, to 2048 events": {"chains": 4},
            "3 chains, to 1024 events": {},
            "2 chains, to 512 events": {"chains": 2},
        },
    ),
    "nre": (2, {"as it is": {}}),
    "nle": (2, {"as it is": {}}),
    "npe": (2, {"1250 sets of 128": {}, "312 sets of 512": {"events_per_set": 512}}),
    "tsnpe": (2, {"as it is": {}, "312 sets of 512": {"events_per_set": 512}}),
}
"""The number of development targets of each task, and the settings that were tried under their names in the table, by
method. The first settings of abc-smc and bolfi are the paper's. N x M is a population, or initial evidence, of N
parameters with M events each. The other methods have fewer targets because they take ten times as long as ABC-SMC."""

READINGS = {"d": {"r1_of": "probability"}, "logit": {"r1_of": "logit"}}
"""The function whose input gradient R1 penalises."""
PENALTIES = (0.1, 1.0, 10.0)
NARROW = {"hidden": [64, 64]}
"""A network that takes an eighth of the time of the paper's on poisson."""
FASTER = {**NARROW, "batch_size": 128, "proposal_learning_rate": 1e-2}
"""A quarter of the iterations, each of the proposal ten times as far."""
ONE_AT_A_TIME: dict[str, Settings] = {
    "M = 32": {"batch_size": 32},
    "M = 512": {"batch_size": 512},
    "shared": {"schedule": "shared"},
    "rate of d 1e-4": {"learning_rate": 1e-4},
    "rate of d 1e-2": {"learning_rate": 1e-2},
    "rate of q 1e-3": {"proposal_learning_rate": 1e-3},
    "rate of q 1e-1": {"proposal_learning_rate": 1e-1},
}
COMBINED = (
    (64, 1.5e-3, "logit", 0.1, None),
    (128, 3e-3, "d", 0.1, None),
    (128, 3e-3, "logit", 0.1, None),
    (128, 3e-3, "logit", 1.0, None),
    (128, 3e-3, "logit", 0.1, 3e-3),
    (256, 5e-3, "logit", 0.1, None),
    (256, 5e-3, "logit", 0.1, 3e-3),
    (512, 5e-3, "logit", 0.1, None),
    (512, 1e-2, "logit", 0.1, None),
    (512, 5e-3, "logit", 0.1, 3e-3),
)
"""Sizes of a batch, rates of the proposal, readings of R1, values of lambda and, where it is not the printed one, rates
of the discriminator, that are tried together with the schedule `shared`."""


def _penalised(what: str, base: Settings) -> dict[str, Settings]:
    return {
        f"{what}, R1 of {of}, {penalty:g}": {**base, **reading, "r1": penalty}
        for of, reading in READINGS.items()
        for penalty in PENALTIES
    }


def _combined(m: int, rate: float, of: str, penalty: float, rate_of_d: float | None) -> tuple[str, Settings]:
    label = f"shared, M = {m}, rate of q {rate:g}, R1 of {of}, {penalty:g}"
    settings = {**NARROW, "schedule": "shared", "batch_size": m, "proposal_learning_rate": rate, **READINGS[of]}
    settings["r1"] = penalty
    if rate_of_d is None:
        return label, settings
    return f"{label}, rate of d 3e-3", {**settings, "learning_rate": rate_of_d}


ALONE: dict[str, Settings] = {
    "as printed, R1 of d, 10": {},
    "as printed, R1 of logit, 10": READINGS["logit"],
    "as printed, no R1": {"r1": 0.0},
    "narrow, no R1": {**NARROW, "r1": 0.0},
    **_penalised("narrow", NARROW),
    "faster, no R1": {**FASTER, "r1": 0.0},
    **_penalised("faster", FASTER),
    **{
        f"faster, R1 of {of}, 1, {label}": {**FASTER, **reading, "r1": 1.0, **settings}
        for of, reading in READINGS.items()
        for label, settings in ONE_AT_A_TIME.items()
    },
}
"""Settings of plain Algorithm 1 that are tried on one development target, by what the table calls them. *Narrow* and
*faster* are NARROW and FASTER, the number after R1 is lambda, M the size of a batch, d the discriminator and q the
proposal; what is not named is as printed."""
SENSITIVITY = [(label, settings, 1) for label, settings in ALONE.items()]
SENSITIVITY += [(*_combined(*each), 2) for each in COMBINED]

DIMENSIONS = (2, 5, 10, 20, 32)
LARGEST = tuple(map(tasks.spec, (tasks.Warped32, tasks.Means32)))
"""The tasks of 32 parameters, of which `avo` and the methods without a network are tried on two targets."""
FAMILIES = ("warped", "means")
"""Tasks in which the mean of an event says nothing of the parameters, and in which it says all."""
DETECTOR = "alignment-3"
REACHED = {
    "smm": (2, 5, 10, 20),
    "rank-moments": (2, 5, 10, 20),
    "avo": (2, 5, 10, 20),
    "abc-smc-tuned": (2, 5, 10, 20),
    "bolfi-tuned": (2, 5, 10),
}
"""The numbers of parameters with which each method is tried. A cell of bolfi with the paper's settings takes 16 minutes
with 5."""

OF_SBI = ("npe", "nre", "nle")
"""Methods of sbi, which are tried where means say little."""
GROWTH_TASKS = (*CHEAP, *BEYOND_MEANS, *map(tasks.spec, (*HARD, *SBIBM)))
BUDGETS = (40_000, BUDGET, 1_000_000)
"""Simulated events of the same cells: whether more of them help."""


def _families(method: str) -> tuple[str, ...]:
    at_the_detector = (DETECTOR,) if method in ("smm", "avo") else ()  # they alone reach its limit along the beam
    return (*(f"{family}-{p}" for p in REACHED[method] for family in FAMILIES), *at_the_detector)


EXPERIMENTS = {
    "reference": Experiment(
        "the paper's comparison (Section 4.3), and avo",
        Path("results/reference"),
        (*on(PAPERS, "avo", repetitions=3), *on(PAPERS, "avo-paper", "abc-smc", "bolfi")),
    ),
    "rivals": Experiment(
        "further methods, and the rivals at their best, on the benchmark's targets",
        Path("results/rivals"),
        (
            *on(PAPERS, "abc-smc-tuned", "bolfi-tuned"),
            *on(CHEAP, "bsl", "nre", "nle", "npe", "tsnpe"),
            Runs("tsnpe, sets of 512", "tsnpe", {"events_per_set": 512}, CHEAP),
        ),
    ),
    "smm": Experiment(
        "the baselines without a network on the benchmark's targets",
        Path("results/smm"),
        on(PAPERS, "smm", "rank-moments"),
    ),
    "plain": Experiment(
        "plain Algorithm 1 at its best on the benchmark's targets", Path("results/plain"), on(PAPERS, "avo-plain")
    ),
    "poisson": Experiment(
        "the example of Section 4.1",
        Path("results/studies"),
        tuple(
            Runs(label, "avo-paper", settings, (tasks.spec(tasks.PoissonExample),), 1, 5, budget=3000 * 32)
            for label, settings in POISSON_VARIANTS.items()
        ),
    ),
    "alignment": Experiment(
        "the example of Section 4.2",
        Path("results/studies"),
        (
            Runs(
                "", "avo-paper", {"schedule": "shared"}, (tasks.spec(tasks.AlignmentExample),), 1, 10, budget=5000 * 32
            ),
        ),
    ),
    "summary": Experiment(
        "the rivals on alignment with a better summary statistic",
        Path("results/studies"),
        on((tasks.spec(tasks.AlignmentRows),), "abc-smc", "bolfi", targets=5),
    ),
    "reading": Experiment(
        "avo-paper as the paper can also be read: 5 000 iterations, and the baseline as printed",
        Path("results/studies"),
        (
            Runs("5 000 x 32", "avo-paper", OTHER_READING, ("poisson", "carl"), 5),
            Runs("5 000 x 32", "avo-paper", OTHER_READING, ("weinberg",), 1),  # half an hour, its largest network
        ),
    ),
    "ablation": Experiment(
        "avo with what sets it apart from avo-paper undone, one difference at a time",
        Path("results/ablation"),
        tuple(Runs(label, "avo", settings, names, 5) for label, (settings, names) in ABLATIONS.items()),
    ),
    "tuning": Experiment(
        "the candidates for the settings of the rivals at their best, on development targets",
        Path("results/tuning"),
        tuple(
            Runs(label, method, settings, tuple(DEVELOPMENT.values()), targets)
            for method, (targets, candidates) in TUNING.items()
            for label, settings in candidates.items()
        ),
        DEVELOPMENT_SEED,
    ),
    "sensitivity": Experiment(
        "the candidates for the settings of avo-plain, on development targets",
        Path("results/sensitivity"),
        tuple(
            Runs(label, "avo-paper", settings, (DEVELOPMENT["poisson"], DEVELOPMENT["carl"]), targets)
            for label, settings, targets in SENSITIVITY
        ),
        DEVELOPMENT_SEED,
    ),
    "dimension": Experiment(
        "methods against the number of parameters",
        Path("results/dimension"),
        (
            *(Runs(method, method, {}, _families(method), 5) for method in REACHED),
            *on(LARGEST, "smm", "rank-moments", "avo", targets=2),
            *on(BEYOND_MEANS, *OF_SBI, targets=3),
        ),
    ),
    "growth": Experiment(
        "whether errors fall with the simulated events, up to a million of them",
        Path("results/growth"),
        tuple(
            run
            for budget in BUDGETS
            for run in on(GROWTH_TASKS, "avo", "rank-moments", "smm", targets=4, budget=budget)
        ),
    ),
    "fresh": Experiment(
        "avo and its baselines on fresh targets, up to a hundred of each task of the paper",
        Path("results/fresh"),
        (
            *on(tuple(map(tasks.spec, tasks.FRESH)), "smm", "rank-moments", "avo", targets=100),
            *on(tuple(map(tasks.spec, tasks.FRESH_WARPED)), "smm", "rank-moments", "avo"),
        ),
    ),
}
