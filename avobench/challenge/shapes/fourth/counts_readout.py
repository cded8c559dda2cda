"""Counts: what happens when they are read, written down and selected."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Selection, drawn, strength
from avobench.challenge.shapes.fourth.scales import count_above, dithered, mean_count, root


@dataclass(frozen=True)
class LateGate(Change):
    """In some events the gate opens only when the pulses are over, and the counter reads zero."""

    name = "zero_inflation"
    source = "trigger jitter at gated counters"
    stage = 4

    strength: float = strength(0.0005, 0.1, "of events")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, 0, x)


@dataclass(frozen=True)
class BlankedRecords(Change):
    """A record that is damaged on its way is blanked and reads zero; a record with more counts is longer and somewhat
    more often damaged."""

    name = "zero_inflation"
    source = "bit errors on telemetry links with checksums"
    stage = 4

    strength: float = strength(0.0005, 0.1, "of typical records")
    header: float = drawn(0.5, 0.9, "of a typical record that is there in every one")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        length = self.header + (1 - self.header) * x / mean_count(self.place)
        return np.where(rng.random(x.shape) < -np.expm1(-self.strength * length), 0, x)


@dataclass(frozen=True)
class SplitLight(Selection):
    """Each count has a chance to be seen by the trigger too, and an event is read if the trigger has seen enough;
    events with few counts often fail it and are lost."""

    name = "threshold_loss"
    source = "beam splitters before trigger photomultipliers"

    strength: float = strength(0.01, 0.4, "of events below the level")
    seen: float = drawn(0.4, 0.9, "of the counts by the trigger")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        level = max(1, round(self.seen * count_above(self.place, 1 - self.strength)))
        numbers, where = np.unique(x[:, self.place.columns[0]].astype(int), return_inverse=True)
        log_factorial = np.r_[0.0, np.cumsum(np.log(np.arange(1, max(numbers[-1], level) + 1)))]
        n, k = numbers[:, None], np.arange(level)
        share = log_factorial[n] - log_factorial[k] - log_factorial[np.maximum(n - k, 0)]
        share = share + k * np.log(self.seen) + np.maximum(n - k, 0) * np.log1p(-self.seen)
        passed = 1 - np.where(k <= n, np.exp(share), 0).sum(axis=1)
        return np.clip(passed, 0, 1)[where]


@dataclass(frozen=True)
class MostSensitiveComparator(Selection):
    """An event is read if it is above the lowest of many comparators' levels, which scatter; events with few counts are
    below all of them."""

    name = "threshold_loss"
    source = "spread of discriminator levels, extreme-value statistics"

    strength: float = strength(0.01, 0.4, "of events below the level")
    spread: float = drawn(0.1, 0.5, "of the Poisson fluctuation")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        above = x[:, self.place.columns[0]] - count_above(self.place, 1 - self.strength)
        return -np.expm1(-np.exp(np.minimum(above / (self.spread * root(self.place)), 20.0)))


@dataclass(frozen=True)
class MainsHum(Change):
    """The mains hum into the analogue sum before it is digitised, and every event is read at another phase of the
    hum."""

    name = "readout_noise"
    source = "ground loops, 50 Hz pick-up"
    stage = 4

    strength: float = strength(0.25, 1.8, "amplitude over the Poisson fluctuation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hum = np.sin(2 * np.pi * rng.random(x.shape))
        return dithered(x + self.strength * root(self.place) * hum, rng)


@dataclass(frozen=True)
class TelegraphNoise(Change):
    """A single trap in the first transistor fills or empties between the two samples of some readings, which come out
    one fixed step too high or too low."""

    name = "readout_noise"
    source = "random telegraph signals in CMOS sensors with double sampling"
    stage = 4

    strength: float = strength(0.01, 0.5, "of readings with a step")
    step: float = drawn(0.8, 2.0, "of the Poisson fluctuation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        jumps = rng.choice([-1, 1], x.shape) * (rng.random(x.shape) < self.strength)
        return np.maximum(x + np.ceil(self.step * root(self.place)) * jumps, 0)


@dataclass(frozen=True)
class WeakBit(Change):
    """One line of the data bus makes bad contact, and its bit reads as not set in a share of the readings in which it
    should be set."""

    name = "quantisation"
    source = "stuck bits on parallel buses"
    stage = 4

    strength: float = strength(0.02, 1.0, "of readings")
    line: float = drawn(-0.5, 1.5, "octaves from the Poisson fluctuation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        weight = 2 ** max(1, round(np.log2(root(self.place)) + self.line))
        is_set = (x.astype(int) & weight) > 0
        return x - weight * (is_set & (rng.random(x.shape) < self.strength))


@dataclass(frozen=True)
class RootCompression(Change):
    """To save telemetry the square root of the count is sent in few steps and squared again on the ground, so that only
    some counts can come out."""

    name = "quantisation"
    source = "square-root compression on spacecraft"
    stage = 4

    strength: float = strength(0.1, 1.5, "step over the Poisson fluctuation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = (self.strength + 1 / root(self.place)) / 2
        return np.rint((step * np.rint(np.sqrt(x) / step)) ** 2)


@dataclass(frozen=True)
class TallyBundles(Change):
    """The person at the tally sheet bundles strokes by five and, for some events, adds up the full bundles only."""

    name = "heaping"
    source = "tally sheets of visual scintillation counting"
    stage = 4

    strength: float = strength(0.01, 0.5, "of events")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        careless = (x >= 5) & (rng.random(x.shape) < self.strength)
        return np.where(careless, 5 * np.floor(x / 5), x)


@dataclass(frozen=True)
class RoundDial(Change):
    """Whoever reads the dial likes to write down a marked number if the pointer is close to it, and the marks are
    farther apart where the dial is more crowded."""

    name = "heaping"
    source = "digit preference of observers"
    stage = 4

    strength: float = strength(0.03, 0.9, "of readings at a mark")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        marks = np.select([x < 40, x < 200, x < 500], [5, 10, 20], 50)
        nearest = marks * np.rint(x / marks)
        close = 1 - np.abs(x - nearest) / marks
        return np.where((nearest > 0) & (rng.random(x.shape) < self.strength * close), nearest, x)


@dataclass(frozen=True)
class SharedBuffer(Selection):
    """An event that does not fit into the buffer is dropped, and how much of the buffer is free differs a little from
    event to event."""

    name = "truncation"
    source = "front-end buffers of fixed depth"

    strength: float = strength(0.005, 0.35, "of events above the limit")
    spread: float = drawn(0.05, 0.5, "of the Poisson fluctuation")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        above = x[:, self.place.columns[0]] - count_above(self.place, self.strength)
        return np.clip(1 - above / (self.spread * root(self.place)), 0, 1)


@dataclass(frozen=True)
class RecordLength(Selection):
    """An event whose record is longer than the format allows is not written; the record holds its counts and a few
    words of housekeeping, whose number varies."""

    name = "truncation"
    source = "fixed maximum record length on tape"

    strength: float = strength(0.005, 0.35, "of events above the limit")
    words: float = drawn(0.1, 1.5, "of housekeeping")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        room = count_above(self.place, self.strength) + round(self.words) - x[:, self.place.columns[0]].astype(int)
        k = np.arange(16)
        share = np.exp(-self.words) * np.cumprod(np.r_[1.0, self.words / k[1:]])
        return np.where(room < 0, 0.0, np.cumsum(share)[np.clip(room, 0, 15)])


@dataclass(frozen=True)
class ScaleEnds(Change):
    """The readings come from four converters that share the load, and each records what is beyond the end of its scale
    as that end; the ends differ slightly."""

    name = "censoring"
    source = "interleaved converters"
    stage = 4

    strength: float = strength(0.005, 0.4, "of events beyond the first end")
    spread: float = drawn(0.05, 0.3, "of the Poisson fluctuation, from one end to the next")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        ends = count_above(self.place, self.strength) + np.rint(np.arange(4) * self.spread * root(self.place))
        return np.minimum(x, np.maximum(ends, 1)[rng.integers(4, size=x.shape)])


@dataclass(frozen=True)
class TwoHalves(Change):
    """Each half of the counter has its own scaler, which stays at its last number when it is full; an event is the sum
    of both."""

    name = "censoring"
    source = "scalers with overflow stop"
    stage = 4

    strength: float = strength(0.005, 0.4, "of halves that are full")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        half = mean_count(self.place) / 2
        full = max(1, round(half + NormalDist().inv_cdf(1 - self.strength) * np.sqrt(half)))
        first = rng.binomial(x.astype(int), 0.5)
        return np.minimum(first, full) + np.minimum(x - first, full)


FAMILIES = (
    LateGate,
    BlankedRecords,
    SplitLight,
    MostSensitiveComparator,
    MainsHum,
    TelegraphNoise,
    WeakBit,
    RootCompression,
    TallyBundles,
    RoundDial,
    SharedBuffer,
    RecordLength,
    ScaleEnds,
    TwoHalves,
)
