"""Events of another origin among those of continuous features."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Place, Replacement, drawn, strength


def onto(place: Place, u: NDArray[np.float64]) -> NDArray[np.float64]:
    """From the scale where the range is [-1, 1] to the feature's own."""
    return place.centre + u * place.half_range


@dataclass(frozen=True)
class NearlyFlat(Replacement):
    """Events spread nearly evenly over the range, a little more of them to one side and towards both ends."""

    name: ClassVar = "flat_background"
    source: ClassVar = "combinatorial and cosmic backgrounds, usually fitted by low polynomials"
    strength: float = strength(0.01, 0.4)
    slope: float = drawn(-0.25, 0.25)
    curvature: float = drawn(0, 0.3)

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.cosine

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return onto(self.place, self._unit(n, rng))

    def _unit(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Density 1 + slope u + curvature (3 u^2 - 1) / 2 on [-1, 1], by rejection: (n, k)."""
        u = np.empty((n, len(self.place.columns)))
        todo = np.ones(u.shape, bool)
        while todo.any():
            u[todo] = rng.uniform(-1, 1, todo.sum())
            density = 1 + self.slope * u + self.curvature * (3 * u**2 - 1) / 2
            todo &= rng.uniform(0, 1 + abs(self.slope) + self.curvature, u.shape) >= density
        return u


@dataclass(frozen=True)
class SoftEnded(NearlyFlat):
    """Events spread nearly evenly over the range and, thinning out, a little beyond it."""

    softness: float = drawn(0.02, 0.15, "half ranges")

    @classmethod
    def suits(cls, place: Place) -> bool:
        return not place.cosine

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        u = self._unit(n, rng)
        return onto(self.place, u + self.softness * rng.standard_normal(u.shape))


@dataclass(frozen=True)
class BreitWigner(Replacement):
    """A resonance: events gather around one value with the long tails of a Breit-Wigner curve, within the range."""

    name: ClassVar = "peak_background"
    source: ClassVar = "Breit and Wigner, Physical Review 49 (1936) 519"
    strength: float = strength(0.003, 0.1)
    location: float = drawn(-0.7, 0.7, "half ranges")
    half_width: float = drawn(0.02, 0.08, "half ranges")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        low, high = (np.arctan((end - self.location) / self.half_width) for end in (-1, 1))
        u = self.location + self.half_width * np.tan(rng.uniform(low, high, (n, len(self.place.columns))))
        return onto(self.place, u)


@dataclass(frozen=True)
class RadiativePeak(Replacement):
    """A line with a tail to one side, from energy lost before it was measured."""

    name: ClassVar = "peak_background"
    source: ClassVar = "Gaiser, PhD thesis, SLAC-R-255 (1982): peaks with a radiative tail"
    strength: float = strength(0.003, 0.1)
    location: float = drawn(-0.6, 0.6, "half ranges")
    width: float = drawn(0.02, 0.06, "half ranges")
    tail: float = drawn(0.03, 0.1, "half ranges", sign=True)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        size = n, len(self.place.columns)
        core = self.location + self.width * rng.standard_normal(size)
        u = core + self.tail * rng.standard_exponential(size)
        return onto(self.place, np.where(np.abs(u) < 1, u, core))
