"""What happens to single pulses within a counting interval. Pulses arrive at uniform times in [0, 1]."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Simulate, drawn, strength


def arrivals(x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """When the first pulse of every interval arrives, the second and so on; 2 where there is none: (n, 1) -> (k, n)."""
    n = x[:, 0].astype(int)
    most = n.max(initial=0)
    return np.sort(np.where(np.arange(most) < n[:, None], rng.random((len(n), most)), 2), 1).T


@dataclass(frozen=True)
class HybridDeadTime(Change):
    """After a pulse the counter is blind for a while, and a pulse that it did not see may prolong this.

    Every pulse is followed in time: with `paralysis` = 0 lost pulses prolong nothing, with 1 each of them does.
    """

    name: ClassVar = "dead_time"
    source: ClassVar = "Lee and Gardner, Applied Radiation and Isotopes 53 (2000) 731; Knoll, Radiation Detection"
    strength: float = strength(0.001, 0.1, "counting intervals")
    paralysis: float = drawn(0, 1)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        n = len(x)
        seen, blind_until = np.zeros(n), np.full(n, -1.0)
        for arrival in arrivals(x, rng):
            here = arrival < 1
            found = here & (arrival >= blind_until)
            prolongs = found | (here & (rng.random(n) < self.paralysis))
            blind_until = np.where(prolongs, np.maximum(blind_until, arrival + self.strength), blind_until)
            seen += found
        return seen[:, None]


@dataclass(frozen=True)
class Afterpulses(Change):
    """A pulse may be followed by a second, false one, and that one by a third."""

    name: ClassVar = "double_counting"
    source: ClassVar = "afterpulsing of photomultipliers, a chain with geometric length"
    strength: float = strength(0.003, 0.3, "per pulse")
    chain: float = drawn(0, 1, "share of the strength, for the third pulse and on")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        born = x = x.astype(int)
        probability = self.strength
        while born.any():
            born = rng.binomial(born, probability)
            x = x + born
            probability *= self.chain
        return x


@dataclass(frozen=True)
class LateReset(Injection):
    """Now and then the counter is not reset, and an interval holds the one before it too, or the late part of it."""

    name: ClassVar = "double_counting"
    source: ClassVar = "readout that misses a reset: two intervals in one"
    strength: float = strength(0.003, 0.3, "share of the intervals")
    least: float = drawn(0.6, 1, "least part of the earlier interval")

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        late = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(late):
            before = simulate(theta[late], rng)
            x[late] += rng.binomial(before, rng.uniform(self.least, 1, before.shape))
        return x


@dataclass(frozen=True)
class UnevenPileUp(Change):
    """Pulses of another source are counted as well; its rate varies a little from interval to interval."""

    name: ClassVar = "pile_up"
    source: ClassVar = "beam-related background whose rate follows the beam"
    stage: ClassVar = 1
    strength: float = strength(0.005, 0.3, "of the mean count")
    variation: float = drawn(0, 0.1)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        rate = self.strength * self.place.reference[:, self.place.columns].mean(axis=0)
        return x + rng.poisson(rate * (1 + self.variation * rng.uniform(-1, 1, x.shape)))


@dataclass(frozen=True)
class UnevenInefficiency(Change):
    """Each pulse is lost with a probability that varies a little from interval to interval."""

    name: ClassVar = "inefficiency"
    source: ClassVar = "efficiency of a counter whose high voltage drifts"
    stage: ClassVar = 1
    strength: float = strength(0.005, 0.3)
    variation: float = drawn(0, 0.1)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        loss = self.strength * (1 + self.variation * rng.uniform(-1, 1, x.shape))
        return rng.binomial(x.astype(int), 1 - loss)
