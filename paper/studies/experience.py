"""What effects look like, learnt from random examples: `python -m paper.studies.experience FOLDER`.

Examples are measured events with hidden shapes that have been seen and with the catalogue's own, on tasks and on small
simulators, at random theta, strengths and numbers of events, each seen beside its simulator as the first
fit of a diagnosis finds it. They are kept in FOLDER, a file for each simulator, which a later call does not make again.
The networks that learn from them are written where a diagnosis reads them. It takes three hours of one processor.
"""

import io
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import get_args

import joblib
import numpy as np
from numpy.typing import NDArray
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from avobench.bench.plugins import registry
from avobench.bench.store.files import write_atomically
from avobench.challenge.hide import NUM_REFERENCE, OwnShape
from avobench.challenge.shape import Injection, Place, Shape
from avobench.diagnosis import experience
from avobench.diagnosis.effort import effort_for
from avobench.diagnosis.experience.recogniser import Kind, compressed, kind_of, portrait
from avobench.diagnosis.fit.null import fit_null
from avobench.diagnosis.settings import RECOGNITION
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.meter import Meter
from paper.studies.simulators import SIMULATORS
from shapes import SEEN

ROUNDS = {"poisson": 36, "weinberg": 22, "carl": 20, "correlated": 4, "mixed": 4, "chain": 4}
"""Over all shapes, by simulator; USUAL_ROUNDS of others."""
USUAL_ROUNDS = 8
"""Fewer than of tasks, since there are many of them."""
LEARNT_FROM = ("carl", "weinberg", "poisson", *SIMULATORS)
"""The simulators, slowest first."""
OWN = 3
"""Examples of each family in the catalogue's own shapes, per round."""
TWO = 40
"""Examples with two hidden shapes, per round."""
NUM_EVENTS = (300, 50_000)
"""Log-uniform."""
LIKE_THERE = 0.7
"""Share of the examples on tasks of the challenge that have the most events, as many as there."""
SHOWN = 1e-3
"""p-value of an example above which it shows nothing."""
NETWORKS = 4
"""Number of networks whose probabilities are averaged."""
UNITS = (128, 64)
"""Units of the hidden layers of each network."""
COPIES = 3
"""Copies of each example. All but one are blurred, because other simulators differ."""
BLURRED = 0.3
"""Noise of a blurred copy, in standard deviations of each mark."""

Measure = Callable[[Callable, NDArray[np.float64], np.random.Generator], NDArray]
"""Events of a simulator with an effect: simulate, theta (n, p), rng -> (n, d)."""


@dataclass(frozen=True)
class Examples:
    """Portraits, and what they show."""

    portraits: NDArray[np.float32]
    """(m, f)"""
    families: NDArray[np.str_]
    """(m, 2): of both hidden effects, the same twice where there is one."""

    @classmethod
    def read(cls, path: Path) -> "Examples":
        with np.load(path) as stored:
            return cls(stored["portraits"], stored["families"])

    def write(self, path: Path) -> None:
        buffer = io.BytesIO()
        np.savez_compressed(buffer, portraits=self.portraits, families=self.families)
        write_atomically(path, buffer.getvalue())

    @classmethod
    def joined(cls, parts: "list[Examples]") -> "Examples":
        """The examples of several simulators, as one."""
        columns = ([getattr(each, name) for each in parts] for name in ("portraits", "families"))
        return cls(*(np.concatenate(column) for column in columns))


def named(simulator: str) -> Task:
    """A small simulator, or a task."""
    return SIMULATORS[simulator] if simulator in SIMULATORS else registry.build("task", simulator, {})


def examples(simulator: str, rounds: int, rng: np.random.Generator, shapes: Sequence[Shape] = SEEN) -> Examples:
    """Random examples of all `shapes` and of the catalogue's own, where they show anything."""
    task = named(simulator)
    reference = task.simulate(task.prior.sample(NUM_REFERENCE, np.random.default_rng(0)), np.random.default_rng(0))
    shapes = [shape for shape in shapes if any(shape.suits(place) for place in places(task, reference))]
    portraits, families = [], []

    def add(make: Callable[[NDArray], Measure | None], names: tuple[str, str]) -> None:
        seen = seen_of(task, make, rng, simulator in SIMULATORS)
        if seen is not None:
            portraits.append(seen)
            families.append(names)

    for _ in range(rounds):
        for shape in shapes:
            add(partial(foreign, task, shape, rng), (shape.family, shape.family))
        for name in dict.fromkeys(effect.name for effect in catalogue(task)):
            for _ in range(OWN):
                add(partial(own, task, name, rng), (name, name))
        for _ in range(TWO):
            one, other = (shapes[k] for k in rng.integers(len(shapes), size=2))
            if one.family != other.family:
                add(partial(both, task, one, other, rng), (one.family, other.family))
    return Examples(np.array(portraits, np.float32), np.array(families))


def places(task: Task, reference: NDArray) -> list[Place]:
    """All places where an effect may act on the events of a task, of which `reference` (m, d) are some."""
    everywhere = [None, *range(task.num_features), *(["all"] if task.num_features > 1 else [])]
    return [Place(task, at, reference) for at in everywhere]


