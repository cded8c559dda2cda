"""Counts that are missing: frames of nothing, pulses behind others, pulses and events that pass no threshold."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import Change, Selection, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class StuckShutter(Counting, Change):
    """The shutter of a camera sometimes stays closed during an exposure, which then holds no count. Now and then it
    sticks half open, and lets a part through.
    """

    name = "zero_inflation"
    source = "shutters of robotic telescopes that fail to open in the cold"

    strength: float = strength(0.005, 0.25)
    """Share of the exposures in which it sticks."""
    ajar: float = drawn(0.0, 0.2)
    """Share of those in which it is half open."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        stuck, ajar = rng.random(x.shape) < self.strength, rng.random(x.shape) < self.ajar
        opening = np.where(stuck, np.where(ajar, rng.random(x.shape), 0), 1)
        return rng.binomial(x.astype(int), opening).astype(float)


@dataclass(frozen=True)
class TelemetryGaps(Counting, Change):
    """The link of a space probe breaks for a while, and the ground station fills the gap with zeros: several events in
    a row hold nothing.
    """

    name = "zero_inflation"
    source = "zero-filled gaps in spacecraft telemetry"
    stage = 4

    strength: float = strength(0.005, 0.25)
    """Gaps begun in the time of one gap."""
    length: float = drawn(2, 40, "events", log=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        length = round(self.length)
        begun = np.cumsum(rng.random(x.shape) < self.strength / length, axis=0)
        before = np.concatenate([np.zeros((length, 1)), begun])[: len(x)]
        return np.where(begun > before, 0, x)


@dataclass(frozen=True)
class OnePerBucket(Counting, Change):
    """A photon counter can fire once in each time bucket of a laser range finder. A photon that falls into a bucket
    with an earlier one is lost, and so is one in a bucket that daylight has filled.
    """

    name = "dead_time"
    source = "single-photon lidar, at most one count a bucket"

    strength: float = strength(0.02, 1.0)
    """Buckets filled by a mean event, as a share of all."""
    daylight: float = drawn(0.0, 0.3)
    """Share of the buckets filled by daylight."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        filled = np.zeros_like(x)
        for photon in range(int(x.max(initial=0))):
            free = rng.random(x.shape) >= self.daylight + filled * self.strength / self.mean
            filled += free & (photon < x)
        return filled


@dataclass(frozen=True)
class OverloadRecovery(Counting, Change):
    """A rare huge pulse drives the amplifier into its rail, and it recovers slowly: the pulses that follow within that
    time are lost.
    """

    name = "dead_time"
    source = "photomultiplier bases overloaded by stopping heavy ions"

    strength: float = strength(0.03, 1.5)
    """Huge pulses in a mean event."""
    recovery: float = drawn(0.3, 1.0)
    """Time to recover, as a share of the event's."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        count = x.astype(int)
        huge = rng.binomial(count, min(1.0, self.strength / self.mean))
        first = rng.beta(1, np.maximum(huge, 1))
        blind = np.where(huge > 0, np.minimum(self.recovery, 1 - first), 0)
        return x - rng.binomial(np.maximum(count - 1, 0), blind)


@dataclass(frozen=True)
class CurrieLimit(Counting, Change):
    """A spectrometer's peak search reports a peak only if it stands out from its continuum. A small peak is reported
    as no counts at all, the more probably the smaller it is.
    """

    name = "threshold_loss"
    source = "Currie's detection limit in gamma spectrometry"

    strength: float = strength(0.01, 0.4)
    """Share of the counts below the limit."""
    softness: float = drawn(0.15, 0.5)
    """Of the limit, in units of the counts' own spread."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = max(self.quantile(self.strength), 0.5 + self.strength)
        found = expit((x - limit) / (self.softness * self.place.std))
        return np.where(rng.random(x.shape) < found, x, 0)


@dataclass(frozen=True)
class WarmDiscriminators(Counting, Change):
    """When the crate is warm the threshold of its discriminators has drifted up. What stays below the raised threshold
    is then read as nothing, while all is well in the cool of the night.
    """

    name = "threshold_loss"
    source = "discriminator thresholds that drift with the crate's temperature"

    strength: float = strength(0.02, 0.8)
    """Share of the events taken while warm."""
    height: float = drawn(0.1, 0.6)
    """Share of the counts that the raised threshold stops."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        warm = rng.random(x.shape) < self.strength
        return np.where(warm & (x < max(self.quantile(self.height), 2)), 0, x)


@dataclass(frozen=True)
class TrackingTimeout(Counting, Selection):
    """The time that a computer needs for an event grows steeply with the hits in it. An event that takes longer than
    its time slot is given up, and never recorded.
    """

    name = "truncation"
    source = "time-outs of track finding in crowded trigger events"

    strength: float = strength(0.01, 0.5)
    """Share of the events that would take too long on a sharp clock."""
    power: float = drawn(8, 40, log=True)
    """With which the time grows."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        slot = max(self.quantile(1 - self.strength), 1)
        return -np.expm1(-((slot / np.maximum(x[:, 0], 0.5)) ** self.power))


@dataclass(frozen=True)
class SpotFinder(Counting, Selection):
    """An X-ray laser takes far more frames than can be stored. Those with fewer spots than the finder asks for are
    thrown away, but for a few that are kept as a check.
    """

    name = "truncation"
    source = "hit finding in serial crystallography"

    strength: float = strength(0.01, 0.6)
    """Share of the frames with too few spots."""
    kept: float = drawn(0.0, 0.3)
    """Share of those that are kept."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return np.where(x[:, 0] < max(self.quantile(self.strength), 1), self.kept, 1)
