"""Counts that are too many, or vary too much: varying sources, other events, pulses counted again."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Replacement, Simulate, drawn, strength
from avobench.challenge.shapes.places import Counting

BRIGHTEST = 4.0
"""Of what a flare adds, relative to the quiet source."""
MOST_EVENTS = 5
"""That are piled on one."""


class Variable(Counting):
    """A source whose brightness differs from event to event."""

    stage = 1

    @abstractmethod
    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Of the source in n events, where 1 is what the simulator has: (n,)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        bright = self.brightness(len(theta), rng)[:, None]
        x = simulate(theta, rng)
        total = rng.binomial(x, np.minimum(bright, 1))
        for whole in range(1, int(np.ceil(bright.max()))):
            total += rng.binomial(simulate(theta, rng), np.clip(bright - whole, 0, 1))
        return total.astype(x.dtype)


@dataclass(frozen=True)
class PassingCirrus(Variable):
    """Thin high clouds drift across the sky in part of the exposures and dim the star, in some a little and in some
    much.
    """

    name = "overdispersion"
    source = "extinction of starlight by cirrus"

    strength: float = strength(0.05, 1.0)
    """Mean optical depth of a cloud."""
    cover: float = drawn(0.3, 0.8)
    """Share of the exposures with a cloud."""

    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return np.exp(-self.strength * rng.standard_exponential(n) * (rng.random(n) < self.cover))


@dataclass(frozen=True)
class FlaringBlazar(Variable):
    """The source is an active galaxy that flares: in part of the exposures it is brighter, by an amount that differs
    from flare to flare.
    """

    name = "overdispersion"
    source = "flares of blazars in gamma rays"

    strength: float = strength(0.1, 1.5)
    """Mean of what a flare adds, relative to the quiet source."""
    duty: float = drawn(0.1, 0.5)
    """Share of the exposures with a flare."""

    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        flare = np.minimum(self.strength * rng.standard_exponential(n), BRIGHTEST)
        return 1 + flare * (rng.random(n) < self.duty)


@dataclass(frozen=True)
class AirShowerTriggers(Counting, Replacement):
    """Some of the events are showers from high in the air, of any size: as many between 1 and 10 hits as between 10
    and 100.
    """

    name = "flat_background"
    source = "air showers that trigger an underground counter"

    strength: float = strength(0.005, 0.2)
    reach: float = drawn(1.5, 4.0)
    """The largest of them, relative to the largest ordinary event."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        largest = self.reach * max(self.quantile(0.995), 5)
        return np.floor(np.exp(rng.uniform(0, np.log(largest + 1), (n, 1))))


@dataclass(frozen=True)
class PulserSweep(Counting, Replacement):
    """A test pulser was left on. Its rate swings up and down over the whole scale of the counter, and some of the
    events are its own.
    """

    name = "flat_background"
    source = "a swept test pulser left connected"

    strength: float = strength(0.005, 0.2)
    reach: float = drawn(1.2, 3.0)
    """The highest rate, relative to the largest ordinary event."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        highest = self.reach * max(self.quantile(0.995), 4)
        return rng.poisson(highest * (1 - np.cos(rng.uniform(0, np.pi, (n, 1)))) / 2).astype(float)


@dataclass(frozen=True)
class BouncingReed(Counting, Change):
    """The reed switch of a rain gauge bounces: one tip of the bucket closes it twice, and now and then more often, so
    that it is counted several times.
    """

    name = "double_counting"
    source = "contact bounce in tipping-bucket rain gauges"

    strength: float = strength(0.01, 0.5)
    """Share of the tips that bounce."""
    again: float = drawn(0.1, 0.7)
    """Probability that a bounce is followed by one more."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bounces = rng.binomial(x.astype(int), self.strength)
        further = rng.negative_binomial(np.maximum(bounces, 1), 1 - self.again)
        return x + bounces + np.where(bounces > 0, further, 0)


@dataclass(frozen=True)
class RingBufferReread(Counting, Change):
    """The list of pulses is kept in a ring buffer. When the reader overtakes the writer it reads a stretch of the list
    once more, and the pulses in it are counted twice.
    """

    name = "double_counting"
    source = "ring buffers of waveform digitisers read beyond the write pointer"

    strength: float = strength(0.01, 0.5)
    """Share of the events in which that happens."""
    stretch: float = drawn(0.2, 0.8)
    """The longest, as a share of the list."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        stretch = self.stretch * rng.uniform(0.5, 1, x.shape) * (rng.random(x.shape) < self.strength)
        return x + rng.binomial(x.astype(int), stretch)


@dataclass(frozen=True)
class ScintillatorAfterglow(Counting, Change):
    """A crystal goes on glowing after each event. When the next one follows closely, it contains a part of the counts
    of the one before, the more the closer it follows.
    """

    name = "pile_up"
    source = "afterglow of caesium iodide in computed tomography"
    stage = 4

    strength: float = strength(0.01, 0.5)
    """Share of the events that follow closely."""
    fading: float = drawn(0.1, 1.0)
    """Of the glow in the time within which they follow: 0 for a glow that stays."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        left = rng.random(x.shape) ** self.fading * (rng.random(x.shape) < self.strength)
        return x + rng.binomial(np.roll(x, 1, axis=0).astype(int), left)


@dataclass(frozen=True)
class UnevenBunches(Counting):
    """The bunches of a beam are unequal. A full one makes several collisions at a time, and their counts are added to
    those of the event; the gate cuts some of them off.
    """

    name = "pile_up"
    source = "pile-up from unequal bunches of a storage ring"
    stage = 4

    strength: float = strength(0.01, 0.6)
    """Mean number of further collisions."""
    gate: float = drawn(0.6, 1.0)
    """Share of their counts within the gate."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        further = np.minimum(rng.geometric(1 / (1 + self.strength), x.shape) - 1, MOST_EVENTS)
        total = x.copy()
        for k in range(int(further.max())):
            total += rng.binomial(simulate(theta, rng), np.where(k < further, self.gate, 0)).astype(x.dtype)
        return total