def seen_of(
    task: Task, make: Callable[[NDArray], Measure | None], rng: np.random.Generator, small: bool
) -> NDArray[np.float64] | None:
    """The portrait (f,) of events with the effect that `make` makes of a reference; None where nothing shows."""
    low, high = NUM_EVENTS
    n = high if not small and rng.random() < LIKE_THERE else int(np.exp(rng.uniform(np.log(low), np.log(high))))
    theta = task.prior.sample(1, rng)[0]
    measure = make(task.simulate(np.tile(theta, (NUM_REFERENCE, 1)), rng))
    if measure is None:
        return None
    seen, p_value = beside(task, measure(task.simulate, np.tile(theta, (n, 1)), rng), rng)
    return seen if p_value <= SHOWN else None


def beside(task: Task, x: NDArray, rng: np.random.Generator) -> tuple[NDArray[np.float64], float]:
    """The portrait (f,) of events (n, d) beside the task as a first fit finds it, and the p-value of that fit."""
    model = Model(task, events=Counted(task, Meter()))
    fit, _ = fit_null(model, x, rng, effort_for(task, domain(task), None, len(x)), None)
    m = max(RECOGNITION.simulated * len(x), NUM_REFERENCE)
    return portrait(x, task.simulate(np.tile(fit.params, (m, 1)), rng), kind_of(task) == "count"), fit.p_value


def foreign(task: Task, shape: Shape, rng: np.random.Generator, reference: NDArray) -> Measure | None:
    """A hidden shape of random strength at a random place; None where it suits none."""
    injection = placed(task, shape, rng, reference)
    return injection and injection.measure


def placed(task: Task, shape: Shape, rng: np.random.Generator, reference: NDArray) -> Injection | None:
    """The shape itself."""
    suited = [place for place in places(task, reference) if shape.suits(place)]
    return shape.draw(suited[rng.integers(len(suited))], rng) if suited else None


def own(task: Task, name: str, rng: np.random.Generator, reference: NDArray) -> Measure:
    """An effect of the catalogue's own shapes."""
    return OwnShape.draw([effect for effect in catalogue(task, reference) if effect.name == name], rng).measure


def both(task: Task, one: Shape, other: Shape, rng: np.random.Generator, reference: NDArray) -> Measure | None:
    """Two hidden shapes, in the order in which they would act."""
    injections = [placed(task, shape, rng, reference) for shape in (one, other)]
    if None in injections:
        return None
    first, second = sorted(injections, key=lambda each: each.stage)

    def measure(simulate: Callable, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return second.measure(partial(first.measure, simulate), theta, rng)

    return measure


def trained(known: Examples) -> tuple[list[str], list[list[tuple[NDArray, NDArray]]]]:
    """Families, and networks that tell them by a portrait: their layers, with the scale of marks in the first."""
    rng = np.random.default_rng(0)
    alone = known.families[:, 0] == known.families[:, 1]
    rows = np.r_[np.arange(len(alone)), np.flatnonzero(~alone)]
    labels = np.r_[known.families[:, 0], known.families[~alone, 1]]
    marks = compressed(known.portraits[rows])
    blurred = [marks + BLURRED * marks.std(axis=0) * rng.normal(size=marks.shape) for _ in range(COPIES - 1)]
    scaler = StandardScaler().fit(marks)
    inputs, labels = scaler.transform(np.concatenate([marks, *blurred])), np.tile(labels, COPIES)
    networks = []
    for seed in range(NETWORKS):
        network = MLPClassifier(UNITS, alpha=0.01, early_stopping=True, n_iter_no_change=8, random_state=seed)
        network.fit(inputs, labels)
        (weights, biases), *others = zip(network.coefs_, network.intercepts_, strict=True)
        first = weights / scaler.scale_[:, None]
        networks.append([(first, biases - scaler.mean_ @ first), *others])
    return network.classes_.tolist(), networks


def install(kind: Kind, families: list[str], networks: list[list[tuple[NDArray, NDArray]]]) -> Path:
    """Write networks where a diagnosis reads them."""
    layers = [layer for network in networks for layer in network]
    arrays = {
        f"{part}{k}": layer[at].astype(np.float32) for k, layer in enumerate(layers) for at, part in enumerate("wb")
    }
    buffer = io.BytesIO()
    np.savez_compressed(buffer, families=families, layers=[len(network) for network in networks], **arrays)
    path = Path(experience.__file__).with_name(f"{kind}.npz")
    write_atomically(path, buffer.getvalue())
    return path


def made(simulator: str, number: int, folder: Path) -> Path:
    """The examples of a simulator in a file of the folder, made where they are not there yet."""
    path = folder / f"{simulator}.npz"
    if not path.exists():
        examples(simulator, ROUNDS.get(simulator, USUAL_ROUNDS), np.random.default_rng(number)).write(path)
        print(path, flush=True)
    return path


def learnt(folder: Path) -> list[Path]:
    """Make what is missing of the examples, and train on all; the paths of the networks."""
    folder.mkdir(parents=True, exist_ok=True)
    joblib.Parallel(n_jobs=-1)(joblib.delayed(made)(each, k, folder) for k, each in enumerate(LEARNT_FROM))
    return [install(kind, *trained(of_kind(kind, folder))) for kind in get_args(Kind)]


def of_kind(kind: Kind, folder: Path) -> Examples:
    """The examples of all simulators with such events, of a folder. Raises UsageError if one is missing."""
    paths = [folder / f"{each}.npz" for each in LEARNT_FROM if kind_of(named(each)) == kind]
    if missing := [str(path) for path in paths if not path.exists()]:
        raise UsageError(f"there is no {missing[0]}: `python -m paper.studies.experience {folder}` makes it")
    return Examples.joined([Examples.read(path) for path in paths])


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("say in which folder the examples are to be kept")
    for path in learnt(Path(sys.argv[1])):
        print(path)
