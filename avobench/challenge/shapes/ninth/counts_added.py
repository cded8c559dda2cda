"""What adds counts to an event or disturbs the reading of its count."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Replacement, Simulate, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class ComptonContinuum(Counting, Replacement):
    """Some events are gamma rays from the walls that scatter once in the counter and leave.

    They deposit anything up to the Compton edge, about evenly, with a rise towards the edge.
    """

    strength: float = strength(0.003, 0.15)
    edge: float = drawn(1.6, 3.0)
    """Counts at the Compton edge, relative to the mean."""
    rise: float = drawn(0.0, 0.8)
    """How much more often energies at the edge are met than those near zero."""

    name = "flat_background"
    source = "gamma spectroscopy with scintillators"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        u = rng.random((n, 1))
        rising = rng.random((n, 1)) < self.rise / (3 + self.rise)
        deposit = np.where(rising, np.cbrt(u), u)
        return rng.poisson(self.edge * self.mean * deposit).astype(float)


@dataclass(frozen=True)
class RadioactiveGlass(Counting, Change):
    """In some events a nucleus in the glass of the counter decays while the gate is open.

    The electron adds counts of the broad beta spectrum to those of the event.
    """

    strength: float = strength(0.003, 0.15)
    endpoint: float = drawn(1.5, 4.0)
    """Counts at the end of the beta spectrum, relative to the mean."""

    name = "flat_background"
    source = "potassium-40 in photomultiplier glass"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        energy = rng.beta(1.5, 2.5, x.shape)
        return x + (rng.random(x.shape) < self.strength) * rng.poisson(self.endpoint * self.mean * energy)


@dataclass(frozen=True)
class RingingPulse(Counting, Change):
    """Pulses ring on a badly terminated cable, and each swing may pass the discriminator once more.

    A pulse is counted again as long as its swings go on passing.
    """

    strength: float = strength(0.01, 0.3)
    """Probability that a further swing passes after the last one did."""

    name = "double_counting"
    source = "reflections in pulse counting"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        again = rng.negative_binomial(np.maximum(x, 1), 1 - self.strength)
        return x + np.where(x > 0, again, 0)


@dataclass(frozen=True)
class MergedEvents(Counting):
    """The event builder misses the mark between two events and writes both as one.

    Such a record has the sum of two full counts.
    """

    strength: float = strength(0.002, 0.15)
    """Share of the records that hold two events."""

    name = "double_counting"
    source = "event builders of data acquisition"
    stage = 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        merged = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(merged):
            x[merged] += simulate(theta[merged], rng)
        return x


@dataclass(frozen=True)
class MainsHum(Counting, Change):
    """The amplifier picks up the hum of the mains, and an event is read at a random phase of it.

    The reading swings by a sine, on top of a weaker thermal noise.
    """

    strength: float = strength(0.2, 1.5)
    """Amplitude of the hum, in standard deviations of the counts."""
    thermal: float = drawn(0.3, 0.8)
    """Standard deviation of the thermal noise, relative to the amplitude of the hum."""

    name = "readout_noise"
    source = "charge amplifiers with ground loops"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        noise = np.sin(rng.uniform(0, 2 * np.pi, x.shape)) + self.thermal * rng.standard_normal(x.shape)
        return np.maximum(np.rint(x + self.strength * self.place.std * noise), 0)


@dataclass(frozen=True)
class GainStages(Counting, Change):
    """The front end reads small signals at high gain and switches to low gain for larger ones.

    The noise of the digitiser then weighs much more in counts above the switch than below.
    """

    strength: float = strength(0.2, 1.5)
    """Noise at low gain, in standard deviations of the counts."""
    switch: float = drawn(0.2, 0.6)
    """Share of the counts that are read at high gain."""
    ratio: float = drawn(3.0, 8.0)
    """Of the two gains."""

    name = "readout_noise"
    source = "calorimeter front ends with automatic gain"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        noise = self.strength * self.place.std * np.where(x > self.quantile(self.switch), 1, 1 / self.ratio)
        return np.maximum(np.rint(x + noise * rng.standard_normal(x.shape)), 0)


@dataclass(frozen=True)
class RootCompression(Counting, Change):
    """When its buffer is full, telemetry sends the square root of a count with few bits, to be squared on the ground.

    The steps between the values that then arrive grow as the square root of the count.
    """

    strength: float = strength(0.02, 1.0)
    """Share of the counts that are sent in this way."""
    step: float = drawn(0.35, 1.0)
    """Of the square root."""
    phase: float = drawn(0.0, 1.0)
    """Where the first level lies, in steps."""

    name = "quantisation"
    source = "on-board compression in space missions"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        level = np.rint(np.sqrt(x) / self.step - self.phase) + self.phase
        return np.where(rng.random(x.shape) < self.strength, np.rint((self.step * level) ** 2), x)


@dataclass(frozen=True)
class HangingBit(Counting, Change):
    """One of the low bits of the register hangs at one in a part of the readings.

    Counts with this bit set are then met too often, and those without it too rarely.
    """

    strength: float = strength(0.01, 0.9)
    """Share of the readings in which the bit hangs."""
    weight: float = drawn(0.3, 0.9)
    """Largest weight that the bit may have, in standard deviations of the counts."""

    name = "quantisation"
    source = "sticky codes of analogue-to-digital converters"
    stage = 4

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bit = 1 << int(np.log2(max(self.weight * self.place.std[0], 1)))
        hangs = rng.random(x.shape) < self.strength
        return np.where(hangs, x.astype(np.int64) | bit, x).astype(float)


@dataclass(frozen=True)
class SlowTail(Counting):
    """The light of the event before decays slowly, and its tail falls into the gate of the next one.

    How much of it does depends on the time between the two, which is random.
    """

    strength: float = strength(0.03, 0.6)
    """Share of an event's counts that falls into one that follows at once."""
    spacing: float = drawn(0.3, 2.0)
    """Decay time of the light, relative to the mean time between events."""

    name = "pile_up"
    source = "slow scintillators at high rates"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x, before = simulate(theta, rng), simulate(theta, rng)
        left = self.strength * np.exp(-rng.exponential(size=x.shape) / self.spacing)
        return x + rng.binomial(before, left).astype(x.dtype)


@dataclass(frozen=True)
class CrowdedCrossing(Counting, Change):
    """Every crossing of the beams brings further soft collisions, whose counts are read with the event.

    Their number differs from crossing to crossing, and each brings a few counts of its own.
    """

    strength: float = strength(0.03, 0.6)
    """Counts that they bring on average, relative to the mean."""
    crowd: float = drawn(2.0, 12.0)
    """Mean number of further collisions in a crossing."""

    name = "pile_up"
    source = "hadron colliders at high luminosity"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        collisions = rng.poisson(self.crowd, x.shape)
        return x + rng.poisson(self.strength * self.mean / self.crowd * collisions)


FAMILIES: tuple[type[Injection], ...] = (
    ComptonContinuum,
    RadioactiveGlass,
    RingingPulse,
    MergedEvents,
    MainsHum,
    GainStages,
    RootCompression,
    HangingBit,
    SlowTail,
    CrowdedCrossing,
)
