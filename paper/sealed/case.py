"""A case whose right answer is sealed: its kind, its group, and the decorator that writes one from a function."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from paper.foreign.case import Case

Kind = Literal["null", "single", "pair", "outside"]
Group = Literal["counts", "one feature", "several features"]
Events = Callable[[np.random.Generator], NDArray]


@dataclass(frozen=True)
class Sealed(Case):
    """A case with how many effects there are, and with what its events are.

    A name without a feature in `right` or `defensible` stands for the effect on any feature of the events. A pair names
    in `right` its two effects, of which each is right as a first answer.
    """

    kind: Kind = "null"
    group: Group = "counts"


def sealed(
    task: Task,
    group: Group,
    kind: Kind = "null",
    right: tuple[str, ...] = (),
    defensible: tuple[str, ...] = (),
) -> Callable[[Events], Sealed]:
    """Make a case from a function of a generator: its name is the case's, and its docstring says what happened."""
    answer = ("outside",) if kind == "outside" else right

    def make(events: Events) -> Sealed:
        why = " ".join((events.__doc__ or "").split())
        return Sealed(events.__name__, task, events, why, answer, defensible, kind, group)

    return make


def draw(task: Task, rng: np.random.Generator, n: int, *theta: float) -> NDArray:
    """Return n events of a task at one point."""
    return task.simulate(np.tile(np.asarray(theta, dtype=float), (n, 1)), rng)


def some(rng: np.random.Generator, n: int, share: float) -> NDArray:
    """Return which of n events are hit, each with the same chance."""
    return rng.random(n) < share


def either(hit: NDArray, there: NDArray, here: NDArray) -> NDArray:
    """Return the rows of the first events where hit, and those of the second where not."""
    return np.where(hit[:, None], there, here)
