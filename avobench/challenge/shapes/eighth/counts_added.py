"""Counts that are added, and sources that do not shine evenly."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Replacement, Simulate, drawn, strength
from avobench.challenge.shapes.places import Counting


class Unsteady(Counting):
    """A source that is brighter in some events than in others, with the mean that it should have."""

    stage: ClassVar = 1

    @abstractmethod
    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """In n events, relative to what it should be: (n,)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        brightness = self.brightness(len(theta), rng)[:, None]
        x = simulate(theta, rng)
        total = rng.binomial(x.astype(int), np.minimum(brightness, 1))
        for k in range(1, int(np.ceil(brightness.max(initial=0)))):
            rows = np.flatnonzero(brightness[:, 0] > k)
            total[rows] += rng.binomial(simulate(theta[rows], rng).astype(int), np.minimum(brightness[rows] - k, 1))
        return total.astype(x.dtype)


@dataclass(frozen=True)
class MainsHum(Unsteady):
    """The lamp runs on alternating current, and its brightness follows a sine. Each event is a short exposure at a
    random moment of the cycle.
    """

    name: ClassVar = "overdispersion"
    source: ClassVar = "lamp on mains power before a photon counter"

    strength: float = strength(0.015, 1.5)
    """Excess of the variance, relative to that of the counts of a steady lamp."""

    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        amplitude = min(np.sqrt(2 * self.strength / self.mean), 1)
        return 1 + amplitude * np.sin(2 * np.pi * rng.random(n))


@dataclass(frozen=True)
class MoleculesInFocus(Unsteady):
    """The light comes from a limited number of molecules that wander through the focus. The source is as bright as the
    number of them that happen to be there.
    """

    name: ClassVar = "overdispersion"
    source: ClassVar = "fluorescence correlation spectroscopy"

    strength: float = strength(0.015, 1.5)
    """Counts that come from one molecule."""

    def brightness(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        molecules = self.mean / self.strength
        return rng.poisson(molecules, n) / molecules


@dataclass(frozen=True)
class PulserLeftOn(Counting, Replacement):
    """A test pulser that ramps through the whole scale was left on during the measurement. Some events are its pulses,
    with every number of counts alike.
    """

    name: ClassVar = "flat_background"
    source: ClassVar = "ramp pulser for the calibration of a scaler"

    strength: float = strength(0.003, 0.2)
    reach: float = drawn(2, 4)
    """End of the ramp, in units of the mean count."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.integers(0, int(self.reach * self.mean) + 1, (n, 1)).astype(float)


@dataclass(frozen=True)
class CosmicShowers(Counting, Change):
    """Now and then a cosmic particle showers in the shielding while an event is taken. It adds counts whose number
    falls off exponentially over a range wider than that of the events.
    """

    name: ClassVar = "flat_background"
    source: ClassVar = "low-background counting above ground"
    stage: ClassVar = 4

    strength: float = strength(0.003, 0.2)
    """Share of the events with a shower."""
    size: float = drawn(0.7, 2)
    """Mean number of counts of a shower, in units of the mean count."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        shower = rng.random(x.shape) < self.strength
        return x + shower * rng.geometric(1 / (1 + self.size * self.mean), x.shape)


@dataclass(frozen=True)
class Afterpulses(Counting, Change):
    """Each count may set free a trapped charge that causes another count a little later. This one may cause the next,
    so that short chains of counts arise.
    """

    name: ClassVar = "double_counting"
    source: ClassVar = "single-photon avalanche diode"

    strength: float = strength(0.008, 0.3)
    """Probability that a count causes another."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x + np.where(x > 0, rng.negative_binomial(np.maximum(x, 1), 1 - self.strength), 0)


@dataclass(frozen=True)
class Doublets(Counting, Injection):
    """Two cells sometimes stick together and enter one droplet. They are then recorded as a single cell that has the
    counts of both.
    """

    name: ClassVar = "double_counting"
    source: ClassVar = "single-cell sequencing in droplets"

    strength: float = strength(0.002, 0.2)
    """Share of the droplets with two cells."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        double = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(double):
            x[double] += simulate(theta[double], rng)
        return x


@dataclass(frozen=True)
class OverlappingWindows(Counting, Change):
    """The counting window closes late, by a time that varies from event to event. Until it closes, it takes in counts
    of the event next to it.
    """

    name: ClassVar = "pile_up"
    source: ClassVar = "gated counter with a jittering gate"
    stage: ClassVar = 4

    strength: float = strength(0.4, 2.2, "std")
    """Counts of the neighbour that the longest overlap takes in."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        longest = min(self.strength * float(self.place.std[0]) / self.mean, 1)
        neighbour = np.roll(x, 1, axis=0).astype(int)
        return x + rng.binomial(neighbour, longest * rng.random(x.shape))


@dataclass(frozen=True)
class SoftCollisions(Counting, Change):
    """In each crossing of the beams a varying number of further, softer collisions takes place. Their counts fall into
    the event that is recorded.
    """

    name: ClassVar = "pile_up"
    source: ClassVar = "proton collider at high luminosity"
    stage: ClassVar = 4

    strength: float = strength(0.08, 0.8, "std")
    """Mean count of one soft collision."""
    collisions: float = drawn(1, 4)
    """Mean number of soft collisions in an event."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        number = rng.poisson(self.collisions, x.shape)
        return x + rng.poisson(number * self.strength * self.place.std[0])


FAMILIES: tuple[type[Injection], ...] = (
    MainsHum,
    MoleculesInFocus,
    PulserLeftOn,
    CosmicShowers,
    Afterpulses,
    Doublets,
    OverlappingWindows,
    SoftCollisions,
)
