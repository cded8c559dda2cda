"""The contract of a task: a simulator with named parameters, its prior, its support, and how it is scored."""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

NAME = r"[A-Za-z0-9][A-Za-z0-9.-]*"
"""The names that a task or method may have: a name is part of a file's, so nothing in it may lead to another folder."""
NUM_TARGETS = 15
"""Target parameters of every task (paper, Section 4.3)."""
Kind = Literal["count", "continuous", "angle"]
"""The kind of a feature: how many there are of something, a real number, or one that comes round again. An angle does
so after 360 if its unit is "deg", else after 2 pi. A cosine is a real number that ends at -1 and 1."""
ParameterKind = Literal["integer", "continuous"]
"""The kind of a parameter: a whole number, or any real one."""

OF_EVENTS = (
    *("num_features", "feature_names", "feature_kinds", "feature_units", "missing", "event_shape", "cyclic_axes"),
    *("dtype", "discriminator", "packages", "extra"),
)
"""What a task says of its events, and what they need."""


@dataclass(frozen=True)
class Box:
    """A box of parameters, `low < high` in every coordinate, bounds included. Raises ValueError otherwise."""

    low: tuple[float, ...]
    high: tuple[float, ...]

    def __post_init__(self) -> None:
        low, high = np.asarray(self.low, float), np.asarray(self.high, float)
        with np.errstate(all="ignore"):
            if low.ndim != 1 or low.shape != high.shape or not (np.isfinite(high - low) & (low < high)).all():
                raise ValueError(f"a box needs finite low < high of one length, got low={self.low}, high={self.high}")
        object.__setattr__(self, "low", tuple(low.tolist()))
        object.__setattr__(self, "high", tuple(high.tolist()))

    @property
    def dim(self) -> int:
        return len(self.low)

    @property
    def center(self) -> NDArray[np.float64]:
        """(p,)"""
        return (np.array(self.low) + np.array(self.high)) / 2

    @property
    def width(self) -> NDArray[np.float64]:
        """(p,)"""
        return np.array(self.high) - np.array(self.low)

    @property
    def mean(self) -> NDArray[np.float64]:
        """The mean of the prior that it stands for (p,)."""
        return self.center

    @property
    def std(self) -> NDArray[np.float64]:
        """The standard deviation of that prior (p,)."""
        return self.width / np.sqrt(12)

    def contains(self, theta: ArrayLike) -> NDArray[np.bool_]:
        """Rows of theta (n, p) that lie in the box: (n,). Raises ValueError for another number of columns."""
        theta = np.atleast_2d(theta)
        inside = np.ones(len(theta), bool)
        for column, low, high in zip(theta.T, self.low, self.high, strict=True):
            inside &= (column >= low) & (column <= high)
        return inside

    def contains_all(self, theta: NDArray[np.float64]) -> bool:
        """Tell whether all rows of theta (n, p) lie in the box; `contains(theta).all()`, in less time. n > 0.

        Raises ValueError for another number of columns.
        """
        if theta.shape[1] != len(self.low):
            raise ValueError(f"theta must have {len(self.low)} columns, got {theta.shape[1]}")
        columns = theta.T if len(self.low) > 1 else (theta,)
        return all(map(_within, columns, self.low, self.high))

    def sample(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Uniform draws: (n, p)."""
        return rng.uniform(self.low, self.high, (n, self.dim))


def _within(values: NDArray[np.float64], low: float, high: float) -> bool:
    """Tell whether all values, none a NaN, lie in [low, high]. argmin and argmax are the fastest on few values."""
    return low <= values.item(values.argmin()) and values.item(values.argmax()) <= high


@dataclass(frozen=True)
class Discriminator:
    """The network that the paper gives to a task (Section 4.3): an MLP with PReLU activations and one logit."""

    hidden: tuple[int, ...] = (100, 100, 100)
    standardise: bool = True
    """Shift and scale each feature by the mean and standard deviation of the observed events before the first layer."""


class Task(ABC):
    """A simulator and what is needed to pose and score an inference problem with it.

    A subclass sets the class variables and defines `simulate`, `summary` and, if it is known, `floor`. Settings
    that a user may change are dataclass fields of the subclass (decorate it with `@dataclass(frozen=True)`); they are
    part of what identifies a result, as is `version`: raise it when events, summary or floor change their meaning.
    """

    name: ClassVar[str]
    version: ClassVar[str] = "1"
    parameter_names: ClassVar[tuple[str, ...]]
    parameter_units: ClassVar[tuple[str, ...]]
    parameter_kinds: ClassVar[tuple[ParameterKind, ...]] = ()
    """The kind of each parameter, where one of them is no real number. The prior and the support of an integer end at
    whole numbers; whoever simulates through `checked_events` may ask for any number between, see `at_whole`."""
    tasks: ClassVar[tuple["Task", ...]] = ()
    """The tasks that it is made of."""
    source: ClassVar[str]
    """The source of the simulator, such as a paper and its section."""
    prior: ClassVar[Box]
    """Uniform prior; the targets are drawn from it."""
    support: ClassVar[Box]
    """The box in which the simulator is defined; it contains the prior."""
    num_features: ClassVar[int]
    feature_names: ClassVar[tuple[str, ...]] = ()
    """One a feature, where they have names."""
    feature_kinds: ClassVar[tuple[Kind, ...]] = ()
    """The kind of each feature; where a task says nothing, whole numbers are counts and all others continuous. Cells of
    an image, which is declared by `event_shape`, have none."""
    feature_units: ClassVar[tuple[str, ...]] = ()
    """One a feature, where they have units; that of a pure number is "1"."""
    missing: ClassVar[tuple[int, ...]] = ()
    """The columns of features that an event may lack, as of a detector that did not fire; it holds NaN there."""
    event_shape: ClassVar[tuple[int, ...]] = ()
    """Shape of an event whose features form an image, row by row, e.g. (32, 32); () where they are a plain list."""
    cyclic_axes: ClassVar[tuple[int, ...]] = ()
    """Axes of `event_shape` along which a cyclic shift of an event is as probable as the event, whatever theta."""
    floor_shares: ClassVar[tuple[float, ...]] = ()
    """Each parameter's share of the floor where an efficient estimator's errors are Gaussian and independent, summing
    to 1: they tell the median of its squared error; () where they are not, or not known."""
    dtype: ClassVar[DTypeLike] = np.float64
    discriminator: ClassVar[Discriminator] = Discriminator()
    generates: ClassVar[str] = ""
    """The product of a first step that does not know theta, such as "particles"; "" where it simulates in one step.

    A task that says so defines `generate(num_events, rng)`, which yields pieces of `len(piece)` events that have
    `events(start, stop)`, and `detect(piece, theta)`, which makes their events; its `simulate` takes a third argument,
    `alter(piece, rows)`, which changes what was generated before it is detected. A diagnosis then generates once and
    detects for every theta. "particles" are those of `avobench.tasks.alignment`, and the task has the `radius` of the
    tracker that they cross [mm]; effects on particles apply to it.
    """
    by_default: ClassVar[bool] = True
    """True if a sweep for which no task is named carries it out."""
    packages: ClassVar[tuple[str, ...]] = ()
    """Modules that must be importable, checked before a sweep begins; `extra` is the extra that installs them."""
    extra: ClassVar[str] = ""

    @property
    def labels(self) -> tuple[str, ...]:
        """The label of each feature: its name, or x1, x2, ... where they have none: (d,)"""
        return self.feature_names or tuple(f"x{j + 1}" for j in range(self.num_features))

    @property
    def kinds_of_features(self) -> tuple[Kind, ...]:
        """The kind of each feature, as it was stated or as `dtype` says: (d,)"""
        whole = np.dtype(self.dtype).kind in "iu"
        return self.feature_kinds or ("count" if whole else "continuous",) * self.num_features

    @property
    def parts(self) -> tuple[object, ...]:
        """Functions, classes, other tasks, effects and texts beside its class and settings that decide what it does.

        Texts, and the source of the others where they are not of this project, are part of what identifies a result.
        """
        return ()

    @property
    def is_integer(self) -> NDArray[np.bool_]:
        """A mask of the parameters that are whole numbers: (p,)."""
        return np.array([kind == "integer" for kind in self.parameter_kinds or ("",) * len(self.parameter_names)])

    def at_whole(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Parameters (n, p) of which integers are rounded up with the probability of what they exceed a whole one by.

        So events between two whole numbers are a mixture of those at both, and their mean is linear in between: a
        method that follows a slope finds one, where rounding to the nearest would leave steps.
        """
        if not self.is_integer.any():
            return theta
        down = np.floor(theta)
        up = rng.random(theta.shape) < theta - down
        return np.where(self.is_integer, down + up, theta)

    def quoted(
        self, theta: NDArray[np.float64], error: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """An estimate and its error (p,) as they are quoted: an integer is whole, and its error covers the rounding."""
        nearest = np.where(self.is_integer, np.rint(theta), theta)
        return nearest, np.hypot(error, theta - nearest)

    def identifiable(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The part of theta that the events determine: (n, p) -> (n, k), with k < p, or theta itself."""
        return theta

    @property
    def identifiable_scale(self) -> NDArray[np.float64]:
        """The units (k,) of differences of `identifiable` when several are averaged: the prior's widths."""
        return self.prior.width

    def broken(self, x: NDArray) -> NDArray[np.bool_]:
        """The rows of events (n, d) with a value that is not finite, other than what may be missing: (n,)."""
        bad = ~np.isfinite(x)
        columns = list(self.missing)
        bad[:, columns] = np.isinf(x[:, columns])
        return bad.any(axis=1)

    def copy_events_of(self, task: "Task") -> None:
        """Take over what another task says of its events, and what they need."""
        for name in OF_EVENTS:
            setattr(self, name, getattr(task, name))

    def require_support(self, theta: NDArray[np.float64]) -> None:
        """Raise ValueError unless all rows of theta (n, p) lie within the support."""
        if not self.support.contains_all(theta):
            outside = theta[~self.support.contains(theta)]
            raise ValueError(
                f"theta = {outside[0].tolist()} lies outside the support of {self.name}, "
                f"{list(self.support.low)} to {list(self.support.high)}"
            )

    @abstractmethod
    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row of theta: (n, p) within the support -> (n, d) of `dtype`.

        Rows are independent given theta, and all randomness comes from `rng`. Raises ValueError outside the support.
        """

    @abstractmethod
    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """The summary statistic of a set of events, for the methods that need one: (n, d) -> (k,)."""

    def with_reference(self, x: NDArray) -> "Task":
        """This task with a summary that suits events like x (n, d); itself where its summary is fixed."""
        return self

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """Expected squared error, in raw units summed over parameters, of the best estimator at theta (p,).

        With `num_simulations`, for a method that knows the model only through that many events; with None, for one
        that knows the likelihood. NaN, as here, where it is not known.
        """
        return np.nan

    def targets(self, n: int = NUM_TARGETS) -> NDArray[np.float64]:
        """Target parameters, drawn from the prior with a seed that belongs to the task's name: (n, p)."""
        rng = np.random.default_rng(stable_hash("targets", self.name))
        theta = self.at_whole(self.prior.sample(n, rng), rng)
        return self.quoted(theta, np.zeros_like(theta))[0]


def twin(task: Task, **changed: Any) -> Task:
    """A copy of a task with other attributes, such as another `simulate`."""
    made = copy(task)
    for name, value in changed.items():
        object.__setattr__(made, name, value)  # it may be a frozen dataclass
    return made


def stable_hash(*words: str) -> int:
    """A 128-bit integer that names `words`, the same on every machine and in every process."""
    return int.from_bytes(hashlib.sha256("\0".join(words).encode()).digest()[:16], "big")


def histogram(x: NDArray, edges: Sequence[float] | NDArray, *, overflow: bool = False) -> NDArray[np.float64]:
    """Share of the events in each bin, one histogram a feature, joined: (n, d) -> (d * bins,).

    Bins are [low, high), the last one closed; with `overflow` everything outside falls in two more bins a feature.
    """
    edges = np.asarray(edges, float)
    if overflow:
        edges = np.concatenate([[-np.inf], edges, [np.inf]])
    return np.concatenate([np.histogram(feature, edges)[0] for feature in x.T]) / len(x)
