"""What the readout of a counter adds to its numbers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import moyal

from avobench.challenge.shapes.contract import Change, drawn, strength


@dataclass(frozen=True)
class LandauNoise(Change):
    """The number read out is disturbed by noise with a tail to large values; it is never negative."""

    name: ClassVar = "readout_noise"
    source: ClassVar = "Moyal, Philosophical Magazine 46 (1955) 263, for Landau's distribution"
    stage: ClassVar = 4
    strength: float = strength(0.1, 1.5, "standard deviations")
    tail_share: float = drawn(0.1, 0.4, "of the intervals with a Landau-like disturbance")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        tail = (moyal.rvs(size=x.shape, random_state=rng) - moyal.mean()) / moyal.std()
        noise = np.where(rng.random(x.shape) < self.tail_share, tail, rng.standard_normal(x.shape))
        return np.maximum(np.rint(x + self.strength * self.place.std * noise), 0)


@dataclass(frozen=True)
class LaplaceNoise(Change):
    """The number read out is disturbed by noise with tails to both sides; it is never negative."""

    name: ClassVar = "readout_noise"
    source: ClassVar = "noise of electronics with rare large excursions"
    stage: ClassVar = 4
    strength: float = strength(0.1, 1.5, "standard deviations")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.maximum(np.rint(x + rng.laplace(0, self.strength * self.place.std / np.sqrt(2), x.shape)), 0)


@dataclass(frozen=True)
class StuckBit(Change):
    """A bit of the counter sticks at zero in some of the intervals."""

    name: ClassVar = "quantisation"
    source: ClassVar = "stuck bits of converters and scalers"
    stage: ClassVar = 4
    strength: float = strength(0.02, 1, "share of the intervals")
    bit: float = drawn(0, 2, "which bit, rounded down")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = 2 ** int(self.bit)
        stuck = rng.random(x.shape) < self.strength
        return np.where(stuck & (x // step % 2 == 1), x - step, x)


@dataclass(frozen=True)
class CoarseRange(Change):
    """Above some count the converter changes to a range with larger steps, and cuts down to them."""

    name: ClassVar = "quantisation"
    source: ClassVar = "dual-range converters"
    stage: ClassVar = 4
    strength: float = strength(0.05, 1, "share of the intervals in the coarse range")
    step: float = drawn(2, 5, "counts, rounded down")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        knee = np.quantile(self.place.reference[:, self.place.columns], 1 - min(self.strength, 1), axis=0)
        step = int(self.step)
        return np.where(x >= knee, x - x % step, x)
