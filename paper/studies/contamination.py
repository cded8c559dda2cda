"""What a share of outliers does to each method: squared errors to the parameters of the other events.

The observed events are of a simulator at theta, but for a share of them that it hardly makes: contamination as Huber
has it (Annals of Mathematical Statistics 35 (1964) 73). An estimator of the minimiser of the Jensen-Shannon divergence,
which is what the paper promises, hardly moves; one that matches means moves by the share times the distance.
"""

import time
from collections.abc import Callable, Collection
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import rel_entr
from scipy.stats import norm, poisson
from scipy.stats import t as student

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.streams import stream
from avobench.bench.plugins import registry
from avobench.challenge.hide import OWN_RANGE
from avobench.effects.catalogue import catalogue
from avobench.effects.contract import Effect, Parameter
from avobench.methods import Method
from avobench.tasks import Task
from avobench.tasks.alignment import NUM_COLUMNS, NUM_ROWS
from avobench.tasks.function import task
from avobench.tasks.weinberg import Weinberg, sample_cosine
from paper.experiments import BUDGET, NUM_OBSERVATIONS
from paper.studies.files import StudyFile

FILE = StudyFile("contamination")
SHARES = (0.0, 0.01, 0.05, 0.2)
"""Shares of the observed events that are outliers."""
NUM_TARGETS = 3
"""The first targets of each task. One takes a quarter of an hour of a processor beside what is made of the first one
alone: with a larger number the study goes on."""
TINY = 1e-250
"""Density below which both are taken as zero, before numbers underflow."""
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "smm": ("smm", {}),
    "trimmed": ("smm", {"trim": 0.1}),
    "rank-moments": ("rank-moments", {}),
    "avo": ("avo", {}),
    "avo-robust": ("avo", {"matched": "divergence"}),
    "adversary alone": ("avo", {"polish": False}),
    "avo-robust, no adversary": ("avo", {"matched": "divergence", "iterations": 1}),
    "learnt-moments": ("avo", {"iterations": 1}),
    "abc-smc": ("abc-smc", {}),
    "bolfi": ("bolfi", {}),
    "npe": ("npe", {}),
    "nre": ("nre", {}),
    "nle": ("nle", {}),
}
"""The method and its settings behind each row. With one iteration there is no adversary to speak of."""
ROWS_OF_IMAGES = tuple(row for row in METHODS if row not in ("trimmed", "npe", "nre", "nle"))
"""The rows that are made of alignment, of its first target: a run takes two minutes, most of them with Pythia. What is
left out has no form for images, or takes hours."""
ROWS_OF_ONE_TARGET = ("npe", "nre", "nle")
"""The rows that are made of the first target alone: a run takes up to three minutes, most of them with networks."""
ROWS_OF_EFFECTS = ("smm", "trimmed", "rank-moments", "avo", "avo-robust")
"""The rows that are made of effects of the catalogue, of which there are many."""
NUM_DENSITY = 4_000_000
"""Events from which the density of those with an effect is taken: forty times the observed ones."""


