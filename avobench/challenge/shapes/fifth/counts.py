"""Shapes for one count an event."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import Change, Injection, Place, Selection, Simulate, drawn, strength

FLOOR = 0.02
"""The share that a selection keeps at least, as events of a minimum-bias trigger."""


def typical(place: Place) -> float:
    """The mean count, but at least 1."""
    return max(float(place.reference.mean()), 1.0)


class OfCounts:
    """What needs a single whole number an event."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        x = place.reference
        return place.task.num_features == 1 and bool((x >= 0).all() and (x == np.rint(x)).all())


class Varying(OfCounts, Injection):
    """Counts whose rate is multiplied by a factor in [0, 2], with a mean of one, that differs between events."""

    name = "overdispersion"
    stage = 1

    @abstractmethod
    def factor(self, moment: NDArray[np.float64]) -> NDArray[np.float64]:
        """At a moment of the run, from 0 at its start to 1 at its end."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x, more = simulate(theta, rng), simulate(theta, rng)
        factor = self.factor(rng.random(x.shape))
        return rng.binomial(x, np.minimum(factor, 1)) + rng.binomial(more, np.clip(factor - 1, 0, 1))


@dataclass(frozen=True)
class SpillRipple(Varying):
    """The magnets' supply ripples with the mains, and the extracted beam with it."""

    strength: float = strength(0.04, 0.95, "of the rate")
    source = "Ripple of the extraction from a synchrotron"

    def factor(self, moment: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 + self.strength * np.sin(2 * np.pi * moment)


@dataclass(frozen=True)
class FillDecay(Varying):
    """The beams burn off during a fill, so that early events have a higher rate than late ones."""

    strength: float = strength(0.1, 1.5, "lifetimes")
    source = "Exponential decay of the luminosity between two injections"

    def factor(self, moment: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.strength * np.exp(-self.strength * moment) / -np.expm1(-self.strength)


@dataclass(frozen=True)
class ParalysedCounter(OfCounts, Change):
    """Pulses arrive at random within the window. One that follows its predecessor too closely is not counted, but
    keeps the counter busy all the same."""

    strength: float = strength(0.01, 0.8, "windows over the mean count")
    name, source = "dead_time", "Pulses of finite length above a discriminator, counted at their leading edges"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        window = np.repeat(np.arange(len(x)), x[:, 0].astype(int))
        time = np.sort(window + rng.random(len(window)))
        first = np.diff(window, prepend=-1) > 0
        seen = first | (np.diff(time, prepend=-1) > self.strength / typical(self.place))
        return np.bincount(window[seen], minlength=len(x))[:, None].astype(float)


@dataclass(frozen=True)
class OldScalers(OfCounts, Change):
    """A share of the windows is read by old scalers, which stop at their last number."""

    strength: float = strength(0.03, 1, "of the windows")
    stop: float = drawn(-0.5, 1, "standard deviations above the mean")
    name, stage, source = "censoring", 4, "Registers of few bits without an overflow flag"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        last = max(1, np.rint(self.place.reference.mean() + self.stop * self.place.std[0]))
        return np.where(rng.random(x.shape) < self.strength, np.minimum(x, last), x)


@dataclass(frozen=True)
class AfterPulseChain(OfCounts, Change):
    """Each pulse frees an ion or a trapped carrier with some chance, whose own pulse may do so again."""

    strength: float = strength(0.005, 0.4, "after-pulses a pulse")
    name, source = "double_counting", "After-pulses of photomultipliers and of avalanche diodes"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x + np.where(x > 0, rng.negative_binomial(np.maximum(x, 1), 1 - self.strength), 0)


@dataclass(frozen=True)
class CableEcho(OfCounts, Change):
    """Some of the cables are badly terminated: the echo of a large pulse crosses the threshold a second time."""

    strength: float = strength(0.015, 0.95, "of the pulses")
    cables: float = drawn(0.25, 0.7, "of the windows")
    name, source = "double_counting", "Reflection at an unmatched impedance"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bad = rng.random(x.shape) < self.cables
        return x + bad * rng.binomial(x.astype(int), self.strength)


@dataclass(frozen=True)
class CoolingActivation(OfCounts, Change):
    """Materials that the beam has made radioactive add counts of their own, fewer as the run goes on."""

    strength: float = strength(0.01, 0.9, "mean counts")
    lifetimes: float = drawn(0.5, 3, "of the activity in the run")
    name, stage, source = "flat_background", 4, "Activation of the detector's surroundings"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        activity = self.strength * typical(self.place) * np.exp(-self.lifetimes * rng.random(x.shape))
        return x + rng.poisson(activity)


@dataclass(frozen=True)
class LateNeighbour(OfCounts, Injection):
    """A second event of the same kind follows so soon that its first pulses still fall into the gate."""

    strength: float = strength(0.01, 0.9, "of the gates")
    name, stage, source = "pile_up", 4, "A gate longer than the distance of two bunches"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        overlap = np.where(rng.random(x.shape) < self.strength, rng.random(x.shape), 0)
        return x + rng.binomial(simulate(theta, rng), overlap)


@dataclass(frozen=True)
class DialMarks(OfCounts, Change):
    """Counts are read from a dial by eye, and a needle close to a mark is read as standing on it."""

    strength: float = strength(0.02, 1, "of the readings next to a mark")
    marks: float = drawn(0.7, 1.6, "standard deviations")
    name, stage, source = "quantisation", 4, "Digit preference of human readers"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = max(2, np.rint(self.marks * self.place.std[0]))
        mark = step * np.floor(x / step + 1 / 2)
        drawn_to = self.strength * np.exp(-np.maximum(np.abs(x - mark) - 1, 0) / (step / 4))
        return np.where(rng.random(x.shape) < drawn_to, mark, x)


@dataclass(frozen=True)
class MainsHum(OfCounts, Change):
    """The charge is digitised on top of the hum of the mains, at any phase, with a dithered last bit."""

    strength: float = strength(0.04, 1.5, "standard deviations")
    name, stage, source = "readout_noise", 4, "Pick-up in the baseline of a charge integrator"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hum = self.strength * self.place.std[0] * np.cos(rng.uniform(0, np.pi, x.shape))
        return np.maximum(np.floor(x + hum + rng.random(x.shape)), 0)


@dataclass(frozen=True)
class ZeroSuppression(OfCounts, Change):
    """Only sums above a threshold are written out. The noise blurs it, and what fails it is read as zero."""

    strength: float = strength(0.005, 0.6, "of the events")
    blur: float = drawn(0.1, 0.5, "counts")
    name, source = "threshold_loss", "Suppression of empty channels in the front end"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        threshold = np.quantile(self.place.reference, self.strength)
        return np.where(rng.random(x.shape) < expit((x - threshold) / self.blur), x, 0)


@dataclass(frozen=True)
class FullBuffer(OfCounts, Selection):
    """An event that does not fit into the buffer is dropped. The last one may have left a few places occupied."""

    strength: float = strength(0.01, 0.6, "of the events")
    leftover: float = drawn(0, 0.4, "standard deviations")
    name, source = "truncation", "Buffers of fixed length in the data acquisition"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        room = np.quantile(self.place.reference, 1 - self.strength)
        return np.clip(1 - (x[:, 0] - room) / (1 + self.leftover * self.place.std[0]), FLOOR, 1)


@dataclass(frozen=True)
class OvercurrentTrip(OfCounts, Change):
    """A busy event draws much current. If the high voltage trips, the whole event is read as empty."""

    strength: float = strength(0.01, 0.7, "trips an event of mean count")
    name, source = "zero_inflation", "Over-current protection of the high-voltage supply"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x * (rng.random(x.shape) < np.exp(-self.strength * x / typical(self.place)))


@dataclass(frozen=True)
class Ageing(OfCounts, Change):
    """Each pulse is seen with a chance that declines steadily from the run's start to its end."""

    strength: float = strength(0.01, 0.9, "of the pulses, lost at the end")
    name, source = "inefficiency", "Loss of gain with the charge collected"

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.binomial(x.astype(int), 1 - self.strength * rng.random(x.shape)).astype(float)


FAMILIES = (
    SpillRipple,
    FillDecay,
    ParalysedCounter,
    OldScalers,
    AfterPulseChain,
    CableEcho,
    CoolingActivation,
    LateNeighbour,
    DialMarks,
    MainsHum,
    ZeroSuppression,
    FullBuffer,
    OvercurrentTrip,
    Ageing,
)
