"""Resolution, offset and scale of a continuous feature; angles are smeared and turned as angles."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Place, drawn, strength


class AngleChange(Change):
    """A change of the angle whose cosine was measured. Beyond a pole it comes back on the other side, as it must."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.cos(self.change_angle(np.arccos(np.clip(x, -1, 1)), rng))

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """In radians, (n, 1) -> (n, 1)."""
        raise NotImplementedError


class LineChange(Change):
    """A change of a feature that knows no ends."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return not place.cosine


@dataclass(frozen=True)
class AngularSmearing(AngleChange):
    """The angle is blurred by multiple scattering: a Gaussian core with a share of wider scatters."""

    name: ClassVar = "resolution"
    source: ClassVar = "Particle Data Group, Passage of particles through matter: Gaussian core, wider tails"
    strength: float = strength(0.03, 0.5, "rad")
    tail_share: float = drawn(0.05, 0.3)
    tail_width: float = drawn(2, 4)

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        width = np.where(rng.random(angle.shape) < self.tail_share, self.tail_width, 1)
        return angle + self.strength * width * rng.standard_normal(angle.shape)


@dataclass(frozen=True)
class DoubleGaussian(LineChange):
    """The value is blurred by a Gaussian core and, for a share of the events, by a wider one."""

    name: ClassVar = "resolution"
    source: ClassVar = "the usual double-Gaussian resolution function of tracking detectors"
    strength: float = strength(0.03, 0.6, "standard deviations")
    tail_share: float = drawn(0.1, 0.3)
    tail_width: float = drawn(1.5, 3)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        width = np.where(rng.random(x.shape) < self.tail_share, self.tail_width, 1)
        return x + self.strength * self.place.std * width * rng.standard_normal(x.shape)


@dataclass(frozen=True)
class SkewedSmearing(LineChange):
    """The value is blurred, more to one side than to the other, its mean unchanged: a Gaussian plus an exponential."""

    name: ClassVar = "resolution"
    source: ClassVar = "Grushka, Analytical Chemistry 44 (1972) 1733"
    strength: float = strength(0.03, 0.6, "standard deviations")
    exponential_share: float = drawn(0.3, 0.7, "variance", sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        share = abs(self.exponential_share)
        skewed = np.sign(self.exponential_share) * (rng.standard_exponential(x.shape) - 1)
        noise = np.sqrt(1 - share) * rng.standard_normal(x.shape) + np.sqrt(share) * skewed
        return x + self.strength * self.place.std * noise


@dataclass(frozen=True)
class TurnedAxis(AngleChange):
    """The axis from which the angle is measured is turned, by an amount that drifts over the run."""

    name: ClassVar = "offset"
    source: ClassVar = "misalignment of a tracker's axis with the beam"
    strength: float = strength(0.003, 0.1, "rad", sign=True)
    drift: float = drawn(0, 0.5, "share of the strength")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return angle + self.strength * (1 + self.drift * rng.uniform(-1, 1, angle.shape))


@dataclass(frozen=True)
class DriftingOffset(LineChange):
    """The zero of the scale is shifted, by an amount that drifts over the run."""

    name: ClassVar = "offset"
    source: ClassVar = "pedestal drift of readout electronics"
    strength: float = strength(0.005, 0.3, "standard deviations", sign=True)
    drift: float = drawn(0, 0.5, "share of the strength")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        when = rng.uniform(-1, 1, (len(x), 1))
        return x + self.strength * self.place.std * (1 + self.drift * when)


@dataclass(frozen=True)
class AngularScale(AngleChange):
    """Angles are measured too wide or too narrow with respect to the transverse plane: a detector of wrong length."""

    name: ClassVar = "scale"
    source: ClassVar = "the length scale (z expansion) weak mode of tracker alignment"
    strength: float = strength(0.003, 0.1, sign=True)
    drift: float = drawn(0, 0.3, "share of the strength")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        factor = 1 + self.strength * (1 + self.drift * rng.uniform(-1, 1, angle.shape))
        return np.pi / 2 + factor * (angle - np.pi / 2)


@dataclass(frozen=True)
class BentGain(LineChange):
    """The gain is wrong, a little more so for large signals, and drifts over the run."""

    name: ClassVar = "scale"
    source: ClassVar = "calibration of calorimeters: gain and integral non-linearity"
    strength: float = strength(0.005, 0.2, sign=True)
    bend: float = drawn(-0.3, 0.3, "share of the strength")
    drift: float = drawn(0, 0.3, "share of the strength")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        when = rng.uniform(-1, 1, (len(x), 1))
        return x * (1 + self.strength * (1 + self.bend * np.tanh(np.abs(x) / self.place.std) + self.drift * when))
