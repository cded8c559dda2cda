"""What effects look like, learnt from a grammar of them: `python -m paper.studies.experience FOLDER`.

Examples are measured events of random simulators with what a random sentence of `paper.grammar` does to them, each seen
beside its simulator with theta fitted. They are kept in FOLDER, a file for each PART of them, which a later call does
not make again. With `--install` the networks that learn from them are written where a diagnosis reads them.
"""

import io
from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property, partial
from pathlib import Path
from typing import get_args

import click
import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2
from sklearn.neural_network import MLPClassifier
from sklearn.preprocessing import StandardScaler

from avobench.bench.store.files import write_atomically
from avobench.cli.main import main
from avobench.diagnosis import experience
from avobench.diagnosis.experience.recogniser import Kind, compressed, portrait
from avobench.diagnosis.settings import RECOGNITION
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from paper.grammar.counts import COUNTS
from paper.grammar.functions import log_uniform
from paper.grammar.reals import REALS
from paper.grammar.simulators import simulator

Array = NDArray[np.float64]

PART = 100
"""Draws of a file, of which those are kept that show anything."""
SENTENCES = 10
"""About each random simulator at a random theta: the way in which theta moves its events is then known."""
NUM_EVENTS = (300, 20_000)
"""Log-uniform."""
TWO = 0.1
"""Share of the draws with two sentences, one after the other."""
NEARBY = 10_000
"""Events at each theta, from which the way in which theta moves them is taken."""
STEP = 0.1
"""Of theta for that, in widths of the prior to either side."""
STEPS = 4
"""Of the fit of theta."""
BINS = np.linspace(0, 1, 31)[1:-1]
"""Quantiles of the simulated events between which measured ones are counted in the fit."""
SHOWN = 1e-3
"""p-value of a fit above which an example shows nothing."""
NETWORKS = 4
"""Number of networks whose probabilities are averaged."""
UNITS = (128, 64)
"""Units of the hidden layers of each network."""


@dataclass(frozen=True)
class Examples:
    """Portraits, and the sentences that they show: their parts in the order in which they acted, or one twice."""

    portraits: NDArray[np.float32]
    """(m, f)"""
    families: NDArray[np.str_]
    """(m, 2)"""
    sentences: NDArray[np.str_]
    """(m, 2): primitive, what it goes by, and the class of the function, with blanks between."""
    simulators: NDArray[np.str_]
    """(m,)"""

    @classmethod
    def read(cls, path: Path) -> "Examples":
        with np.load(path) as stored:
            return cls(*(stored[field.name] for field in fields(cls)))

    def write(self, path: Path) -> None:
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **{field.name: getattr(self, field.name) for field in fields(self)})
        write_atomically(path, buffer.getvalue())

    @classmethod
    def joined(cls, parts: "list[Examples]") -> "Examples":
        """The examples of several files, as one."""
        return cls(*(np.concatenate([getattr(each, field.name) for each in parts]) for field in fields(cls)))

    def where(self, rows: NDArray[np.bool_]) -> "Examples":
        """Those of some rows (m,)."""
        return Examples(*(getattr(self, field.name)[rows] for field in fields(self)))


