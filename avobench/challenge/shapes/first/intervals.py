"""What happens to whole counting intervals: they are blanked, their rate varies, they are lost, or are not ours."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import (
    Change,
    Injection,
    Place,
    Replacement,
    Selection,
    Simulate,
    drawn,
    strength,
)


@dataclass(frozen=True)
class Trips(Change):
    """The counter is off during some intervals; where it goes off or comes back, part of the interval is counted."""

    name: ClassVar = "zero_inflation"
    source: ClassVar = "high-voltage trips; zero-inflated counts as in Lambert, Technometrics 34 (1992) 1"
    strength: float = strength(0.002, 0.2, "share of the intervals")
    partial: float = drawn(0, 0.2, "share of these that are cut short")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        off = rng.random(x.shape) < self.strength
        cut = rng.random(x.shape) < self.partial
        alive = np.where(off, np.where(cut, rng.random(x.shape), 0), 1)
        return rng.binomial(x.astype(int), alive)


@dataclass(frozen=True)
class Discharges(Change):
    """A busy interval is more likely to end in a discharge that erases what was counted."""

    name: ClassVar = "zero_inflation"
    source: ClassVar = "sparking of gaseous detectors, in proportion to the rate"
    strength: float = strength(0.002, 0.2, "share of the intervals")
    rate_power: float = drawn(0.2, 1)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        mean = self.place.reference[:, self.place.columns].mean(axis=0)
        probability = self.strength * (x / mean) ** self.rate_power
        return np.where(rng.random(x.shape) < probability, 0, x)


class RateVariation(Injection):
    """The rate differs from interval to interval, by a factor of mean 1 and relative standard deviation `strength`."""

    stage = 1
    strength: float

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """(n,)"""
        raise NotImplementedError

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.task.parameter_names == ("log_rate",)  # only there is it known how a rate is varied

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return simulate(theta + np.log(self.factor(len(theta), rng))[:, None], rng)


@dataclass(frozen=True)
class TwoIntensities(RateVariation):
    """The source has two intensities and switches between them."""

    name: ClassVar = "overdispersion"
    source: ClassVar = "mixed Poisson distributions of two components (Karlis and Xekalaki 2005)"
    strength: float = strength(0.03, 0.5, "relative standard deviation")
    share: float = drawn(0.2, 0.6, "of the stronger intensity")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        high = np.sqrt((1 - self.share) / self.share)
        return np.maximum(1 + self.strength * np.where(rng.random(n) < self.share, high, -1 / high), 0.01)


@dataclass(frozen=True)
class LognormalRate(RateVariation):
    """The source's intensity is the product of many small disturbances."""

    name: ClassVar = "overdispersion"
    source: ClassVar = "Poisson-lognormal counts, Bulmer, Biometrics 30 (1974) 101"
    strength: float = strength(0.03, 0.5, "relative standard deviation")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        width = np.sqrt(np.log1p(self.strength**2))
        return np.exp(width * rng.standard_normal(n) - width**2 / 2)


@dataclass(frozen=True)
class Oscillation(RateVariation):
    """The source's intensity goes up and down like a sine."""

    name: ClassVar = "overdispersion"
    source: ClassVar = "periodic modulation of a rate, sampled at random phase"
    strength: float = strength(0.03, 0.5, "relative standard deviation")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return 1 + np.sqrt(2) * self.strength * np.sin(rng.uniform(0, 2 * np.pi, n))


@dataclass(frozen=True)
class SoftTrigger(Selection):
    """An interval with few counts may not be recorded at all: an erf turn-on around a threshold."""

    name: ClassVar = "threshold_loss"
    source: ClassVar = "the usual erf turn-on of trigger efficiencies"
    strength: float = strength(0.03, 0.6, "share of the intervals below the threshold")
    width: float = drawn(0.2, 0.8, "standard deviations")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        counts = self.place.reference[:, self.place.columns]
        threshold = np.quantile(counts, self.strength, axis=0, method="linear")
        return ndtr((x[:, self.place.columns] + 0.5 - threshold) / (self.width * self.place.std)).prod(axis=1)


@dataclass(frozen=True)
class StrayIntervals(Replacement):
    """Intervals whose counts are not those of the source: spread nearly evenly, thinning out at the upper end."""

    name: ClassVar = "flat_background"
    source: ClassVar = "noise bursts of electronics"
    strength: float = strength(0.005, 0.3, "share of the intervals")
    slope: float = drawn(-0.3, 0.3)
    end: float = drawn(0.85, 1.2, "of the range")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        highest = np.quantile(self.place.reference[:, self.place.columns], 0.999, axis=0)
        u = rng.random((n, len(self.place.columns)))
        u = np.where(
            rng.random(u.shape) < abs(self.slope), rng.beta(*((2, 1) if self.slope > 0 else (1, 2)), u.shape), u
        )
        return np.floor((highest + 1) * self.end * u * (1 + 0.05 * rng.standard_normal(u.shape)).clip(0.8, 1.2))
