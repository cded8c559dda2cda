"""Events of another origin among those of a real feature: all over the range, or in a narrow line."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Replacement, drawn, strength
from avobench.challenge.shapes.places import Real, Single, unscaled


@dataclass(frozen=True)
class RoomReturn(Real, Replacement):
    """Neutrons come back from the walls of the hall after many collisions. They are found all over the range, somewhat
    more of them towards one end.
    """

    name = "flat_background"
    source = "neutrons scattered back by the walls of a hall"

    strength: float = strength(0.008, 0.3)
    slope: float = drawn(0.1, 0.7, sign=True)
    """Of the logarithm of their density, a half range."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        u = rng.random((n, len(self.place.columns)))
        return unscaled(self.place, np.log1p(u * np.expm1(2 * self.slope)) / self.slope - 1)


@dataclass(frozen=True)
class ChanceCoincidences(Single, Replacement):
    """Two counters fire within one gate by chance. The difference of two unrelated times is spread over the whole
    range, with fewer of them towards its ends.
    """

    name = "flat_background"
    source = "accidental coincidences in positron emission tomography"

    strength: float = strength(0.008, 0.3)
    second: float = drawn(0.2, 0.6)
    """Length of the second counter's gate, where that of the first is 1."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        first, second = rng.uniform(-1, 1, (2, n, 1))
        return unscaled(self.place, (first + self.second * second) / (1 + self.second))


@dataclass(frozen=True)
class PotassiumLine(Single, Replacement):
    """Potassium in the glass of the photomultipliers decays, and its line lies on the spectrum, with a short tail
    towards smaller values from what escapes the crystal.
    """

    name = "peak_background"
    source = "the potassium-40 line in sodium iodide"

    strength: float = strength(0.003, 0.15)
    at: float = drawn(-0.7, 0.7, "half ranges")
    width: float = drawn(0.01, 0.05, "half ranges")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        escaped = rng.standard_exponential((n, 1)) * (rng.random((n, 1)) < 0.3)
        return unscaled(self.place, self.at + self.width * (rng.standard_normal((n, 1)) - 2 * escaped))


@dataclass(frozen=True)
class CopperDoublet(Single, Replacement):
    """The collimator glows in its own X-rays: two narrow lines beside each other, the upper one twice as
    strong as the lower.
    """

    name = "peak_background"
    source = "the K-alpha doublet of copper collimators"

    strength: float = strength(0.003, 0.15)
    at: float = drawn(-0.7, 0.7, "half ranges")
    gap: float = drawn(0.03, 0.12, "half ranges")
    """Between the lines."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        line = np.where(rng.random((n, 1)) < 1 / 3, -self.gap / 2, self.gap / 2)
        return unscaled(self.place, self.at + line + self.gap / 5 * rng.logistic(0, 0.55, (n, 1)))
