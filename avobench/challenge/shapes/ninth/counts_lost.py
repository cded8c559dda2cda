"""Counts: channels that are off, sources that vary, counters that are blind, and events beyond a limit."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from avobench.challenge.shapes.contract import Change, Injection, Selection, Simulate, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class LinkOutage(Counting, Change):
    """The counter's link breaks down for several events in a row. The logger writes zero until it is back."""

    strength: float = strength(0.001, 0.15)
    length: float = drawn(2, 20, "events", log=True)
    """Of an outage, on average."""
    name: ClassVar = "zero_inflation"
    source: ClassVar = "telemetry of remote counting stations"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        cycles = int(2 * len(x) * self.strength / self.length) + 50
        up = rng.exponential(self.length * (1 - self.strength) / self.strength, cycles)
        up[0] *= rng.random() >= self.strength
        down = rng.exponential(self.length, cycles)
        ends = np.cumsum(np.column_stack([up, down]).ravel())
        is_down = np.searchsorted(ends, np.arange(len(x)), side="right") % 2 == 1
        return np.where(is_down[:, None], 0.0, x)


@dataclass(frozen=True)
class StuckShutter(Counting, Change):
    """In some exposures the shutter stays shut. Only the little light that leaks past its blades is counted."""

    strength: float = strength(0.001, 0.15)
    leak: float = drawn(0.002, 0.04, log=True)
    """Share of the light that passes a shut shutter, on average; it differs from time to time."""
    name: ClassVar = "zero_inflation"
    source: ClassVar = "photon-counting cameras with a mechanical shutter"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        shut = rng.random(x.shape) < self.strength
        leaked = rng.binomial(x.astype(int), np.minimum(rng.exponential(self.leak, x.shape), 1))
        return np.where(shut, leaked, x)


