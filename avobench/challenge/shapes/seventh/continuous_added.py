"""Values of another origin among those of real features."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Place, Replacement, drawn, strength
from avobench.challenge.shapes.places import Real, Single, unscaled


@dataclass(frozen=True)
class CombinatorialBackground(Real, Replacement):
    """Some events are random combinations of particles that do not belong together. Their values spread over the whole
    range with a density that is a straight line."""

    strength: float = strength(0.03, 0.35)
    slope: float = drawn(0.05, 0.6, sign=True)
    """Of the density from the middle to an end of the range, relative to that in the middle."""

    name = "flat_background"
    source = "combinatorial background under a mass spectrum"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        u = rng.random((n, len(self.place.columns)))
        s = (np.sqrt((1 - self.slope) ** 2 + 4 * self.slope * u) - 1) / self.slope
        return unscaled(self.place, np.clip(s, -1, 1))


@dataclass(frozen=True)
class AccidentalCoincidences(Real, Replacement):
    """Some events are accidental coincidences of two unrelated gates. Their values lie on a broad plateau that slopes
    off at both ends.

    The trapezoid is the convolution of a wide and a narrow gate.
    """

    strength: float = strength(0.03, 0.35)
    narrow: float = drawn(0.05, 0.3)
    """Width of the narrow gate over that of both together."""

    name = "flat_background"
    source = "accidentals in coincidence timing"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        wide, narrow = rng.uniform(-1, 1, (2, n, len(self.place.columns)))
        extent = 1 if self.place.cosine else 1.25
        return unscaled(self.place, extent * ((1 - self.narrow) * wide + self.narrow * narrow))


@dataclass(frozen=True)
class FluorescenceLine(Real, Replacement):
    """Material of the shielding fluoresces and adds a line of its own to the spectrum. Its events gather around one
    value, with the broad feet of a Lorentzian line."""

    strength: float = strength(0.004, 0.12)
    position: float = drawn(-0.7, 0.7, "half range")
    width: float = drawn(0.015, 0.05, "half range", log=True)
    """Half width at half maximum."""

    name = "peak_background"
    source = "X-ray fluorescence of a detector's shielding"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        angle = rng.uniform(-1.35, 1.35, (n, len(self.place.columns)))  # the feet end at 4.5 half widths
        return unscaled(self.place, self.position + self.width * np.tan(angle))


@dataclass(frozen=True)
class TailingPeak(Single, Replacement):
    """A contaminant leaves the column at a time of its own and adds its peak to the record. The peak rises steeply and
    ends in an exponential tail."""

    strength: float = strength(0.005, 0.15)
    position: float = drawn(-0.6, 0.6, "half range")
    tail: float = drawn(0.03, 0.1, "half range", log=True, sign=True)
    """Length of the tail and its direction; the rise takes a third of it."""

    name = "peak_background"
    source = "contaminant peak in chromatography"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        rise, decay = rng.standard_normal((n, 1)) / 3, rng.standard_exponential((n, 1))
        return unscaled(self.place, self.position + self.tail * (rise + decay))


@dataclass(frozen=True)
class DecimalSlip(Real, Change):
    """Now and then the decimal point of a value is typed one place too far to the right. That value is ten times too
    large."""

    strength: float = strength(0.0004, 0.02)

    name = "outliers"
    source = "manual data entry in clinical records"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, 10 * x, x)


@dataclass(frozen=True)
class CosmicHits(Single, Change):
    """Cosmic rays hit the sensor and add their charge to a few values. These values lie far off to one side, at
    distances that vary by powers of ten."""

    strength: float = strength(0.0004, 0.02)
    index: float = drawn(1.2, 2.5)
    """Of the power law that the added charges follow."""
    side: float = drawn(1, 1, sign=True)

    name = "outliers"
    source = "cosmic ray hits in CCD photometry"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        charge = np.minimum(5 * (1 + rng.pareto(self.index, x.shape)), 500)
        hit = rng.random(x.shape) < self.strength
        return x + hit * self.side * self.place.std * charge
