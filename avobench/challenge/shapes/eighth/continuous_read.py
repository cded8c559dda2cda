"""Real features whose sign, digits or largest values are read wrongly."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc

from avobench.challenge.shapes.contract import Change, Injection, Place, drawn, strength
from avobench.challenge.shapes.places import Real, Single, reflected, unscaled

BOTH_SIGNS = 0.05
"""Share of the events that must have either sign."""


class Signed(Single, Change):
    """What happens to the sign of a feature."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        if not super().suits(place):
            return False
        positive = float((place.reference[:, place.columns] > 0).mean())
        return BOTH_SIGNS < positive < 1 - BOTH_SIGNS


@dataclass(frozen=True)
class StraightTracks(Signed):
    """The charge is told from the side to which a track bends, and the tracks of fast particles are nearly straight.
    Where the bend is no larger than its error, the sign is taken wrongly in up to half of the cases.
    """

    name: ClassVar = "charge_misid"
    source: ClassVar = "sign of the curvature in a magnetic spectrometer"

    strength: float = strength(0.28, 3)
    """Error of the bend, relative to the bend of a particle of typical size."""

    @cached_property
    def typical(self) -> float:
        """Size of the feature."""
        return float(np.sqrt((self.place.reference[:, self.place.columns] ** 2).mean()))

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bend = self.typical / np.maximum(np.abs(x), 1e-6 * self.typical)
        wrong = rng.random(x.shape) < erfc(bend / self.strength / np.sqrt(2)) / 2
        return np.where(wrong, -x, x)


@dataclass(frozen=True)
class LostSignBit(Signed):
    """The bit that holds the sign is sometimes lost on a bad line. Values of one sign are then taken for values of the
    other, and never the other way round.
    """

    name: ClassVar = "charge_misid"
    source: ClassVar = "loose line of a parallel data bus"

    strength: float = strength(0.01, 0.5)
    """Share of the values of the one sign that are taken for the other."""
    read: float = drawn(1, 1, sign=True)
    """The sign that is read when the bit is lost."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, np.sign(self.read) * np.abs(x), x)


@dataclass(frozen=True)
class RoundedReadings(Real, Change):
    """Some observers do not read the dial as finely as it allows and note the nearest round number. The other values
    keep all their digits, so that there are heaps at round numbers.
    """

    name: ClassVar = "quantisation"
    source: ClassVar = "digit preference in blood pressure readings"
    stage: ClassVar = 4

    strength: float = strength(0.005, 0.6)
    """Share of the values that are rounded."""
    step: float = drawn(0.1, 0.5, "std", log=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.step * self.place.std
        lowest, highest = (-1, 1) if self.place.cosine else (-np.inf, np.inf)
        rounded = np.clip(np.rint(x / step) * step, lowest, highest)
        return np.where(rng.random(x.shape) < self.strength, rounded, x)


@dataclass(frozen=True)
class CellCentres(Real, Change):
    """A position is told as the centre of gravity of the signals of neighbouring cells, and most of the signal stays in
    the cell that was hit. Positions are drawn towards the centres of the cells and become rare at their borders.
    """

    name: ClassVar = "quantisation"
    source: ClassVar = "S-curve of a crystal calorimeter"
    stage: ClassVar = 4

    strength: float = strength(0.05, 1)
    """How much is missing from the distance to the centre, for a hit next to it."""
    cell: float = drawn(0.15, 0.5, "std", log=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        period = self.cell * self.place.std
        pulled = x - self.strength * period / (2 * np.pi) * np.sin(2 * np.pi * (x - self.place.centre) / period)
        return reflected(self.place, pulled)


@dataclass(frozen=True)
class SoftLimit(Single, Change):
    """Above a certain level the amplifier can no longer follow and its output grows only as the logarithm of its input.
    Values at this end of the scale are pressed together.
    """

    name: ClassVar = "saturation"
    source: ClassVar = "gain compression of a radio receiver"
    stage: ClassVar = 4

    strength: float = strength(0.03, 5)
    """How strongly values above the level are compressed."""
    level: float = drawn(0, 0.5, "half_range")
    side: float = drawn(1, 1, sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        s = np.sign(self.side) * (x - self.place.centre) / self.place.half_range
        above = np.maximum(s - self.level, 0)
        pressed = np.where(s > self.level, self.level + np.log1p(self.strength * above) / self.strength, s)
        return unscaled(self.place, np.sign(self.side) * pressed)


@dataclass(frozen=True)
class SupplyRail(Single, Change):
    """The output of an amplifier cannot go beyond the voltage of its supply, which sags a little now and then. Larger
    values are recorded as what the supply allows at the moment, so that they gather there.
    """

    name: ClassVar = "saturation"
    source: ClassVar = "operational amplifier at its supply rail"
    stage: ClassVar = 4

    strength: float = strength(0.005, 0.3)
    """Share of the events beyond the rail."""
    sag: float = drawn(0, 0.06, "std")
    """Mean drop of the rail."""
    side: float = drawn(1, 1, sign=True)

    @cached_property
    def rail(self) -> float:
        """Without the sag, on an axis that points towards it."""
        return float(np.quantile(np.sign(self.side) * self.place.reference[:, self.place.columns], 1 - self.strength))

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        drop = np.minimum(self.sag * rng.standard_exponential(x.shape), 0.5) * self.place.std
        return np.sign(self.side) * np.minimum(np.sign(self.side) * x, self.rail - drop)


FAMILIES: tuple[type[Injection], ...] = (
    StraightTracks,
    LostSignBit,
    RoundedReadings,
    CellCentres,
    SoftLimit,
    SupplyRail,
)
