"""Real features measured with a width, a zero or a unit that the simulation does not have."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, drawn, strength
from avobench.challenge.shapes.places import Real, Single, reflected


@dataclass(frozen=True)
class FiniteSlits(Real, Change):
    """The spectrometer has an entrance and an exit slit of finite width. Each value is smeared by a trapezoid.

    The trapezoid is the convolution of the two slits.
    """

    strength: float = strength(0.12, 0.8, "std")
    """Root mean square of the smearing."""
    narrower: float = drawn(0.1, 1)
    """Width of the exit slit over that of the entrance slit."""

    name = "resolution"
    source = "slit width of a monochromator"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        across = rng.uniform(-1, 1, x.shape) + self.narrower * rng.uniform(-1, 1, x.shape)
        return reflected(self.place, x + self.strength * self.place.std * across * np.sqrt(3 / (1 + self.narrower**2)))


@dataclass(frozen=True)
class DriftDiffusion(Real, Change):
    """The charge drifts through the gas to one end of the chamber and spreads on its way. The farther from that end a
    value lies, the worse it is measured.

    The width grows with the square root of the distance.
    """

    strength: float = strength(0.18, 1, "std")
    """Width at the far end."""
    far: float = drawn(1, 1, sign=True)
    """Which end of the range is the far one."""

    name = "resolution"
    source = "diffusion in a time projection chamber"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        distance = np.clip((1 + self.far * (x - self.place.centre) / self.place.half_range) / 2, 0.02, 1.5)
        width = self.strength * self.place.std * np.sqrt(distance)
        return reflected(self.place, x + width * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class WarmUp(Real, Change):
    """The zero of the electronics moves while the crate warms up, and stays where it is then. Only events from the
    beginning of the run are nearly free of the offset."""

    strength: float = strength(0.02, 0.5, "std", sign=True)
    """Offset of the warm electronics."""
    warming: float = drawn(0.03, 0.25, "run", log=True)
    """Time constant of the warming, as a share of the run."""

    name = "offset"
    source = "temperature drift of an amplifier's zero"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        reached = -np.expm1(-rng.random((len(x), 1)) / self.warming)
        return reflected(self.place, x + self.strength * self.place.std * reached)


@dataclass(frozen=True)
class KnockedMount(Single, Change):
    """Somebody knocked against the mount of the instrument early in the campaign. All values measured since are off by
    the same amount."""

    strength: float = strength(0.02, 0.5, "std", sign=True)
    since: float = drawn(0.65, 0.97)
    """Share of the events measured after the knock."""

    name = "offset"
    source = "displaced theodolite in a geodetic survey"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        after = rng.random(x.shape) < self.since
        return reflected(self.place, x + self.strength * self.place.std * after)


@dataclass(frozen=True)
class LensDistortion(Real, Change):
    """The lens magnifies the middle of the field of view more, or less, than its edge. The unit of the scale is right
    at the edge and wrong in the middle."""

    strength: float = strength(0.03, 0.4, sign=True)
    """Error of the magnification in the middle."""

    name = "scale"
    source = "barrel and pincushion distortion of a camera lens"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        off_axis = x - self.place.centre
        square = np.minimum((off_axis / self.place.half_range) ** 2, 1)
        return reflected(self.place, self.place.centre + off_axis * (1 + self.strength) / (1 + self.strength * square))


@dataclass(frozen=True)
class HalfLengths(Real, Change):
    """Lengths along the axis of the detector are measured in a wrong unit, by another error in either half. Values are
    stretched or shrunk from zero; for the cosine of an angle it is its cotangent that is.

    The error is `strength` on the positive side and `other` times that on the negative side.
    """

    strength: float = strength(0.02, 0.3, sign=True)
    other: float = drawn(0.3, 1)

    name = "scale"
    source = "length scale of the two halves of a tracker"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        gain = 1 + self.strength * np.where(x > 0, 1, self.other)
        if self.place.cosine:
            return np.clip(gain * x / np.sqrt(1 + (gain**2 - 1) * x**2), -1, 1)
        return gain * x
