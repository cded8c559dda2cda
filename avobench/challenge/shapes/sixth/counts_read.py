"""Counts that are read out wrong: upset bits, trembling needles, coarse registers, upper ends."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, drawn, strength
from avobench.challenge.shapes.places import Counting


class Register(Counting, Change):
    """A wrong reading of a right count."""

    stage = 4


@dataclass(frozen=True)
class SingleEventUpset(Register):
    """A heavy ion flips one bit of the register before it is read. The number read is too large or too small by a
    power of two.
    """

    name = "readout_noise"
    source = "single-event upsets in the memory of satellites"

    strength: float = strength(0.005, 0.4)
    """Share of the readings with a flipped bit."""
    lowness: float = drawn(0.7, 2.0)
    """How much more often it is a low bit: 1 for all alike."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bits = np.ceil(np.log2(max(self.quantile(0.995), 2) + 1))
        flipped = np.left_shift(1, (bits * rng.random(x.shape) ** self.lowness).astype(int))
        upset = rng.random(x.shape) < self.strength
        return np.where(upset, np.bitwise_xor(x.astype(int), flipped), x)


@dataclass(frozen=True)
class TremblingNeedle(Register):
    """The count is read by eye from the needle of a ratemeter, which trembles, more so at high rates. Most readings are
    close and some are far off.
    """

    name = "readout_noise"
    source = "analogue ratemeters read by eye"

    strength: float = strength(0.1, 1.2)
    """Standard deviation at the mean count, relative to the counts' own spread."""
    growth: float = drawn(0.2, 1.0)
    """Power of the count with which the trembling grows."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        size = self.strength * self.place.std * (x / self.mean) ** self.growth
        read = x + rng.laplace(0, 1 / np.sqrt(2), x.shape) * size
        return np.maximum(np.floor(read + rng.random(x.shape)), 0)


@dataclass(frozen=True)
class SquareRootCompression(Register):
    """To save telemetry a probe sends the square root of each count, rounded. Squared again on the ground, the counts
    stand on a ladder whose steps grow upwards.
    """

    name = "quantisation"
    source = "square-root compression of images on board of probes"

    strength: float = strength(0.8, 4.0)
    """Step, relative to the counts' own spread."""
    phase: float = drawn(-0.1, 0.1)
    """Of the ladder, in steps."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        steps = 2 / self.strength
        return np.rint((np.maximum(np.rint(np.sqrt(x) * steps + self.phase) - self.phase, 0) / steps) ** 2)


@dataclass(frozen=True)
class PrescalerCarry(Register):
    """Part of the runs was counted behind a prescaler, which passes every n-th pulse on. What is left in it counts for
    the next event, so the numbers are multiples of n.
    """

    name = "quantisation"
    source = "decade prescalers of early scalers"

    strength: float = strength(0.02, 1.0)
    """Share of the events counted behind it."""
    ratio: float = drawn(2, 10, log=True)
    """n, rounded."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        n = round(self.ratio)
        passed = n * np.floor((x + rng.integers(n, size=x.shape)) / n)
        return np.where(rng.random(x.shape) < self.strength, passed, x)


@dataclass(frozen=True)
class FullWell(Register):
    """A pixel can hold so many electrons and no more. All that is above is read as that number, which differs a little
    from pixel to pixel.
    """

    name = "censoring"
    source = "full wells of charge-coupled devices"

    strength: float = strength(0.01, 0.5)
    """Share of the counts above the well."""
    spread: float = drawn(0.0, 0.03)
    """Of the wells, relative."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        well = max(self.quantile(1 - self.strength), 1) * (1 + self.spread * rng.standard_normal(x.shape))
        return np.minimum(x, np.maximum(np.rint(well), 0))


@dataclass(frozen=True)
class TopCodedForms(Register):
    """The form has a last box "so many or more". Most observers tick it for every larger count, and only few write the
    number beside it.
    """

    name = "censoring"
    source = "top-coded answers on clinical and census forms"

    strength: float = strength(0.01, 0.5)
    """Share of the counts above the last box."""
    obedience: float = drawn(0.6, 1.0)
    """Share of the observers who tick it."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        box = max(round(self.quantile(1 - self.strength)), 1)
        return np.where(rng.random(x.shape) < self.obedience, np.minimum(x, box), x)
