"""Wrong signs, rare large errors, crosstalk, and what the readout does to a continuous feature."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import moyal

from avobench.challenge.shapes.contract import Change, Injection, Place, Simulate, drawn, strength
from avobench.challenge.shapes.first.smearing import AngleChange, LineChange


@dataclass(frozen=True)
class StraightTracks(Change):
    """The sign is mistaken, more often for large values: a straighter track tells less about its charge."""

    name: ClassVar = "charge_misid"
    source: ClassVar = "charge confusion of trackers grows with momentum"
    strength: float = strength(0.005, 0.2)
    rise: float = drawn(0.3, 1)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        size = np.clip(np.abs(x) / (np.abs(self.place.centre) + self.place.half_range), 0, 1)
        flipped = rng.random(x.shape) < self.strength * (1 - self.rise + 2 * self.rise * size**2)
        return np.where(flipped, -x, x)


@dataclass(frozen=True)
class StudentTails(LineChange):
    """A share of the values is badly measured, with errors that know hardly a limit."""

    name: ClassVar = "outliers"
    source: ClassVar = "Student's t with few degrees of freedom as a model of outliers (Lange et al. 1989)"
    strength: float = strength(0.003, 0.15)
    width: float = drawn(1, 3, "standard deviations")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hit = rng.random(x.shape) < self.strength
        return np.where(hit, x + self.width * self.place.std * rng.standard_t(2.5, x.shape), x)


@dataclass(frozen=True)
class LandauTails(LineChange):
    """A share of the values is measured too large, as by knock-on electrons: a Landau-like tail to one side."""

    name: ClassVar = "outliers"
    source: ClassVar = "Moyal, Philosophical Magazine 46 (1955) 263, for Landau's distribution of energy loss"
    strength: float = strength(0.003, 0.15)
    width: float = drawn(0.7, 2, "standard deviations")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hit = rng.random(x.shape) < self.strength
        return np.where(hit, x + self.width * self.place.std * moyal.rvs(size=x.shape, random_state=rng), x)


@dataclass(frozen=True)
class HardScattering(AngleChange):
    """A share of the tracks is scattered by a large angle."""

    name: ClassVar = "outliers"
    source: ClassVar = "Moliere's theory of multiple scattering: single scatters by large angles"
    strength: float = strength(0.01, 0.3)
    width: float = drawn(0.5, 1.5, "rad")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hit = rng.random(angle.shape) < self.strength
        return np.where(hit, angle + rng.laplace(0, self.width, angle.shape), angle)


class Crosstalk(Injection):
    """An injection by which signals of other channels leak into one."""

    name = "crosstalk"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return isinstance(place.feature, int) and place.task.num_features > 1


@dataclass(frozen=True)
class RectifiedCrosstalk(Crosstalk):
    """A large signal in another channel leaks into this one; a small one, below a knee, does not."""

    source: ClassVar = "capacitive coupling between channels, behind a discriminating input stage"
    strength: float = strength(0.01, 0.4, "own per other standard deviations", sign=True)
    neighbour: float = drawn(0, 1, "which of the other features")
    knee: float = drawn(-1.5, 0, "standard deviations")

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        others = [column for column in range(x.shape[1]) if column != self.place.feature]
        other = others[min(int(self.neighbour * len(others)), len(others) - 1)]
        reference = self.place.reference[:, other]
        z = (x[:, other] - reference.mean()) / reference.std()
        x[:, self.place.feature] += self.strength * self.place.std[0] * np.logaddexp(0, 4 * (z - self.knee)) / 4
        return x


@dataclass(frozen=True)
class TruncatingReadout(LineChange):
    """Values are cut down to the steps of a converter, with a little noise of its own."""

    name: ClassVar = "quantisation"
    source: ClassVar = "analogue-to-digital converters that truncate"
    strength: float = strength(0.05, 1, "standard deviations")
    noise: float = drawn(0, 0.1, "steps")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.strength * self.place.std
        return step * (np.floor(x / step) + 0.5 + self.noise * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class Segments(AngleChange):
    """The angle is known by the segment that was hit; segments are alternately wide and narrow."""

    name: ClassVar = "quantisation"
    source: ClassVar = "segmented counters; differential non-linearity"
    strength: float = strength(0.03, 0.4, "rad")
    unevenness: float = drawn(0, 0.3, "segments")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        pair, inside = np.divmod(angle / self.strength, 2)
        border = 1 + self.unevenness
        return self.strength * (2 * pair + np.where(inside < border, border / 2, (border + 2) / 2))


@dataclass(frozen=True)
class SoftSaturation(LineChange):
    """Beyond a knee the response bends over, towards a limit that it never reaches."""

    name: ClassVar = "saturation"
    source: ClassVar = "saturation of silicon photomultipliers, 1 - exp(-x)"
    strength: float = strength(0.005, 0.25, "share of the events beyond the knee")
    headroom: float = drawn(0.1, 0.5, "standard deviations")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        knee = np.quantile(self.place.reference[:, self.place.columns], 1 - self.strength, axis=0)
        room = self.headroom * self.place.std
        return np.where(x > knee, knee - room * np.expm1(-np.clip(x - knee, 0, None) / room), x)
