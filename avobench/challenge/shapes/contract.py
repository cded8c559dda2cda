"""What an injection is: an effect hidden in measured data, in a shape that the catalogue does not have."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task

Simulate = Callable[[NDArray[np.float64], np.random.Generator], NDArray]
"""theta (n, p), rng -> events (n, d)"""

MAX_ROUNDS = 1000
"""Of simulating again what was lost, before a selection is said to keep nothing."""
PACKAGES = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
"""Of the series of shapes, in their order."""


@dataclass(frozen=True)
class Place:
    """Where an injection acts: one feature, all of them, or the event as a whole (None)."""

    task: Task
    feature: int | Literal["all"] | None
    reference: NDArray
    """Events without the effect, (m, d): they give the scale on which strengths are meant."""

    @cached_property
    def columns(self) -> list[int]:
        return [self.feature] if isinstance(self.feature, int) else list(range(self.task.num_features))

    @cached_property
    def std(self) -> NDArray[np.float64]:
        """(k,), one a column."""
        return self.reference[:, self.columns].std(axis=0)

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        """(k,): the middle of the range."""
        return self._range.mean(axis=0)

    @cached_property
    def half_range(self) -> NDArray[np.float64]:
        """(k,): half of the range that holds all but 1 % of the reference, or 1 for a cosine."""
        return (self._range[1] - self._range[0]) / 2

    @cached_property
    def _range(self) -> NDArray[np.float64]:
        if self.cosine:
            return np.array([[-1.0], [1.0]])
        return np.quantile(self.reference[:, self.columns], [0.005, 0.995], axis=0)

    @cached_property
    def binary(self) -> bool:
        """Whether the events are images of hits that have no size."""
        return bool(np.isin(self.reference, (0, 1)).all())

    @property
    def cosine(self) -> bool:
        """Whether the feature is the cosine of an angle; its name then begins with `cos`."""
        names = self.task.feature_names
        return isinstance(self.feature, int) and bool(names) and names[self.feature].startswith("cos")

    def scaled(self, x: NDArray) -> NDArray[np.float64]:
        """The columns on the scale where the range is [-1, 1]: (n, d) -> (n, k)."""
        return (x[:, self.columns] - self.centre) / self.half_range


def drawn(low: float, high: float, unit: str = "1", *, log: bool = False, sign: bool = False) -> Any:
    """A field that is drawn uniformly in [low, high], or log-uniformly; with `sign`, of either sign."""
    return field(metadata={"low": low, "high": high, "unit": unit, "log": log, "sign": sign})


def strength(low: float, high: float, unit: str = "1", *, sign: bool = False) -> Any:
    """The strength of an injection: log-uniform from barely visible (low) to strong (high)."""
    return drawn(low, high, unit, log=True, sign=sign)


@dataclass(frozen=True)
class Injection(ABC):
    """An effect of the family `name`, with its strength and shape fixed.

    The fields made by `drawn` and `strength` are what `draw` draws. The docstring's first paragraph tells a person
    what happens in the detector.
    """

    place: Place

    name: ClassVar[str]
    """Of the family in the catalogue."""
    source: ClassVar[str]
    stage: ClassVar[int] = 2
    """Of the chain, as that of an effect of the catalogue: 0 generated particles, 1 source, 2 measurement, 3 selection,
    4 what is added or read out."""
    series: ClassVar[int] = 1
    """That of the package it stands in: the second was written when the search had been developed on the first, the
    others without sight of one another, of the catalogue and of the search."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        packages = cls.__module__.split(".")
        cls.series = next((k for k, name in enumerate(PACKAGES, start=1) if name in packages), 1)

    @classmethod
    def suits(cls, place: Place) -> bool:
        """Whether this shape makes sense there."""
        return True

    @classmethod
    def draw(cls, place: Place, rng: np.random.Generator) -> Self:
        """One of random strength and shape."""
        values = {}
        for each in fields(cls):
            if each.metadata:
                low, high = each.metadata["low"], each.metadata["high"]
                value = (
                    np.exp(rng.uniform(np.log(low), np.log(high))) if each.metadata["log"] else rng.uniform(low, high)
                )
                values[each.name] = float(value * (rng.choice([-1, 1]) if each.metadata["sign"] else 1))
        return cls(place, **values)

    def stronger(self, factor: float) -> Self:
        """The same with its strength multiplied by a factor, but not beyond the range from which it is drawn."""
        high = next(each.metadata["high"] for each in fields(self) if each.name == "strength")
        return replace(self, strength=float(np.clip(factor * self.strength, -high, high)))

    @property
    def settings(self) -> dict[str, float]:
        """What was drawn."""
        return {each.name: getattr(self, each.name) for each in fields(self) if each.metadata}

    @abstractmethod
    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """Events as they are measured, one a row of theta: (n, p) -> (n, d)."""


class Change(Injection):
    """An injection that changes the value of every event."""

    @abstractmethod
    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """The columns of the place, (n, k) -> (n, k)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        changed = x.copy()
        changed[:, self.place.columns] = self.change(x[:, self.place.columns].astype(float), rng)
        return changed


class Selection(Injection):
    """An injection that loses events. Others take their place, so that their number stays."""

    stage = 3

    @abstractmethod
    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        """The probability that an event is kept: (n, d) -> (n,)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        lost = np.flatnonzero(rng.random(len(x)) >= self.efficiency(x))
        for _ in range(MAX_ROUNDS):
            if not len(lost):
                return x
            x[lost] = simulate(theta[lost], rng)
            lost = lost[rng.random(len(lost)) >= self.efficiency(x[lost])]
        raise ValueError(f"{type(self).__name__} keeps next to no event")


class Replacement(Injection):
    """An injection that puts events of another origin in the place of a share `strength` of the events."""

    stage = 4
    strength: float

    @abstractmethod
    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Columns of n events of the other origin: (n, k)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        replaced = np.flatnonzero(rng.random(len(x)) < self.strength)
        x[np.ix_(replaced, self.place.columns)] = self.foreign(len(replaced), rng)
        return x
