"""Events of another origin, and values that are far off."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, Replacement, drawn, strength
from avobench.challenge.shapes.places import Real, Single, unscaled


@dataclass(frozen=True)
class RandomTriggers(Real, Replacement):
    """Now and then noise starts the readout though nothing happened, and the reconstruction makes an event of it. Its
    values lie anywhere in the range with equal chance.
    """

    name: ClassVar = "flat_background"
    source: ClassVar = "noise triggers of a neutrino telescope"

    strength: float = strength(0.012, 0.35)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return unscaled(self.place, rng.uniform(-1, 1, (n, len(self.place.columns))))


@dataclass(frozen=True)
class WrongCombinations(Single, Replacement):
    """Tracks that do not belong together are combined by chance and pass as events. They spread over the whole range
    and fall off slowly and exponentially towards one end.
    """

    name: ClassVar = "flat_background"
    source: ClassVar = "combinatorial background of a B factory"

    strength: float = strength(0.012, 0.35)
    fall: float = drawn(0.3, 1.2, sign=True)
    """Logarithm of the ratio of the densities at the two ends."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        t = -np.log1p(rng.random((n, 1)) * np.expm1(-self.fall)) / self.fall
        return unscaled(self.place, 2 * t - 1)


@dataclass(frozen=True)
class ResonanceLine(Single, Replacement):
    """A narrow resonance with the same final state lies under the events and is not part of the simulation. Its events
    gather at one place, in a line that has the natural shape of a decay.
    """

    name: ClassVar = "peak_background"
    source: ClassVar = "Breit-Wigner line in a spectrum"

    strength: float = strength(0.004, 0.15)
    line: float = drawn(-0.7, 0.7, "half_range")
    width: float = drawn(0.01, 0.04, "half_range", log=True)
    """Half width at half maximum; the line is cut at five of them."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        end = np.arctan(5)
        return unscaled(self.place, self.line + self.width * np.tan(rng.uniform(-end, end, (n, 1))))


@dataclass(frozen=True)
class BeamHalo(Single, Replacement):
    """Particles that accompany the beam cross the detector nearly along its axis. They gather at one end of the range
    and become rarer exponentially with the distance from it.
    """

    name: ClassVar = "peak_background"
    source: ClassVar = "beam halo muons at a collider"

    strength: float = strength(0.003, 0.1)
    reach: float = drawn(0.03, 0.12, "half_range", log=True)
    side: float = drawn(1, 1, sign=True)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        distance = np.minimum(self.reach * rng.standard_exponential((n, 1)), 2)
        return unscaled(self.place, np.sign(self.side) * (1 - distance))


@dataclass(frozen=True)
class DecimalSlip(Single, Change):
    """When readings are typed in by hand, the decimal point sometimes lands one place too far to the right. Such a
    value is ten times as large as it was.
    """

    name: ClassVar = "outliers"
    source: ClassVar = "laboratory values in patients' records"
    stage: ClassVar = 4

    strength: float = strength(0.0005, 0.03)

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, 10 * x, x)


@dataclass(frozen=True)
class Sparks(Single, Change):
    """A few readings coincide with a spark of the high voltage, which adds a pulse of its own in one direction. The
    pulses are several times as large as the spread of the values, and a few of them are very much larger.
    """

    name: ClassVar = "outliers"
    source: ClassVar = "discharges in high-voltage instruments"
    stage: ClassVar = 4

    strength: float = strength(0.0005, 0.03)
    tail: float = drawn(2, 4)
    """Power with which large pulses become rare."""
    side: float = drawn(1, 1, sign=True)

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        pulse = 5 * np.minimum((1 - rng.random(x.shape)) ** (-1 / self.tail), 10)
        hit = rng.random(x.shape) < self.strength
        return x + np.sign(self.side) * self.place.std * pulse * hit


FAMILIES: tuple[type[Injection], ...] = (
    RandomTriggers,
    WrongCombinations,
    ResonanceLine,
    BeamHalo,
    DecimalSlip,
    Sparks,
)
