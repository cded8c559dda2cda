"""Effects hidden in counts, one integer an event."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import (
    Change,
    Injection,
    Place,
    Replacement,
    Selection,
    Simulate,
    drawn,
    strength,
)

Counts = NDArray[np.int64]

GENERATIONS = 50
"""Of after-pulses, beyond which none is followed."""


def is_count(place: Place) -> bool:
    """Whether the events are single counts."""
    return np.issubdtype(np.dtype(place.task.dtype), np.integer) and place.task.num_features == 1


def run_time(n: int) -> NDArray[np.float64]:
    """When each of n events was taken, as a share of the run: (n,)."""
    return (np.arange(n) + 0.5) / max(n, 1)


def blocks(n: int, share: float, length: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Which of n events fall in spells of `length` events that make up a share of the run on average: (n,)."""
    length = max(int(length), 1)
    spells = rng.random(n // length + 2) < share
    return spells[(np.arange(n) + rng.integers(0, length)) // length]


def wandering(n: int, memory: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A stationary standard Gaussian that wanders with a memory of that many events: (n,)."""
    knots = rng.standard_normal(int(n / memory) + 3)
    at = np.arange(n) / memory + rng.random()
    low = at.astype(int)
    phase = (at - low) * np.pi / 2
    return np.cos(phase) * knots[low] + np.sin(phase) * knots[low + 1]


def at_rates(simulate: Simulate, theta: NDArray, factor: NDArray, rng: np.random.Generator) -> NDArray:
    """Counts whose rate is the simulator's times a factor (n,) of their own: sums of thinned Poisson counts."""
    copies = max(1, int(np.ceil(factor.max())))
    share = (factor / copies)[:, None]
    return sum(rng.binomial(simulate(theta, rng), share) for _ in range(copies)).astype(np.int64)


def pulses(x: Counts, rng: np.random.Generator) -> tuple[Counts, NDArray[np.float64]]:
    """Of all pulses, event after event and in order of time, the event (m,) and when in its gate [0, 1] (m,)."""
    event = np.repeat(np.arange(len(x)), x)
    time = event + rng.random(len(event))
    time.sort()
    return event, time - event


class Counting(Injection):
    """What all shapes of counts share."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return is_count(place)

    @property
    def rate(self) -> float:
        """Mean count without the effect."""
        return max(float(self.place.reference.mean()), 0.1)

    def quantile(self, q: float) -> float:
        """Of the counts without the effect."""
        return float(np.quantile(self.place.reference, q))


class CountChange(Counting, Change):
    """A change of each count that leaves a count."""

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        """(n,) -> (n,)."""
        raise NotImplementedError

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.maximum(np.rint(self.counts(x[:, 0].astype(np.int64), rng)), 0)[:, None].astype(float)


class RateChange(Counting):
    """A rate that is the simulator's times a factor."""

    stage = 1

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Of each of n events: (n,)."""
        raise NotImplementedError

    @property
    def relative(self) -> float:
        """Standard deviation of the factor that raises the variance of the counts by a share `strength`."""
        return float(np.sqrt(self.strength / self.rate))

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return at_rates(simulate, theta, np.clip(self.factor(len(theta), rng), 0, 8), rng)


class CountSelection(Counting, Selection):
    """A loss of events that depends on their count."""


@dataclass(frozen=True)
class SleepingSpells(CountChange):
    """Now and then the counter falls asleep for a spell of events, in which only rare dark pulses are read."""

    strength: float = strength(0.003, 0.1, "of events, over rate^0.75")
    length: float = drawn(3, 20, "events", log=True)
    dark: float = drawn(0.0, 0.1, "pulses")

    name = "zero_inflation"
    stage = 4
    source = "Lambert, Technometrics 34 (1992) 1; spells as in telegraph noise, Kogan, Electronic Noise (1996)"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        return np.where(
            blocks(len(x), self.strength / self.rate**0.75, self.length, rng), rng.poisson(self.dark, len(x)), x
        )


@dataclass(frozen=True)
class LateGate(CountChange):
    """In a few events the gate opens so late that it catches a tiny part of the pulses, mostly none at all."""

    strength: float = strength(0.001, 0.03, "of events, over rate^0.75")
    caught: float = drawn(0.01, 0.08)

    name = "zero_inflation"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 17"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        part = np.minimum(self.caught * rng.standard_exponential(len(x)), 1)
        return np.where(rng.random(len(x)) < self.strength / self.rate**0.75, rng.binomial(x, part), x)


@dataclass(frozen=True)
class MainsRipple(RateChange):
    """The beam current follows the ripple of its supply, so that the rate swings like a sine about its mean."""

    strength: float = strength(0.008, 0.12)
    cycles: float = drawn(20, 500, "1/run", log=True)
    overtone: float = drawn(0, 0.4)

    name = "overdispersion"
    source = "Cox, J. R. Stat. Soc. B 17 (1955) 129"

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        phase = 2 * np.pi * (self.cycles * run_time(n) + rng.random())
        wave = np.sin(phase) + self.overtone * np.sin(2 * phase)
        return 1 + self.relative * np.sqrt(2 / (1 + self.overtone**2)) * wave


@dataclass(frozen=True)
class FadingSource(RateChange):
    """The source decays while the run lasts: its rate falls from above the mean to below it."""

    strength: float = strength(0.008, 0.15)
    curve: float = drawn(0.5, 3)

    name = "overdispersion"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 3; Cox, J. R. Stat. Soc. B 17 (1955) 129"

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        fall = np.exp(-self.curve * run_time(n))
        return 1 + self.relative * (fall - fall.mean()) / (fall.std() if n > 1 else 1)


@dataclass(frozen=True)
class WanderingLuminosity(RateChange):
    """The logarithm of the rate wanders slowly, as a luminosity that operators trim whenever it strays."""

    strength: float = strength(0.008, 0.15)
    memory: float = drawn(2, 200, "events", log=True)

    name = "overdispersion"
    source = "Cox and Isham, Point Processes (1980), Ch. 3: log-Gaussian rates"

    def factor(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        width = np.sqrt(np.log1p(self.relative**2))
        return np.exp(width * wandering(n, self.memory, rng) - width**2 / 2)


@dataclass(frozen=True)
class RingingPulse(CountChange):
    """A pulse rings: each swing may cross the discriminator again, so that one pulse counts two, three or more."""

    strength: float = strength(0.003, 0.04)
    again: float = drawn(0.2, 0.6)

    name = "double_counting"
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 14"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        rung = rng.binomial(x, self.strength)
        return x + rung + np.where(rung, rng.negative_binomial(np.maximum(rung, 1), 1 - self.again), 0)


@dataclass(frozen=True)
class CreepingBaseline(CountChange):
    """The baseline creeps towards the threshold, so that late in the run ever more pulses count twice."""

    strength: float = strength(0.015, 0.25)
    power: float = drawn(1, 4)

    name = "double_counting"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 17: baseline shift"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        return x + rng.binomial(x, self.strength * run_time(len(x)) ** self.power)


@dataclass(frozen=True)
class ReflectedPulses(CountChange):
    """A badly terminated cable sends pulses back; in events that have it, most of them are counted a second time."""

    strength: float = strength(0.005, 0.2, "of events, over rate")
    echo: float = drawn(0.4, 0.95)

    name = "double_counting"
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 13: reflections"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        return x + rng.binomial(x, np.where(rng.random(len(x)) < self.strength / self.rate, self.echo, 0))


@dataclass(frozen=True)
class PlateauOfNoiseTriggers(Counting, Replacement):
    """Spells of false triggers: their counts are spread evenly over a plateau whose far end is washed out."""

    strength: float = strength(0.0004, 0.012)
    reach: float = drawn(1.2, 2.2)
    soft: float = drawn(0.02, 0.2)

    name = "flat_background"
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 35"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        end = self.reach * max(self.quantile(0.995), 3) * np.maximum(1 + self.soft * rng.standard_normal(n), 0.1)
        return np.floor(rng.random(n) * (end + 1))[:, None]


@dataclass(frozen=True)
class CosmicPlateau(Counting, Replacement):
    """Cosmic showers fire the trigger too; their counts are spread evenly from well above nothing to far beyond."""

    strength: float = strength(0.0003, 0.008)
    start: float = drawn(0.2, 0.8)
    reach: float = drawn(1.5, 3)

    name = "flat_background"
    source = "Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 16"

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        low, high = np.floor(self.start * self.rate), np.ceil(self.reach * max(self.quantile(0.995), 3))
        return np.floor(rng.uniform(low, high + 1, n))[:, None]


@dataclass(frozen=True)
class SlowRecovery(CountChange):
    """After each pulse the discriminator wakes up gradually: the sooner the next one comes, the likelier it is lost."""

    strength: float = strength(0.006, 0.1)

    name = "dead_time"
    source = "Mueller, Nucl. Instrum. Meth. 112 (1973) 47"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        event, time = pulses(x, rng)
        event, gap = event[1:][event[1:] == event[:-1]], np.diff(time)[event[1:] == event[:-1]]
        lost = rng.random(len(gap)) < np.exp(-gap * self.rate / self.strength)
        return x - np.bincount(event[lost], minlength=len(x))


@dataclass(frozen=True)
class ProcessorBusy(CountChange):
    """Each recorded pulse is digitised for a time of its own, long for some, and what comes meanwhile is not seen."""

    strength: float = strength(0.005, 0.12)
    regular: float = drawn(0, 0.7)

    name = "dead_time"
    source = "Feller, On probability problems in the theory of counters, Courant Anniversary Volume (1948)"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        event, time = pulses(x, rng)
        order = np.arange(len(event)) - (np.cumsum(x) - x)[event]
        times = np.full((max(int(x.max(initial=0)), 1), len(x)), np.inf)
        times[order, event] = time
        busy, seen, mean = np.zeros(len(x)), np.zeros(len(x), np.int64), self.strength / self.rate
        for each in times:
            here = np.flatnonzero(np.isfinite(each) & (each >= busy))
            length = mean * (self.regular + (1 - self.regular) * rng.standard_exponential(len(here)))
            busy[here] = each[here] + length
            seen[here] += 1
        return seen


@dataclass(frozen=True)
class ClockedLatch(CountChange):
    """A pulse sets a latch that the next tick of a clock clears; until then the counter sees no further pulse."""

    strength: float = strength(0.008, 0.15)

    name = "dead_time"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 4.VII: pulsed sources"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        event, time = pulses(x, rng)
        tick = np.floor(time * self.rate / self.strength + rng.random(len(x))[event])
        again = (event[1:] == event[:-1]) & (tick[1:] == tick[:-1])
        return x - np.bincount(event[1:][again], minlength=len(x))


@dataclass(frozen=True)
class AnyPulseTrigger(CountSelection):
    """A share of the triggers waits for pulses beyond a number, each of which it may miss: few pulses, few triggers."""

    strength: float = strength(0.02, 0.6)
    width: float = drawn(0.15, 0.6, "sqrt(rate)")

    name = "threshold_loss"
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 35; majority triggers"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        more = np.maximum(x[:, 0] - self.quantile(0.02), 0)
        return 1 - self.strength * np.exp(-more / (self.width * np.sqrt(self.rate)))


@dataclass(frozen=True)
class SaggingSupply(CountSelection):
    """In brown-outs the threshold climbs in a ramp and falls back, and events that do not reach it go unrecorded."""

    strength: float = strength(0.06, 0.9)
    top: float = drawn(0.4, 0.8)

    name = "threshold_loss"
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 17"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return 1 - self.strength * np.clip(1 - x[:, 0] / max(self.quantile(self.top), 1), 0, 1)


@dataclass(frozen=True)
class MemoryOfTheLast(CountSelection):
    """The threshold remembers the event before: after a big one it sits high, and the next is lost if it is small."""

    strength: float = strength(0.05, 0.9)
    height: float = drawn(0.4, 0.8)
    power: float = drawn(1, 2.5)

    name = "threshold_loss"
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 17: undershoot and baseline restoration"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        before = np.sort(self.place.reference[:, 0]).astype(float)
        threshold = self.height * before**self.power * self.rate ** (1 - self.power)
        return 1 - self.strength * (1 - np.searchsorted(np.sort(threshold), x[:, 0], side="right") / len(before))


@dataclass(frozen=True)
class HumOnTheLine(CountChange):
    """Mains hum rides on the sum of some events, which is then rounded: most of these are off by a full swing."""

    strength: float = strength(0.01, 0.3, "of events")
    swing: float = drawn(0.5, 1.2, "sqrt(rate)")

    name = "readout_noise"
    stage = 4
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 13: pick-up"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        hum = (0.4 + self.swing * np.sqrt(2 * self.rate)) * np.sin(2 * np.pi * rng.random(len(x)))
        return np.where(rng.random(len(x)) < self.strength, np.rint(x + hum), x)


@dataclass(frozen=True)
class UndershootNoise(CountChange):
    """Undershoots of earlier pulses pull the pedestal down by random amounts, now and then by much, never up."""

    strength: float = strength(0.005, 0.15, "of events")
    depth: float = drawn(0.4, 1.2, "sqrt(rate)")

    name = "readout_noise"
    stage = 4
    source = "Knoll, Radiation Detection and Measurement, 4th ed. (2010), Ch. 17: pole-zero cancellation"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        pull = rng.standard_exponential(len(x)) * (rng.random(len(x)) < self.strength)
        return np.rint(x - self.depth * np.sqrt(self.rate) * pull)


@dataclass(frozen=True)
class WanderingPedestal(CountChange):
    """The pedestal wanders up and down with flicker and a few jumps, and is added to the sum before it is rounded."""

    strength: float = strength(0.08, 0.45, "sqrt(rate)")
    memory: float = drawn(2, 100, "events", log=True)
    jumps: float = drawn(0.02, 0.2)

    name = "readout_noise"
    stage = 4
    source = "Kogan, Electronic Noise and Fluctuations in Solids (1996); Rossi et al., Pixel Detectors (2006), Ch. 3"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        size = np.where(rng.random(len(x)) < self.jumps, 2.5, 0.8)
        return np.rint(x + self.strength * np.sqrt(self.rate) * size * wandering(len(x), self.memory, rng))


@dataclass(frozen=True)
class FloatingPointWord(CountChange):
    """When the link is busy a count is sent as a short floating-point word: the larger it is, the coarser its step."""

    strength: float = strength(0.002, 0.06)
    bits: float = drawn(1.0, 2.99, "bits")

    name = "quantisation"
    stage = 4
    source = "Widrow and Kollar, Quantization Noise (2008), Ch. 12: floating-point quantization"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        exponent = np.floor(np.log2(np.maximum(x, 1)))
        step = 2 ** np.maximum(exponent - int(self.bits) + 1, 0)
        coarse = np.where(x > 2, np.rint(x / step) * step, 2 * (x // 2))
        return np.where(rng.random(len(x)) < self.strength, coarse, x)


@dataclass(frozen=True)
class MissingCodes(CountChange):
    """The converter skips every k-th code with some probability, and records the code below or above in its place."""

    strength: float = strength(0.008, 0.2)
    every: float = drawn(2, 4.99)
    phase: float = drawn(0, 4.99)

    name = "quantisation"
    stage = 4
    source = "IEEE Std 1241-2010, Analog-to-Digital Converters: missing codes"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        every = int(self.every)
        skipped = (x % every == int(self.phase) % every) & (rng.random(len(x)) < self.strength)
        return np.where(skipped, np.abs(x + rng.choice([-1, 1], len(x))), x)


@dataclass(frozen=True)
class PrescalerTail(CountChange):
    """A prescaler divides the pulses in part of the run: a count is then a multiple of its factor, whole or short."""

    strength: float = strength(0.002, 0.06)
    factor: float = drawn(2, 4.99)
    kept: float = drawn(0, 1)

    name = "quantisation"
    stage = 4
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 14: scalers"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        factor, begin = int(self.factor), self.kept * (1 - self.strength)
        time = run_time(len(x))
        divided = factor * ((x + rng.integers(0, factor, len(x))) // factor)
        return np.where((time >= begin) & (time < begin + self.strength), divided, x)


@dataclass(frozen=True)
class CascadingAfterPulses(CountChange):
    """Ions of a pulse release another one later on, which may do the same; what comes after the gate is not counted."""

    strength: float = strength(0.008, 0.12)
    delay: float = drawn(0.05, 0.8, "gates")

    name = "after_pulses"
    source = "Hamamatsu, Photomultiplier Tubes: Basics and Applications, 4th ed. (2017), Ch. 4.3.8"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        event, time = np.repeat(np.arange(len(x)), x), rng.random(int(x.sum()))
        total = x.copy()
        for _ in range(GENERATIONS):
            made = rng.random(len(event)) < self.strength
            event, time = event[made], time[made] + self.delay * rng.standard_exponential(int(made.sum()))
            event, time = event[time < 1], time[time < 1]
            if not len(event):
                break
            total += np.bincount(event, minlength=len(x))
        return total


@dataclass(frozen=True)
class OverflowDiscarded(CountSelection):
    """Events whose count exceeds what the buffer holds, which differs a little between its banks, are discarded."""

    strength: float = strength(0.0005, 0.03)
    banks: float = drawn(1, 3.99)

    name = "truncation"
    source = "Hald, Biometrika 36 (1949) 119, truncated distributions"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        limit = np.floor(self.quantile(1 - self.strength))
        over = x[:, 0][:, None] > limit + np.arange(int(self.banks))
        return 1 - over.mean(axis=1)


@dataclass(frozen=True)
class CounterFull(CountChange):
    """A counter stops at its last value, so that larger counts are recorded there; some channels stop a bit later."""

    strength: float = strength(0.0003, 0.02)
    late: float = drawn(0, 0.4)

    name = "censoring"
    stage = 4
    source = "Tobin, Econometrica 26 (1958) 24"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        limit = np.floor(self.quantile(1 - self.strength)) + (rng.random(len(x)) < self.late)
        return np.minimum(x, limit)


@dataclass(frozen=True)
class RoundedByHand(CountChange):
    """Counts are read off by eye: a large one is often written down as the nearest multiple of five, or of two."""

    strength: float = strength(0.003, 0.1)
    fives: float = drawn(0.3, 1)

    name = "heaping"
    stage = 4
    source = "Heitjan and Rubin, Ann. Stat. 19 (1991) 2244"

    def counts(self, x: Counts, rng: np.random.Generator) -> NDArray:
        unit = np.where(rng.random(len(x)) < self.fives, 5, 2)
        chance = self.strength * np.minimum(2 * (x + 1) / (x + 1 + self.rate), 1.5)
        return np.where(rng.random(len(x)) < chance, np.rint(x / unit) * unit, x)


@dataclass(frozen=True)
class SecondSource(Counting):
    """A share of the events comes from another source of the same kind, whose rate is a multiple of the first."""

    strength: float = strength(0.003, 0.08, "of events, over sqrt(rate)")
    ratio: float = drawn(0.5, 1.0, sign=True)

    name = "mixture"
    stage = 1
    source = "McLachlan and Peel, Finite Mixture Models (2000)"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        other = rng.random(len(theta)) < self.strength / np.sqrt(self.rate)
        moved = theta + np.where(other, self.ratio, 0)[:, None]
        return simulate(np.clip(moved, self.place.task.support.low, self.place.task.support.high), rng)


@dataclass(frozen=True)
class UnsteadyParameter(Counting):
    """The parameter differs between events: it is drawn evenly from an interval, skewed towards one end of it."""

    strength: float = strength(0.08, 0.4, "1/sqrt(rate)")
    skew: float = drawn(0.7, 2.5)

    name = "spread"
    stage = 1
    source = "Cox, J. R. Stat. Soc. B 17 (1955) 129; Cowan, Statistical Data Analysis (1998)"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        a = self.skew
        place = rng.random(len(theta)) ** a
        spread = np.sqrt(1 / (2 * a + 1) - 1 / (a + 1) ** 2)
        moved = theta + (self.strength / np.sqrt(self.rate) * (place - 1 / (a + 1)) / spread)[:, None]
        return simulate(np.clip(moved, self.place.task.support.low, self.place.task.support.high), rng)


FAMILIES = (
    SleepingSpells,
    LateGate,
    MainsRipple,
    FadingSource,
    WanderingLuminosity,
    RingingPulse,
    CreepingBaseline,
    ReflectedPulses,
    PlateauOfNoiseTriggers,
    CosmicPlateau,
    SlowRecovery,
    ProcessorBusy,
    ClockedLatch,
    AnyPulseTrigger,
    SaggingSupply,
    MemoryOfTheLast,
    HumOnTheLine,
    UndershootNoise,
    WanderingPedestal,
    FloatingPointWord,
    MissingCodes,
    PrescalerTail,
)
NEW_FAMILIES = (
    CascadingAfterPulses,
    OverflowDiscarded,
    CounterFull,
    RoundedByHand,
    SecondSource,
    UnsteadyParameter,
)