def gaussian(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """x ~ N(theta, 1): (n, 1) -> (n, 1)."""
    return theta + rng.standard_normal(theta.shape)


def cosine_of_a_slope(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Events of density 3/8 (1 + x^2 + c x) on [-1, 1]: c (n, 1) -> (n,)."""
    return sample_cosine(theta[:, 0], rng)


class Contaminated(NamedTuple):
    """A task, what its outliers are, and the density of both where it is one-dimensional."""

    task: Task
    outliers: Callable[[int, np.random.Generator], NDArray] | None
    """n outliers: (n, d)."""
    points: NDArray[np.float64] | None = None
    """Where the densities are summed (m,)."""
    density: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]] | None = None
    """That of the simulator at points (m,) and theta (p,)."""
    density_of_outliers: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    shares: tuple[float, ...] = SHARES

    def minimiser(self, theta: NDArray[np.float64], share: float) -> NDArray[np.float64]:
        """Where the Jensen-Shannon divergence to the observed density is least (p,), by a sum over the points.

        Outliers of carl and alignment are where the simulator makes next to nothing, and leave theta (p,) itself.
        """
        if self.points is None or self.density is None or self.density_of_outliers is None or not share:
            return theta
        x, density, box = self.points, self.density, self.task.support
        r = (1 - share) * density(x, theta) + share * self.density_of_outliers(x)

        def divergence(theta: NDArray[np.float64]) -> float:
            if not box.contains(theta)[0]:
                return np.inf
            p = density(x, theta)
            return float((rel_entr(p, (p + r) / 2) + rel_entr(r, (p + r) / 2))[p + r > TINY].sum())

        return minimize(divergence, theta, method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-13}).x


def gaussian_of_a_width(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """x ~ N(mean, exp(log_width)): (n, 2) -> (n, 1)."""
    return rng.normal(theta[:, :1], np.exp(theta[:, 1:]))


HITS = 15
"""Mean number of cells that an image of alignment has."""
LOST, HOLE = 0.6, (0.5, 1.0)
"""The share of events that is lost, and where: in standard deviations above the mean."""


def holed(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Density of a standard Gaussian with a hole: (m,) -> (m,)."""
    kept = 1 - LOST * np.diff(norm.cdf(HOLE))[0]
    return norm.pdf(z) * np.where((z > HOLE[0]) & (z < HOLE[1]), 1 - LOST, 1) / kept


def left(x: NDArray[np.float64], mean: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """The events (n, 1) that the hole leaves."""
    z = x[:, 0] - mean
    return x[(z < HOLE[0]) | (z > HOLE[1]) | (rng.random(len(z)) > LOST)]


def far_end(n: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Images (n, 1024) whose hits, as many as those of alignment, are all in the last quarter of the rows."""
    images = np.zeros((n, NUM_ROWS, NUM_COLUMNS), np.uint8)
    images[:, -NUM_ROWS // 4 :] = rng.random((n, NUM_ROWS // 4, NUM_COLUMNS)) < HITS * 4 / (NUM_ROWS * NUM_COLUMNS)
    return images.reshape(n, -1)


def contaminated() -> dict[str, Contaminated]:
    """The tasks by name. Outliers of weinberg lie where it makes events as well, for it makes them everywhere.

    Those of carl and alignment are events that the simulator hardly makes.

    In `tails` all events are Student's, with 2.5 degrees of freedom, and the simulator is a Gaussian: it is wrong
    wherever it makes events. Outliers of `near` lie two standard deviations from the mean of `normal`. In `hole` all
    events are of that simulator, which lost three fifths of those between half a standard deviation and one above it.
    """
    shift = task(gaussian, prior={"theta": (-2, 2)}, features=["x"], name="normal")
    carl, weinberg = registry.build("task", "carl", {}), Weinberg()
    width = task(gaussian_of_a_width, prior={"mean": (-2, 2), "log_width": (-1, 1)}, features=["x"], name="tails")
    at = shift.targets()[0, 0]
    line, angle, counts = np.linspace(-10, 12, 20_001), np.linspace(-1, 1, 4001)[1:-1], np.arange(400.0)
    return {
        "normal": Contaminated(
            shift,
            lambda n, rng: rng.normal(6, 0.5, (n, 1)),
            *(line, lambda x, theta: norm.pdf(x, theta[0]), lambda x: norm.pdf(x, 6, 0.5)),
        ),
        "poisson": Contaminated(
            registry.build("task", "poisson", {}),
            lambda n, rng: rng.poisson(150, (n, 1)),
            *(counts, lambda x, theta: poisson.pmf(x, np.exp(theta[0])), lambda x: poisson.pmf(x, 150)),
        ),
        "carl": Contaminated(carl, lambda n, rng: rng.normal(15, 1, (n, 5))),
        "weinberg": Contaminated(
            weinberg,
            lambda n, rng: rng.uniform(0.85, 0.95, (n, 1)),
            *(angle, weinberg.density, lambda x: np.where((x > 0.85) & (x < 0.95), 10.0, 0.0)),
        ),
        "near": Contaminated(
            shift,
            lambda n, rng: rng.normal(at + 2, 0.5, (n, 1)),
            *(line, lambda x, theta: norm.pdf(x, theta[0]), lambda x: norm.pdf(x, at + 2, 0.5)),
            (0.05, 0.2),
        ),
        "hole": Contaminated(
            shift,
            lambda n, rng: left(at + rng.standard_normal((2 * n, 1)), at, rng)[:n],
            *(line, lambda x, theta: norm.pdf(x, theta[0]), lambda x: holed(x - at)),
            (1.0,),
        ),
        "tails": Contaminated(
            width,
            lambda n, rng: 0.4 + rng.standard_t(2.5, (n, 1)),
            np.linspace(-60, 60, 40_001),
            lambda x, theta: norm.pdf(x, theta[0], np.exp(theta[1])),
            lambda x: student.pdf(x - 0.4, 2.5),
            (0.0, 1.0),
        ),
        "alignment": Contaminated(registry.build("task", "alignment", {}), far_end, shares=(0.05, 0.2)),
    }


MIDDLING = float(np.sqrt(np.prod(OWN_RANGE)))
"""Share of the way from no effect to its largest strength: the middle, in logarithms, of what a challenge hides."""


def middle(parameter: Parameter, *, strength: bool) -> float:
    """A middling value of a parameter of an effect."""
    low, high, null = parameter.low, parameter.high, parameter.null
    if strength and null is not None:
        return null + MIDDLING * ((low if null == high else high) - null)
    return float(np.sqrt(low * high)) if parameter.logarithmic else (low + high) / 2


def with_effect(of: Contaminated, effect: Effect) -> Contaminated:
    """The task whose observed events all have an effect of middling strength, at its first target."""
    theta = of.task.targets()[0]
    phi = np.array([middle(each, strength=k == 0) for k, each in enumerate(effect.parameters)])

    def events(n: int, rng: np.random.Generator) -> NDArray:
        return effect.apply(of.task.simulate, np.tile(theta, (n, 1)), np.tile(phi, (n, 1)), rng)

    @cache
    def density() -> NDArray[np.float64]:
        rng, points = stream(0, "density", of.task.name, *map(str, effect.key), effect.shape), of.points
        step = points[1] - points[0]
        counts, _ = np.histogram(events(NUM_DENSITY, rng), np.append(points, points[-1] + step) - step / 2)
        return counts / (NUM_DENSITY * step)

    return of._replace(outliers=events, density_of_outliers=lambda x: density(), shares=(1.0,))


def with_effects() -> dict[str, Contaminated]:
    """Three simulators of one feature, each with every effect of the catalogue, by the names of both.

    They are `poisson`, the `gaussian` of a mean and a width, and `cosine`: weinberg with its coefficient c, which alone
    is determined there, as the parameter.
    """
    of_slope = {"prior": {"c": (-1.5, 1.5)}, "support": {"c": (-1.9, 1.9)}}
    cosine = task(cosine_of_a_slope, **of_slope, features=["x"], name="cosine")
    known = contaminated()
    simulators = {
        "poisson": known["poisson"],
        "gaussian": known["tails"],
        "cosine": Contaminated(
            cosine,
            *(None, np.linspace(-1.2, 1.2, 4801)),
            lambda x, theta: np.where(np.abs(x) <= 1, 3 / 8 * (1 + x**2 + theta[0] * x), 0.0),
        ),
    }
    found = {}
    for name, of in simulators.items():
        x = of.task.simulate(np.tile(of.task.targets()[0], (NUM_OBSERVATIONS, 1)), stream(0, "ranges", name))
        for effect in catalogue(of.task, x):
            words = f"{name}: {effect.name} {effect.feature if isinstance(effect.feature, str) else ''}".strip()
            found[words if words not in found else f"{words} {type(effect).__name__}"] = with_effect(of, effect)
    return found


def made(
    path: Path,
    seed: int = 0,
    tasks: Collection[str] = (),
    rows: Collection[str] = tuple(METHODS),
    num_events: int = NUM_OBSERVATIONS,
    budget: int = BUDGET,
) -> dict[str, Any]:
    """The record of the study at `path`, of which each run that is lacking is made and written at once.

    With `tasks` only those of these tasks and of the `rows`. `runs` holds for each the `task`, `share`, `target`, `row`
    and `version` of the method, what there was to find (`theta`, and `minimiser`), `estimate`, `error`, `doubt` and
    `seconds`. Raises StoreError for a damaged file.
    """
    methods = {
        row: registry.build("method", name, settings) for row, (name, settings) in METHODS.items() if row in rows
    }
    effects = with_effects()

    def due(name: str, target: int, row: str) -> bool:
        if tasks:
            return name in tasks
        if name == "alignment":
            return target == 0 and row in ROWS_OF_IMAGES
        if name in effects:
            return target == 0 and row in ROWS_OF_EFFECTS
        return target == 0 or row not in ROWS_OF_ONE_TARGET

    wanted = [
        (
            {"task": name, "share": share, "target": target, "row": row, "version": method.version},
            partial(one, name, of, share, target, row, method, seed, num_events, budget),
        )
        for target in range(NUM_TARGETS)
        for name, of in (contaminated() | effects).items()
        for row, method in methods.items()
        for share in of.shares
        if due(name, target, row)
    ]
    return FILE.completed(path, "runs", wanted, seed=seed, budget=budget, num_observations=num_events)


def one(
    name: str,
    of: Contaminated,
    share: float,
    target: int,
    row: str,
    method: Method,
    seed: int,
    num_events: int = NUM_OBSERVATIONS,
    budget: int = BUDGET,
) -> dict[str, Any]:
    """A run of a method on the events of a target of which a share is replaced; all methods see the same."""
    words = ("contamination", name, str(share), str(target))
    rng, theta = stream(seed, "observed", *words), of.task.targets()[target]
    x = of.task.simulate(np.tile(theta, (num_events, 1)), rng)
    replaced = rng.random(num_events) < share
    x[replaced] = of.outliers(int(replaced.sum()), rng)
    simulate = MeteredSimulator(of.task, budget, stream(seed, "simulator", *words))
    start = time.perf_counter()
    found = method.infer(pose(of.task, x, simulate), stream(seed, "method", *words, row))
    return {
        "theta": theta.tolist(),
        "minimiser": of.minimiser(theta, share).tolist(),
        "estimate": found.theta.tolist(),
        "error": None if found.error is None else found.error.tolist(),
        "doubt": found.doubt,
        "seconds": time.perf_counter() - start,
    }
