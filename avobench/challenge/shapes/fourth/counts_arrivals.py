"""Counts: what happens from the source to the counter."""

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Replacement, Simulate, drawn, strength
from avobench.challenge.shapes.fourth.scales import mean_count

CHUNK = 1024
"""Events whose arrival times are held at once."""


def at_rate(
    simulate: Simulate, theta: NDArray[np.float64], factor: NDArray[np.float64], rng: np.random.Generator
) -> NDArray:
    """Events each at its own multiple (n,) of the rate: whole events and a thinned one are superposed."""
    x = simulate(theta, rng)
    total = rng.binomial(x, np.minimum(factor, 1)[:, None]).astype(x.dtype)
    for whole in range(1, int(np.ceil(factor.max()))):
        rows = np.flatnonzero(factor > whole)
        more = simulate(theta[rows], rng)
        total[rows] += rng.binomial(more, np.minimum(factor[rows] - whole, 1)[:, None]).astype(x.dtype)
    return total


def arrivals(counts: NDArray, rng: np.random.Generator) -> Iterator[tuple[slice, NDArray[np.float32]]]:
    """Times of the counts of each event in a gate [0, 1], sorted along a row; 2 beyond its number."""
    for start in range(0, len(counts), CHUNK):
        some = counts[start : start + CHUNK]
        most = int(some.max(initial=0))
        times = rng.standard_exponential((len(some), most + 1), dtype=np.float32).cumsum(axis=1)
        times /= times[np.arange(len(some)), some][:, None]
        times[np.arange(most + 1) >= some[:, None]] = 2
        yield slice(start, start + len(some)), times[:, :most]


