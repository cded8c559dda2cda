"""One data set with a simulator of it, and the answer that was written down before any diagnosis was made."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task

Kind = Literal["null", "single", "pair", "outside"]
Group = Literal["counts", "one feature", "several features"]
Events = Callable[[np.random.Generator], NDArray]


@dataclass(frozen=True)
class Case:
    """A data set, the simulator that it is compared with, and what is missing in that simulator.

    A name without a feature in `right` or `defensible` stands for the effect on any feature of the events. A pair names
    in `right` its two effects, of which each is right as a first answer.
    """

    name: str
    task: Task
    events: Events
    """The events (N, d) or (N,), drawn from a generator; measured ones take no notice of it."""
    why: str
    """What happened to the events, and why these names tell it."""
    right: tuple[str, ...] = ()
    """Names that are right as a first one, as `effect` or `effect on feature`; none where nothing is missing."""
    defensible: tuple[str, ...] = ()
    """Names that tell a part of it, or the same less well."""
    pair: bool = False
    """Whether the two names that are right are two effects."""

    def x(self) -> NDArray:
        """The events (N, d) or (N,), the same in each call."""
        return self.events(np.random.default_rng(list(self.name.encode())))

    @property
    def kind(self) -> Kind:
        if not self.right:
            return "null"
        return "pair" if self.pair else "outside" if self.right == ("outside",) else "single"

    @property
    def group(self) -> Group:
        """What the events are."""
        if self.task.num_features > 1:
            return "several features"
        return "counts" if "count" in self.task.kinds_of_features else "one feature"


def case(
    task: Task, kind: Kind = "null", right: tuple[str, ...] = (), defensible: tuple[str, ...] = ()
) -> Callable[[Events], Case]:
    """Make a case from a function of a generator: its name is the case's, and its docstring says what happened."""
    answer = ("outside",) if kind == "outside" else right

    def make(events: Events) -> Case:
        why = " ".join((events.__doc__ or "").split())
        return Case(events.__name__, task, events, why, answer, defensible, kind == "pair")

    return make


def draw(task: Task, rng: np.random.Generator, n: int, *theta: float) -> NDArray:
    """Return n events of a task at one point."""
    return task.simulate(np.tile(np.asarray(theta, dtype=float), (n, 1)), rng)


def one(of: Task, rng: np.random.Generator, n: int, *theta: float) -> NDArray:
    """Return n events (n,) of a task of one feature at one point."""
    return draw(of, rng, n, *theta)[:, 0]


def reader(module: str) -> Callable[..., NDArray]:
    """Return what reads the columns of a CSV file in `data` beside this module: (n,), or (n, d) of several."""

    def read(name: str, *, counts: bool = False) -> NDArray:
        x = np.loadtxt(Path(module).parent / "data" / f"{name}.csv", delimiter=",", skiprows=1)
        return x.astype(int) if counts else x

    return read


def plain(name: str, of: Task, n: int, *theta: float) -> Case:
    """Return a case in which nothing is missing: n events of a task at one point."""

    def events(rng: np.random.Generator) -> NDArray:
        """Nothing is missing."""
        return draw(of, rng, n, *theta)

    events.__name__ = name
    return case(of)(events)


def some(rng: np.random.Generator, n: int, share: float) -> NDArray:
    """Return which of n events are hit, each with the same chance."""
    return rng.random(n) < share


def either(hit: NDArray, there: NDArray, here: NDArray) -> NDArray:
    """Return the rows of the first events where hit, and those of the second where not."""
    return np.where(hit[:, None], there, here)