@dataclass(frozen=True)
class Nearby:
    """A simulator near a theta, which is fitted to measured events by how it moves their shares of bins."""

    task: Task
    theta: Array
    """(p,)"""
    reference: NDArray
    """Events at theta (m, d)."""

    @cached_property
    def edges(self) -> list[Array]:
        return [np.unique(np.quantile(column, BINS)) for column in self.reference.T]

    def shares(self, x: NDArray) -> Array:
        """Of events (n, d) in the bins of each feature, and in coarse cells of each pair of them: (k,)."""
        at = [np.searchsorted(edges, column, "right") for edges, column in zip(self.edges, x.T, strict=True)]
        sizes = [len(edges) + 1 for edges in self.edges]
        tables = [np.bincount(one, minlength=size) for one, size in zip(at, sizes, strict=True)]
        coarse = [4 * one // size for one, size in zip(at, sizes, strict=True)]
        pairs = [(i, j) for i in range(len(at)) for j in range(i)]
        tables += [np.bincount(4 * coarse[i] + coarse[j], minlength=16) for i, j in pairs]
        return np.concatenate(tables) / len(x)

    @cached_property
    def expected(self) -> Array:
        return self.shares(self.reference) + 1 / len(self.reference)

    @cached_property
    def slopes(self) -> Array:
        """Of the shares, in their errors, with theta in widths of the prior: (k, p)."""
        moved = []
        for k in range(len(self.theta)):
            to_either_side = [
                self.theta + side * STEP * self.task.prior.width * np.eye(len(self.theta))[k] for side in (1, -1)
            ]
            up, down = (self.shares(self.events(theta, NEARBY, np.random.default_rng(0))) for theta in to_either_side)
            moved.append((up - down) / (2 * STEP))
        return np.stack(moved, axis=1) / np.sqrt(self.expected)[:, None]

    def events(self, theta: Array, n: int, rng: np.random.Generator) -> NDArray:
        """Simulated events at a theta (p,), or where the support ends on the way to it: (n, d)."""
        return self.task.simulate(np.tile(np.clip(theta, self.task.support.low, self.task.support.high), (n, 1)), rng)

    def beside(self, x: NDArray, rng: np.random.Generator) -> tuple[NDArray, float]:
        """Simulated events at the theta that describes events (n, d) best, by Gauss and Newton, and its p-value.

        Features are taken as independent of each other in the p-value, which is good enough to say what shows nothing.
        """
        best, theta, step = (np.inf, self.reference), self.theta, np.zeros_like(self.theta)
        measured, at = self.shares(x), self.theta
        for _ in range(STEPS):
            simulated = self.events(at, max(RECOGNITION.simulated * len(x), NEARBY), rng)
            pull = (measured - self.shares(simulated)) / np.sqrt(self.expected)
            left = float(pull @ pull / (1 / len(x) + 1 / len(simulated)))
            if left < best[0]:
                best, theta = (left, simulated), at
                step = np.linalg.lstsq(self.slopes, pull, rcond=1e-3)[0] * self.task.prior.width
            else:
                step = step / 3
            at = theta + step
        cells = sum(len(edges) for edges in self.edges) + 9 * len(self.edges) * (len(self.edges) - 1) // 2
        return best[1][: RECOGNITION.simulated * len(x)], float(chi2.sf(best[0], max(cells - len(self.theta), 1)))


def examples(kind: Kind, rng: np.random.Generator, draws: int = PART) -> Examples:
    """What so many random draws show, where they show anything."""
    rows = [row for _ in range(draws // SENTENCES) for row in of_simulator(kind, rng)]
    portraits, families, sentences, simulators = zip(*rows, strict=True)
    return Examples(np.array(portraits, np.float32), *map(np.array, (families, sentences, simulators)))


def of_simulator(kind: Kind, rng: np.random.Generator) -> Iterator[tuple]:
    """The examples of a random simulator at a random theta: their portraits, families, sentences and its name."""
    task, grammar = simulator(kind, rng), COUNTS if kind == "count" else REALS
    theta = task.prior.sample(1, rng)[0]
    near = Nearby(task, theta, task.simulate(np.tile(theta, (NEARBY, 1)), rng))
    for _ in range(SENTENCES):
        said = [grammar.sentence(task, near.reference, rng) for _ in range(1 + (rng.random() < TWO))]
        measure = task.simulate
        for each in said:
            measure = partial(each.act, measure)
        n = int(log_uniform(*NUM_EVENTS, rng))
        x = measure(np.tile(theta, (n, 1)), rng)
        simulated, p_value = near.beside(x, rng)
        if p_value < SHOWN:
            told = [(each.family, f"{each.primitive} {each.by} {each.function}") for each in (said[0], said[-1])]
            yield portrait(x, simulated, kind == "count"), *zip(*told, strict=True), task.name


def trained(known: Examples) -> tuple[list[str], list[list[tuple[NDArray, NDArray]]]]:
    """Families, and networks that tell them by a portrait: their layers, with the scale of marks in the first."""
    alone = known.families[:, 0] == known.families[:, 1]
    rows = np.r_[np.arange(len(alone)), np.flatnonzero(~alone)]
    labels = np.r_[known.families[:, 0], known.families[~alone, 1]]
    marks = compressed(known.portraits[rows])
    scaler = StandardScaler().fit(marks)
    networks = []
    for seed in range(NETWORKS):
        network = MLPClassifier(UNITS, alpha=0.01, early_stopping=True, n_iter_no_change=8, random_state=seed)
        network.fit(scaler.transform(marks), labels)
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


def make(kind: Kind, k: int, folder: Path) -> None:
    """The k-th file of examples in a folder, unless it is there."""
    path = folder / f"{kind}-{k}.npz"
    if not path.exists():
        examples(kind, np.random.default_rng([get_args(Kind).index(kind), k])).write(path)


def read(kind: Kind, folder: Path) -> Examples:
    """All examples of a folder with such events. Raises UsageError if there are none."""
    paths = sorted(folder.glob(f"{kind}-*.npz"))
    if not paths:
        raise UsageError(f"there are no examples in {folder}: `python -m paper.studies.experience {folder}` makes them")
    return Examples.joined([Examples.read(path) for path in paths])


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--parts", default=160, show_default=True, help=f"Files of {PART} draws each, of each kind of events.")
@click.option("--install/--no-install", "installs", default=False, help="Train on all examples, for all diagnoses.")
def learn(folder: Path, parts: int, installs: bool) -> None:
    """Make what is missing of the examples in FOLDER. `paper.studies.recognised` says what they teach."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(parts):  # of each kind in turn, so that a call that is stopped leaves as much of each
        for kind in get_args(Kind):
            make(kind, k, folder)
    for kind in get_args(Kind) if installs else ():
        click.echo(install(kind, *trained(read(kind, folder))))


if __name__ == "__main__":
    main(learn)
