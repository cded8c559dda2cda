"""What else befalls a counter of pulses: shutters, flares, buffers, triggers, hum and scalers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import binom

from avobench.challenge.shapes.contract import Change, Replacement, Selection, drawn, strength
from avobench.challenge.shapes.first.counting import arrivals
from avobench.challenge.shapes.first.intervals import RateVariation


@dataclass(frozen=True)
class LeakyShutter(Change):
    """A shutter before the counter is closed during some intervals, which hold a few dark counts or none."""

    name: ClassVar = "zero_inflation"
    source: ClassVar = "dark counts of photon counters; zero-inflated counts with a leak"
    strength: float = strength(0.002, 0.2, "share of the intervals")
    dark: float = drawn(0.05, 0.6, "counts an interval")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        closed = rng.random(x.shape) < self.strength
        return np.where(closed, rng.poisson(self.dark, x.shape), x)


@dataclass(frozen=True)
class Flares(RateVariation):
    """The source is quiet but for flares, few of them great: their height is exponential."""

    name: ClassVar = "overdispersion"
    source: ClassVar = "shot noise of flaring sources in gamma-ray astronomy"
    strength: float = strength(0.03, 0.5, "relative standard deviation")
    share: float = drawn(0.05, 0.3, "of the intervals with a flare")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        # 1 + h E in a share q has mean 1 + h q and variance h^2 (2 q - q^2)
        height = self.strength / (np.sqrt(2 * self.share - self.share**2) - self.strength * self.share)
        flare = (rng.random(n) < self.share) * rng.standard_exponential(n)
        return (1 + height * flare) / (1 + height * self.share)


@dataclass(frozen=True)
class DecayingSource(RateVariation):
    """The source decays while the data are taken."""

    name: ClassVar = "overdispersion"
    source: ClassVar = "radioactive decay over a run that is not short against the half-life"
    strength: float = strength(0.03, 0.5, "relative standard deviation")

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        # over k lifetimes the relative variance is (k / 2) coth(k / 2) - 1
        k = brentq(lambda k: k / 2 / np.tanh(k / 2) - 1 - self.strength**2, 1e-3, 10)
        return k / -np.expm1(-k) * np.exp(-k * rng.random(n))


@dataclass(frozen=True)
class ReadoutBuffer(Change):
    """Pulses wait in a buffer to be digitised, each for a time of its own; what finds the buffer full is lost."""

    name: ClassVar = "dead_time"
    source: ClassVar = "derandomising buffers; Erlang's loss formula (1917)"
    strength: float = strength(0.002, 0.3, "counting intervals, the mean time in the buffer")
    slots: float = drawn(1, 3, "rounded down")
    spread: float = drawn(0.3, 1, "relative standard deviation of the time")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        n = len(x)
        interval, seen, free_at = np.arange(n), np.zeros(n), np.zeros((n, int(self.slots)))
        for arrival in arrivals(x, rng):
            slot = free_at.argmin(axis=1)
            stored = (arrival < 1) & (arrival >= free_at[interval, slot])
            until = arrival + rng.gamma(self.spread**-2, self.strength * self.spread**2, n)
            free_at[interval[stored], slot[stored]] = until[stored]
            seen += stored
        return seen[:, None]


@dataclass(frozen=True)
class PrescaledTrigger(Selection):
    """A trigger that sees a part of the pulses drops a share of the intervals in which it sees too few."""

    name: ClassVar = "threshold_loss"
    source: ClassVar = "multiplicity triggers of partial coverage, with prescaled events below the threshold"
    strength: float = strength(0.03, 0.95, "share lost below the threshold")
    seen: float = drawn(0.5, 0.95, "of the pulses")
    below: float = drawn(0.1, 0.5, "share of the intervals below the threshold")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        threshold = self.seen * np.quantile(self.place.reference[:, self.place.columns], self.below, axis=0)
        return (1 - self.strength * binom.cdf(threshold, x[:, self.place.columns], self.seen)).prod(axis=1)


@dataclass(frozen=True)
class SweptPulser(Replacement):
    """In some intervals it is a test pulser that is counted, whose rate is swept evenly over the range."""

    name: ClassVar = "flat_background"
    source: ClassVar = "pulsers and calibration sweeps left in physics data"
    strength: float = strength(0.005, 0.3, "share of the intervals")
    end: float = drawn(0.8, 1.3, "of the range")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        highest = np.quantile(self.place.reference[:, self.place.columns], 0.999, axis=0)
        return rng.poisson(rng.uniform(0, self.end * highest, (n, len(highest))))


@dataclass(frozen=True)
class Ringing(Change):
    """Pulses ring and are counted twice, in some intervals many of them and in others hardly any."""

    name: ClassVar = "double_counting"
    source: ClassVar = "retriggering of discriminators near their threshold; beta-binomial counts (Skellam 1948)"
    strength: float = strength(0.003, 0.3, "per pulse")
    evenness: float = drawn(1, 10, "a + b of the beta distribution")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        probability = rng.beta(self.evenness * self.strength, self.evenness * (1 - self.strength), x.shape)
        return x + rng.binomial(x.astype(int), probability)


@dataclass(frozen=True)
class MainsHum(Change):
    """The number read out goes up and down with the mains, besides a little Gaussian noise; it is never negative."""

    name: ClassVar = "readout_noise"
    source: ClassVar = "pick-up of a sine at random phase: arcsine-distributed noise"
    stage: ClassVar = 4
    strength: float = strength(0.1, 1.5, "standard deviations")
    hum: float = drawn(0.5, 1, "share of the variance")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        sine = np.sqrt(2) * np.sin(rng.uniform(0, 2 * np.pi, x.shape))
        noise = np.sqrt(self.hum) * sine + np.sqrt(1 - self.hum) * rng.standard_normal(x.shape)
        return np.maximum(np.rint(x + self.strength * self.place.std * noise), 0)


@dataclass(frozen=True)
class PrescaledScaler(Change):
    """Some intervals are read from a scaler that counts one pulse in a few, and what is left over goes to the next."""

    name: ClassVar = "quantisation"
    source: ClassVar = "prescaled scalers"
    stage: ClassVar = 4
    strength: float = strength(0.02, 1, "share of the intervals")
    step: float = drawn(2, 6, "pulses, rounded down")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = int(self.step)
        before = rng.integers(step, size=x.shape)
        return np.where(rng.random(x.shape) < self.strength, (x + before) // step * step, x)


@dataclass(frozen=True)
class PulsedBeam(Change):
    """Pulses of another source are counted as well, but only in those intervals in which a pulsed beam is on."""

    name: ClassVar = "pile_up"
    source: ClassVar = "duty cycle of pulsed accelerators"
    stage: ClassVar = 1
    strength: float = strength(0.005, 0.3, "of the mean count")
    duty: float = drawn(0.6, 0.95, "share of the intervals with beam")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        rate = self.strength / self.duty * self.place.reference[:, self.place.columns].mean(axis=0)
        return x + rng.poisson(rate * (rng.random(x.shape) < self.duty))


@dataclass(frozen=True)
class ChannelsOff(Change):
    """The pulses spread over many channels, each of which is off now and then."""

    name: ClassVar = "inefficiency"
    source: ClassVar = "masked and recovering channels of segmented counters"
    stage: ClassVar = 1
    strength: float = strength(0.005, 0.3)
    channels: float = drawn(20, 100, "rounded down")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        on = rng.binomial(int(self.channels), 1 - self.strength, x.shape) / int(self.channels)
        return rng.binomial(x.astype(int), on)