class OwnRate(Injection):
    """An injection that gives every event its own rate."""

    stage = 1

    @abstractmethod
    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """By which the rate of each of n events is multiplied; one in the mean."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return at_rate(simulate, theta, self.factor(len(theta), rng), rng)


@dataclass(frozen=True)
class TelegraphSource(OwnRate):
    """The source jumps to and fro between a brighter and a dimmer state, and an event is taken in either of them."""

    name = "overdispersion"
    source = "mode hopping of diode lasers"

    strength: float = strength(0.04, 0.35, "of the rate, rms")
    bright: float = drawn(0.3, 0.7, "of the time")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        odds = np.sqrt((1 - self.bright) / self.bright)
        return 1 + self.strength * np.where(rng.random(n) < self.bright, odds, -1 / odds)


@dataclass(frozen=True)
class DecayingSource(OwnRate):
    """The source is a short-lived nuclide that decays while the events are taken, so early events have a higher rate
    than late ones."""

    name = "overdispersion"
    source = "counting of activated foils and F-18"

    strength: float = strength(0.15, 1.4, "lifetimes")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return np.exp(-self.strength * rng.random(n)) * self.strength / -np.expm1(-self.strength)


@dataclass(frozen=True)
class RecoveringTube(Change):
    """After each pulse the tube regains its field only gradually, so that a pulse soon after another is too small to
    be counted, the more likely the sooner it comes."""

    name = "dead_time"
    source = "recovery of Geiger-Mueller tubes (Stever 1942)"

    strength: float = strength(0.01, 0.4, "recovery time over mean gap")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        counts = x[:, 0].astype(int)
        seen = np.empty(len(x))
        recovery = self.strength / mean_count(self.place)
        for rows, times in arrivals(counts, rng):
            gaps = times[:, 1:] - times[:, :-1]
            blind = recovery * rng.standard_exponential(gaps.shape, dtype=np.float32)
            missed = ((gaps < blind) & (times[:, 1:] < 2)).sum(axis=1)
            seen[rows] = counts[rows] - missed
        return seen[:, None]


@dataclass(frozen=True)
class ConversionTime(Change):
    """The converter is busy after each pulse that it accepts, for a time that grows with the size of the pulse, and
    sees nothing of what comes meanwhile."""

    name = "dead_time"
    source = "Wilkinson converters, whose run-down takes as long as the pulse is high"

    strength: float = strength(0.01, 0.4, "mean conversion over mean gap")
    fixed: float = drawn(0.2, 0.8, "of the conversion that is the same for all")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        counts = x[:, 0].astype(int)
        seen = np.zeros(len(x))
        mean = self.strength / mean_count(self.place)
        for rows, times in arrivals(counts, rng):
            busy = mean * (self.fixed + (1 - self.fixed) * rng.standard_exponential(times.shape, dtype=np.float32))
            free = np.zeros(len(times), dtype=np.float32)
            for at, ready in zip(times.T.copy(), (times + busy).T.copy(), strict=True):
                accepted = (at >= free) & (at < 2)
                free = np.where(accepted, ready, free)
                seen[rows] += accepted
        return seen[:, None]


@dataclass(frozen=True)
class SlowTail(Injection):
    """The light of the event before has not died out when the gate opens, and the rest of its counts fall into this
    one: many if it was recent, few if it was long ago."""

    name = "pile_up"
    source = "slow component of inorganic scintillators"
    stage = 4

    strength: float = strength(0.1, 1.0, "of the counts of an event just before")
    gap: float = drawn(0.5, 2.0, "decay times between events")

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x, before = simulate(theta, rng), simulate(theta, rng)
        left = self.strength * np.exp(-self.gap * rng.exponential(size=(len(x), 1)))
        return x + rng.binomial(before, left).astype(x.dtype)


@dataclass(frozen=True)
class LongGate(Injection):
    """The gate is longer than the spacing of events, so that further events begin in it, and their counts up to its
    end are taken along."""

    name = "pile_up"
    source = "integration gates over several bunch crossings"
    stage = 4

    strength: float = strength(0.01, 0.5, "further events a gate")

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        further = rng.poisson(self.strength, len(x))
        for k in range(int(further.max(initial=0))):
            rows = np.flatnonzero(further > k)
            x[rows] += rng.binomial(simulate(theta[rows], rng), rng.random((len(rows), 1))).astype(x.dtype)
        return x


@dataclass(frozen=True)
class LightCrosstalk(Change):
    """The avalanche of a count shines into neighbouring cells and fires some of them, and these can fire others in
    their turn."""

    name = "after_pulses"
    source = "silicon photomultipliers (Vinogradov 2012)"

    strength: float = strength(0.01, 0.35, "cells fired by a count")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        total, last = x.copy(), x
        while last.any():
            last = rng.poisson(self.strength * last)
            total += last
        return total


@dataclass(frozen=True)
class IonFeedback(Change):
    """Now and then a count sets an ion free that drifts back to the cathode and knocks out several electrons, and each
    of them is counted as a further pulse."""

    name = "after_pulses"
    source = "residual gas in photomultipliers"

    strength: float = strength(0.003, 0.1, "ions a count")
    electrons: float = drawn(1.0, 3.0, "an ion")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        ions = rng.binomial(x.astype(int), self.strength)
        return x + rng.poisson(self.electrons * ions)


@dataclass(frozen=True)
class RandomGates(Replacement):
    """Some events are gates of a faulty timer, of any length up to several times the usual one, filled with stray
    light at a steady rate."""

    name = "flat_background"
    source = "timer faults in photon counters"

    strength: float = strength(0.002, 0.15, "of events")
    longest: float = drawn(2.0, 5.0, "of a typical event's counts")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.poisson(self.longest * mean_count(self.place) * rng.random((n, 1))).astype(float)


@dataclass(frozen=True)
class Showers(Replacement):
    """Some events are not the source's but cosmic-ray showers, of which there are as many in each octave of the number
    of counts, from a few up to far more than an event of the source has."""

    name = "flat_background"
    source = "extensive showers in neutron monitors"

    strength: float = strength(0.002, 0.15, "of events")
    largest: float = drawn(3.0, 8.0, "of a typical event's counts")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        low, high = 0.2 * mean_count(self.place), self.largest * mean_count(self.place)
        return np.rint(low * (high / low) ** rng.random((n, 1)))


@dataclass(frozen=True)
class BothEdges(Change):
    """In some events the scaler counts on both edges of the pulses, not on the leading edge alone, and so counts every
    one of them twice."""

    name = "double_counting"
    source = "badly terminated cables at scaler inputs"

    strength: float = strength(0.002, 0.15, "of events")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, 2 * x, x)


@dataclass(frozen=True)
class MissedReset(Injection):
    """In some events the scaler was not set back to zero before, so that it shows this event and the one before
    together."""

    name = "double_counting"
    source = "event builders that merge two triggers into one record"

    strength: float = strength(0.002, 0.15, "of events")

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        rows = np.flatnonzero(rng.random(len(x)) < self.strength)
        x[rows] += simulate(theta[rows], rng)
        return x


FAMILIES = (
    TelegraphSource,
    DecayingSource,
    RecoveringTube,
    ConversionTime,
    SlowTail,
    LongGate,
    LightCrosstalk,
    IonFeedback,
    RandomGates,
    Showers,
    BothEdges,
    MissedReset,
)
