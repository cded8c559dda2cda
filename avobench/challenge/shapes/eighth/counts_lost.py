"""Counts, and events with a count, that are lost."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avobench.challenge.shapes.contract import Change, Injection, Selection, drawn, strength
from avobench.challenge.shapes.places import Counting


def level(shape: Counting, share: float) -> float:
    """Where about a share of the counts lies below, as a real number."""
    return shape.mean + float(ndtri(share)) * float(shape.place.std[0])


@dataclass(frozen=True)
class StickingShutter(Counting, Change):
    """The shutter sometimes does not open. What then reaches the counter is the small part of the light that leaks
    through its blades.
    """

    name: ClassVar = "zero_inflation"
    source: ClassVar = "mechanical shutter of a photon counter"

    strength: float = strength(0.002, 0.15)
    leak: float = drawn(0.001, 0.03, log=True)
    """Share of the light that passes the closed shutter."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        closed = rng.random(x.shape) < self.strength
        return np.where(closed, rng.binomial(x.astype(int), self.leak), x)


@dataclass(frozen=True)
class FailedChecksum(Counting, Change):
    """Each count is a word of a data packet, and any word may be corrupted on its way. A packet whose checksum then
    fails is written as an empty event.
    """

    name: ClassVar = "zero_inflation"
    source: ClassVar = "serial readout of a detector over a noisy link"
    stage: ClassVar = 4

    strength: float = strength(0.002, 0.15)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        intact = np.exp(-self.strength * x / self.mean)
        return np.where(rng.random(x.shape) < intact, x, 0)


@dataclass(frozen=True)
class ExtendingDeadTime(Counting, Change):
    """A particle that reaches the tube while it recovers is not counted and makes the recovery begin anew. A particle
    is therefore counted only if none came shortly before it.
    """

    name: ClassVar = "dead_time"
    source: ClassVar = "Geiger-Mueller tube, paralysable"

    strength: float = strength(0.01, 0.4)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        alone = (1 - self.strength / self.mean) ** np.maximum(x - 1, 0)
        return rng.binomial(x.astype(int), alone).astype(float)


@dataclass(frozen=True)
class OneCountAPulse(Counting, Change):
    """The light comes in many laser pulses, and after its first count in a pulse the counter is blind until the next
    pulse. Photons that share a pulse are counted as one.
    """

    name: ClassVar = "dead_time"
    source: ClassVar = "time-correlated single photon counting"

    strength: float = strength(0.015, 0.6)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        counted = np.zeros(x.shape)
        for k in range(int(x.max(initial=0))):
            counted += (k < x) & (rng.random(x.shape) >= counted * self.strength / self.mean)
        return counted


@dataclass(frozen=True)
class NoisyComparator(Counting, Selection):
    """A comparator starts the readout when the summed signal exceeds its threshold, and the noise on its input blurs
    where that happens. Events with few counts mostly fail to start it.
    """

    name: ClassVar = "threshold_loss"
    source: ClassVar = "analogue sum trigger"

    strength: float = strength(0.004, 0.3)
    """About the share of the events below the threshold."""
    noise: float = drawn(0.1, 0.4, "std")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return ndtr((x[:, 0] - level(self, self.strength)) / (self.noise * self.place.std[0]))


@dataclass(frozen=True)
class PrescaledTrigger(Counting, Selection):
    """Events below a threshold are accepted only by a second trigger that takes a fixed share of them. The others of
    these events with few counts are not recorded.
    """

    name: ClassVar = "threshold_loss"
    source: ClassVar = "prescaled low-threshold trigger of a collider experiment"

    strength: float = strength(0.05, 1)
    """Share of the events below the threshold that is lost."""
    below: float = drawn(0.1, 0.35)
    """About the share of the events below the threshold."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return np.where(x[:, 0] < level(self, self.below), 1 - self.strength, 1.0)


@dataclass(frozen=True)
class FullBuffer(Counting, Selection):
    """The buffer that takes up an event has a fixed number of places, one a count. An event that has more counts
    overruns it and is discarded.
    """

    name: ClassVar = "truncation"
    source: ClassVar = "front-end memory of a pixel chip"

    strength: float = strength(0.001, 0.3)
    """About the share of the events that overrun the buffer."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return (x[:, 0] <= level(self, 1 - self.strength)).astype(float)


@dataclass(frozen=True)
class LongestPacket(Counting, Selection):
    """An event is sent as one packet of limited length, which it shares with housekeeping data whose length varies from
    packet to packet. Events with so many counts that both do not fit are not sent.
    """

    name: ClassVar = "truncation"
    source: ClassVar = "telemetry of a gamma-ray satellite"

    strength: float = strength(0.002, 0.3)
    """About the share of the events that do not fit even without housekeeping data."""
    housekeeping: float = drawn(0.1, 0.4, "std")
    """Mean length of the housekeeping data, which is distributed exponentially."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        room = level(self, 1 - self.strength) - x[:, 0]
        return -np.expm1(-np.maximum(room, 0) / (self.housekeeping * self.place.std[0]))


FAMILIES: tuple[type[Injection], ...] = (
    StickingShutter,
    FailedChecksum,
    ExtendingDeadTime,
    OneCountAPulse,
    NoisyComparator,
    PrescaledTrigger,
    FullBuffer,
    LongestPacket,
)
