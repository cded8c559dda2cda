"""What makes counts, or events for their counts, get lost."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avobench.challenge.shapes.contract import Change, Injection, Selection, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class HighVoltageTrip(Counting, Change):
    """The high voltage of the tube trips now and then and takes a while to come back. Meanwhile nothing is amplified,
    and an event reads the few counts that the electronics makes in the dark.
    """

    name = "zero_inflation"
    source = "high-voltage trips of photomultipliers and wire chambers"
    strength: float = strength(0.002, 0.12)
    dark: float = drawn(0.002, 0.03, log=True)
    """Counts of an event in the dark, relative to the mean."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        off = rng.random(x.shape) < self.strength
        return np.where(off, rng.poisson(self.dark * self.mean, x.shape), x)


@dataclass(frozen=True)
class TranscriptDropout(Counting, Change):
    """The molecules of a gene are not copied at all in some cells, although they were there, and the cell reads zero.
    This happens the more easily the fewer molecules there were, as the enzyme's kinetics has it.
    """

    name = "zero_inflation"
    source = "dropout in single-cell RNA sequencing (Michaelis-Menten)"
    strength: float = strength(0.002, 0.15)
    """Probability of a dropout at the mean count."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        constant = self.mean * self.strength / (1 - self.strength)
        return np.where(rng.random(x.shape) < constant / (constant + x), 0.0, x)


@dataclass(frozen=True)
class ExtendingDeadTime(Counting, Change):
    """A pulse keeps the discriminator above its level for a while, and a pulse that comes meanwhile is not seen but
    makes this last longer. So a count is recorded only if no other fell into the time just before it.
    """

    name = "dead_time"
    source = "paralysable counters, such as scintillators behind a leading-edge discriminator"
    strength: float = strength(0.01, 0.4)
    """The blind time, relative to the mean distance of two counts."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        alone = (1 - self.strength / self.mean) ** np.maximum(x - 1, 0)
        return rng.binomial(x.astype(np.int64), alone).astype(float)


@dataclass(frozen=True)
class OnePhotonAPeriod(Counting, Change):
    """The timing electronics takes the first photon of a laser period and is then blind until the next pulse of the
    laser. Of several photons in one period only one is counted.
    """

    name = "dead_time"
    source = "time-correlated single-photon counting, fluorescence lifetimes"
    strength: float = strength(0.02, 0.7)
    """Photons a period at the mean count."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        periods = max(round(self.mean / self.strength), 1)
        taken = np.zeros(x.shape)
        for photon in range(int(x.max(initial=0))):
            taken += (photon < x) & (rng.random(x.shape) * periods >= taken)
        return taken


@dataclass(frozen=True)
class NoisyDiscriminator(Counting, Selection):
    """The trigger adds up the counts of an event and compares the sum, which carries noise, with a level. An event with
    too small a sum is not recorded, and around the level it is a matter of chance.
    """

    name = "threshold_loss"
    source = "turn-on curves of sum triggers"
    strength: float = strength(0.005, 0.3)
    """Share of the events below the level, roughly."""
    noise: float = drawn(0.1, 0.5, "std")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        std = self.place.std[0]
        level = self.mean + ndtri(self.strength) * std
        return ndtr((x[:, 0] - level) / (self.noise * std))


@dataclass(frozen=True)
class Prescaled(Counting, Selection):
    """Events with fewer counts than a threshold are thought dull and are thrown away by the trigger. A random part of
    them is recorded nevertheless, as a sample for checks.
    """

    name = "threshold_loss"
    source = "prescaled minimum-bias triggers, zero suppression"
    strength: float = strength(0.12, 0.97)
    """Share of the events below the threshold that is thrown away."""
    below: float = drawn(0.03, 0.25, log=True)
    """Share of the events at the threshold or below it."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        threshold = max(self.quantile(self.below), 1.0)
        return np.where(x[:, 0] < threshold, 1 - self.strength, 1.0)


@dataclass(frozen=True)
class ProcessingTimeout(Counting, Selection):
    """The computer needs a time in proportion to the counts of an event, more or less by how busy it is. An event that
    is not finished at the time limit is dropped.
    """

    name = "truncation"
    source = "timeouts of online event filters"
    strength: float = strength(0.002, 0.3)
    """Share of the events beyond the limit, roughly."""
    spread: float = drawn(0.05, 0.35, "std")
    """Of the logarithm of the time for one count, relative to that of the counts."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        std = self.place.std[0]
        limit = self.mean - ndtri(self.strength) * std
        return ndtr(np.log(limit / np.maximum(x[:, 0], 1)) / (self.spread * std / self.mean))


@dataclass(frozen=True)
class BufferOverflow(Counting, Selection):
    """An event is written into a buffer of limited length in which a rest of earlier events waits to be sent. If its
    counts do not fit into what is free the whole event is discarded.
    """

    name = "truncation"
    source = "front-end buffers of data acquisition, satellite telemetry"
    strength: float = strength(0.002, 0.25)
    """Share of the events that do not even fit into an empty buffer, roughly."""
    rest: float = drawn(0.05, 0.5, "std")
    """Mean length of what waits, which is distributed exponentially."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        std = self.place.std[0]
        free = np.floor(self.mean - ndtri(self.strength) * std) + 1 - x[:, 0]
        return -np.expm1(-np.maximum(free, 0) / (self.rest * std))


FAMILIES: tuple[type[Injection], ...] = (
    HighVoltageTrip,
    TranscriptDropout,
    ExtendingDeadTime,
    OnePhotonAPeriod,
    NoisyDiscriminator,
    Prescaled,
    ProcessingTimeout,
    BufferOverflow,
)