class VaryingRate(Counting):
    """A source whose rate is multiplied by a factor of its own in each event."""

    stage = 1
    copies: ClassVar[int]

    @abstractmethod
    def factors(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Of n events, one on average: (n,)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        factors = self.factors(len(theta), rng)[:, None]
        x = simulate(theta, rng)
        total = np.zeros_like(x)
        for k in range(self.copies):
            counts = simulate(theta, rng) if k else x
            total += rng.binomial(counts.astype(int), np.clip(factors - k, 0, 1)).astype(x.dtype)
        return total


@dataclass(frozen=True)
class MainsFlicker(VaryingRate):
    """The lamp flickers with the mains. Each short gate opens at some moment of the period, bright or dim."""

    strength: float = strength(0.03, 1.0)
    """Variance that the flicker adds, in units of that of the counting itself."""
    harmonic: float = drawn(0, 0.5)
    """Height of the second harmonic over that of the first."""
    name: ClassVar = "overdispersion"
    source: ClassVar = "photon counting under lamps fed by the mains"
    copies: ClassVar = 2

    def factors(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.uniform(0, 2 * np.pi, n)
        wave = np.sin(phase) + self.harmonic * np.sin(2 * phase)
        depth = np.sqrt(2 * self.strength / self.mean / (1 + self.harmonic**2))
        return 1 + min(depth, 1 / (1 + self.harmonic)) * wave


@dataclass(frozen=True)
class Scintillation(VaryingRate):
    """Turbulent air focuses and defocuses the light of a star. Its brightness in an exposure is log-normal."""

    strength: float = strength(0.03, 1.0)
    """Variance that the twinkling adds, in units of that of the counting itself."""
    name: ClassVar = "overdispersion"
    source: ClassVar = "fast photometry of stars from the ground"
    copies: ClassVar = 5

    def factors(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        variance = np.log1p(self.strength / self.mean)
        return rng.lognormal(-variance / 2, np.sqrt(variance), n)


@dataclass(frozen=True)
class ExtendingPulse(Counting, Change):
    """A particle that comes during the pulse of the one before is not counted. It makes a pulse all the same."""

    strength: float = strength(0.01, 0.4)
    """Length of a pulse over the mean time between particles."""
    spread: float = drawn(0, 0.8)
    """Half of the range of the pulses' lengths over their mean."""
    name: ClassVar = "dead_time"
    source: ClassVar = "Geiger-Mueller tubes, scintillators with slow pulses"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        arrivals = x[:, 0]
        left, counted = np.ones(len(x)), np.zeros(len(x))
        for k in range(int(arrivals.max(initial=0))):
            after = left * np.exp(-rng.standard_exponential(len(x)) / np.maximum(arrivals - k, 1))
            blind = self.strength / self.mean * (1 + self.spread * rng.uniform(-1, 1, len(x))) if k else 0.0
            counted += (arrivals > k) & (left - after > blind)
            left = after
        return counted[:, None]


@dataclass(frozen=True)
class FrameCoincidence(Counting, Change):
    """The camera is read in short frames. After a first photon the pixel is blind until the next frame."""

    strength: float = strength(0.02, 0.8)
    """Mean number of photons a frame."""
    name: ClassVar = "dead_time"
    source: ClassVar = "photon-counting CCDs, coincidence loss of ultraviolet telescopes"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        frames = max(round(self.mean / self.strength), 2)
        hit = np.zeros_like(x)
        for k in range(int(x.max(initial=0))):
            hit += (x > k) & (rng.random(x.shape) * frames >= hit)
        return hit


@dataclass(frozen=True)
class AvalancheThreshold(Counting, Selection):
    """Electrons are multiplied in avalanches of fluctuating size. An event of too little charge is lost."""

    strength: float = strength(0.003, 0.3)
    polya: float = drawn(1, 5)
    """Inverse relative variance of the size of an avalanche."""
    name: ClassVar = "threshold_loss"
    source: ClassVar = "proportional counters, photomultipliers with a discriminator"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        scale = 1 + 1 / self.polya
        threshold = scale * special.gammaincinv(self.mean / scale, self.strength)  # in mean charges of one avalanche
        return np.where(x[:, 0] > 0, special.gammaincc(self.polya * x[:, 0], self.polya * threshold), 0.0)


@dataclass(frozen=True)
class ReportingMinimum(Counting, Selection):
    """Groups with fewer cases than a minimum need not be reported. A share of the offices leaves them out."""

    strength: float = strength(0.04, 1.0)
    """Share of the offices that leave them out."""
    below: float = drawn(0.05, 0.25)
    """Share of the groups below the minimum, about."""
    name: ClassVar = "threshold_loss"
    source: ClassVar = "surveillance of outbreaks, registers with a reporting minimum"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return 1 - self.strength * (x[:, 0] <= self.quantile(self.below))


@dataclass(frozen=True)
class RaisedLimit(Counting, Selection):
    """The firmware throws away events with more counts than a limit. Later the limit was a higher one."""

    strength: float = strength(0.001, 0.2)
    """Share of the events beyond the lower limit."""
    later: float = drawn(0.1, 0.6)
    """Share of the running time with the higher limit."""
    ratio: float = drawn(0.02, 0.4, log=True)
    """Share of the events beyond the higher limit over that beyond the lower one."""
    name: ClassVar = "truncation"
    source: ClassVar = "readout firmware with a largest event size"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        lower, higher = self.quantile(1 - self.strength), self.quantile(1 - self.strength * self.ratio)
        return np.where(x[:, 0] <= lower, 1.0, self.later * (x[:, 0] <= higher))


@dataclass(frozen=True)
class SharedBuffer(Counting, Selection):
    """An event that overflows its buffer is discarded. Hits of a neighbouring channel take up some of it."""

    strength: float = strength(0.001, 0.2)
    neighbour: float = drawn(0.02, 0.15, log=True)
    """Mean number of the neighbour's hits over that of the channel's own."""
    name: ClassVar = "truncation"
    source: ClassVar = "front-end chips whose channels share a buffer"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        hits = self.neighbour * self.mean
        size = stats.poisson.ppf(1 - self.strength, self.mean + hits)
        return stats.poisson.cdf(size - x[:, 0], hits)


@dataclass(frozen=True)
class ShortRegister(Counting, Change):
    """Some scalers stop at the last value of a short register. They record all higher counts as that value."""

    strength: float = strength(0.001, 0.25)
    """Share of the events beyond the end of the short register."""
    share: float = drawn(0.4, 1)
    name: ClassVar = "censoring"
    source: ClassVar = "scalers that stop at full scale"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        short = rng.random(x.shape) < self.share
        return np.where(short, np.minimum(x, np.floor(self.quantile(1 - self.strength))), x)


@dataclass(frozen=True)
class QuantificationLimit(Counting, Change):
    """The laboratory does not vouch for counts below its limit of quantification. It reports the limit instead."""

    strength: float = strength(0.0005, 0.3)
    name: ClassVar = "censoring"
    source: ClassVar = "colony counts in food and water laboratories"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.maximum(x, np.floor(self.quantile(self.strength)) + 1)


FAMILIES: tuple[type[Injection], ...] = (
    LinkOutage,
    StuckShutter,
    MainsFlicker,
    Scintillation,
    ExtendingPulse,
    FrameCoincidence,
    AvalancheThreshold,
    ReportingMinimum,
    RaisedLimit,
    SharedBuffer,
    ShortRegister,
    QuantificationLimit,
)
