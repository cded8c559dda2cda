"""At which places shapes make sense, and what they share there."""

from abc import abstractmethod
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, Place, Selection, Simulate


class Counting(Injection):
    """What happens to one count an event."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        task = place.task
        return task.kinds_of_features == ("count",) and not task.event_shape and bool((place.reference >= 0).all())

    @cached_property
    def mean(self) -> float:
        """Of the counts, but at least one."""
        return max(float(self.place.reference.mean()), 1.0)

    def quantile(self, share: float) -> float:
        """What a share of the counts does not exceed."""
        return float(np.quantile(self.place.reference, share))


class Real(Injection):
    """What happens to real features: to one, or to all of several."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        task = place.task
        several = place.feature == "all" and task.num_features > 1
        return (
            (isinstance(place.feature, int) or several)
            and not task.event_shape
            and set(task.kinds_of_features) == {"continuous"}
        )


class Single(Real):
    """What happens to one real feature."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and isinstance(place.feature, int)


class Along(Single, Selection):
    """Events lost by where in the range of one feature they lie."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return self.transmission(self.place.scaled(x)[:, 0])

    @abstractmethod
    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The probability to be kept at s, where the range is [-1, 1]: (n,) -> (n,)."""


class Together(Real):
    """What happens to several real features at once."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.feature == "all"


class Image(Injection):
    """What happens to images of hits."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return len(place.task.event_shape) == 2 and place.binary and not isinstance(place.feature, int)

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns."""
        return self.place.task.event_shape

    def pictures(self, x: NDArray) -> NDArray[np.bool_]:
        """Events as images: (n, d) -> (n, rows, columns)."""
        return x.reshape(-1, *self.shape) > 0


class Picture(Image):
    """A change of images of hits."""

    @abstractmethod
    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        """(n, rows, columns) -> (n, rows, columns). It may write into `hits`."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        return self.alter(self.pictures(x), rng).reshape(x.shape).astype(x.dtype)


def reflected(place: Place, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """A cosine that runs over an end comes back from it; other features are left as they are: (n, k) -> (n, k)."""
    return np.where(np.abs(x) > 1, np.abs((x - 1) % 4 - 2) - 1, x) if place.cosine else x


def clipped(place: Place, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """A cosine that runs over an end stops there; other features are left as they are: (n, k) -> (n, k)."""
    return np.clip(x, -1, 1) if place.cosine else x


def unscaled(place: Place, s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Back from the scale where the range is [-1, 1]: (n, k) -> (n, k)."""
    return reflected(place, place.centre + place.half_range * s)
