"""Shapes of counts: one number of pulses per event, from the source to what is written down."""

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from shapes.primitives import Library, either, log, run_time

COUNTS = Library("counts")


def thinned(x: NDArray, chance: NDArray | float, rng: np.random.Generator) -> NDArray[np.int64]:
    """How many of the counts remain when each is kept with a probability that broadcasts to them: (n, 1) -> (n, 1)."""
    return rng.binomial(x.astype(np.int64), chance)


def arrivals(x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
    """When the counts of an interval [0, 1] arrive, in order, and times far beyond it after these: (n, 1) -> (n, k)."""
    index = np.arange(int(x.max(initial=0)))
    return np.sort(np.where(index < x, rng.random((len(x), len(index))), 1e3 * (1 + index)), axis=1)


def wandering(n: int, memory: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A stationary standard Gaussian with a memory of that many events: (n, 1)."""
    knots = rng.standard_normal(int(n / memory) + 3)
    before, phase = np.divmod(np.arange(n)[:, None] / memory + rng.random(), 1)
    before, phase = before.astype(int), phase * np.pi / 2
    return np.cos(phase) * knots[before] + np.sin(phase) * knots[before + 1]


# The source varies


@COUNTS.rate("overdispersion", strength=(0.03, 0.5), share=(0.2, 0.7))
def two_intensities(n, at, by, rng):
    """The source switches between two intensities, and an event is taken in either of them."""
    odds = np.sqrt((1 - by.share) / by.share)
    return 1 + by.strength * np.where(rng.random(n) < by.share, odds, -1 / odds)


@COUNTS.rate("overdispersion", strength=(0.03, 0.5), memory=log(1, 200))
def lognormal_rate(n, at, by, rng):
    """The source's intensity is the product of many small disturbances that may last for several events.

    Source: Bulmer, Biometrics 30 (1974) 101.
    """
    width = np.sqrt(np.log1p(by.strength**2))
    return np.exp(width * wandering(n, by.memory, rng) - width**2 / 2)


@COUNTS.rate("overdispersion", strength=(0.03, 0.67), overtone=(0.0, 0.5))
def mains_ripple(n, at, by, rng):
    """The source's intensity follows the sine of the mains and its overtone, and an event has a random phase of it."""
    phase = rng.uniform(0, 2 * np.pi, n)
    wave = np.sin(phase) + by.overtone * np.sin(2 * phase)
    return 1 + by.strength * np.sqrt(2 / (1 + by.overtone**2)) * wave


@COUNTS.rate("overdispersion", strength=(0.1, 1.8))
def decaying_source(n, at, by, rng):
    """The source decays while the events are taken, so that early ones have a higher rate than late ones."""
    return by.strength / -np.expm1(-by.strength) * np.exp(-by.strength * rng.random(n))


@COUNTS.rate("overdispersion", strength=(0.04, 1.75), share=(0.05, 0.5))
def flares(n, at, by, rng):
    """The source is quiet but for flares, few of them great, as their height is exponential."""
    flare = by.strength * rng.standard_exponential(n) * (rng.random(n) < by.share)
    return (1 + flare) / (1 + by.strength * by.share)


@COUNTS.rate("overdispersion", strength=(0.05, 1.0), cover=(0.3, 0.8))
def passing_cirrus(n, at, by, rng):
    """Thin clouds of differing depth dim the star in a part of the exposures."""
    return np.exp(-by.strength * rng.standard_exponential(n) * (rng.random(n) < by.cover))


@COUNTS.rate("overdispersion", strength=(0.015, 1.5))
def molecules_in_focus(n, at, by, rng):
    """The light comes from as many molecules as happen to be in the focus, and each of them gives a few counts."""
    molecules = at.mean / by.strength
    return rng.poisson(molecules, (n, 1)) / molecules


@COUNTS.thin("overdispersion", stage=1, strength=(0.15, 1.0))
def wandering_stream(x, at, by, rng):
    """The cells wander about the axis of a Gaussian laser beam, and those farther out shine less."""
    return np.exp(-by.strength / np.sqrt(2 * at.mean) * rng.standard_normal(x.shape) ** 2)


@COUNTS.spread("overdispersion", strength=(0.08, 0.4), skew=(0.7, 2.5))
def unsteady_parameter(theta, at, by, rng):
    """The parameter differs between events, and is drawn from an interval of which one end is more likely."""
    power, u = by.skew, rng.random((len(theta), 1))
    std = np.sqrt(1 / (2 * power + 1) - 1 / (power + 1) ** 2)
    return theta + by.strength / np.sqrt(at.mean) * (u**power - 1 / (power + 1)) / std


@COUNTS.spread("mixture", strength=(0.003, 0.08), ratio=either(0.5, 1.0))
def second_source(theta, at, by, rng):
    """A share of the events comes from another source of the same kind that has another parameter."""
    other = rng.random((len(theta), 1)) < by.strength / np.sqrt(at.mean)
    return theta + by.ratio * other


# Other events are counted too


@COUNTS.add("pile_up", stage=1, strength=(0.005, 0.3), variation=(0.0, 0.1))
def uneven_pile_up(x, at, by, rng):
    """Pulses of another source are counted as well, at a rate that varies a little between events."""
    return rng.poisson(by.strength * at.mean * (1 + by.variation * rng.uniform(-1, 1, x.shape)))


@COUNTS.add("pile_up", stage=1, strength=(0.005, 0.3), duty=(0.6, 0.95))
def pulsed_beam(x, at, by, rng):
    """Pulses of another source are counted as well, but only in those events in which its pulsed beam is on."""
    return rng.poisson(by.strength / by.duty * at.mean * (rng.random(x.shape) < by.duty))


@COUNTS.add("pile_up", strength=(0.06, 6), each=(0.1, 0.9))
def soft_collisions(x, at, by, rng):
    """Further soft collisions happen in each crossing of the beams, and each of them adds a few counts to the event."""
    return rng.poisson(by.each * at.std * rng.poisson(by.strength, x.shape))


@COUNTS.rate("pile_up", stage=4, strength=(0.03, 1.0), gap=log(0.5, 20))
def slow_tail(n, at, by, rng):
    """The light of the event before has not died out, and the sooner the next one comes the more of it is counted."""
    return 1 + by.strength * np.exp(-by.gap * rng.standard_exponential(n))


@COUNTS.rate("pile_up", stage=4, strength=(0.01, 0.9), fading=(0.1, 1.0))
def close_neighbour(n, at, by, rng):
    """A share of the events follows another one so closely that a random part of its counts falls into the gate."""
    return 1 + (rng.random(n) < by.strength) * rng.random(n) ** by.fading


@COUNTS.rate("pile_up", stage=4, strength=(0.01, 0.5))
def long_gate(n, at, by, rng):
    """Further events begin in a gate that is too long, and their counts up to its end are taken along."""
    further = rng.poisson(by.strength, (n, 1))
    index = np.arange(further.max(initial=0))
    return 1 + np.where(index < further, rng.random((n, len(index))), 0).sum(axis=1)


@COUNTS.rate("pile_up", stage=4, strength=(0.01, 0.6), gate=(0.6, 1.0))
def uneven_bunches(n, at, by, rng):
    """A full bunch of the beam makes several collisions at a time, and most counts of the further ones are added."""
    return 1 + by.gate * np.minimum(rng.geometric(1 / (1 + by.strength), n) - 1, 5)


@COUNTS.rate("pile_up", stage=4, strength=(0.4, 2.2))
def overlapping_windows(n, at, by, rng):
    """The counting window closes late by a time that varies, and takes in counts of the event next to it."""
    longest = np.minimum(by.strength * at.std / at.mean, 1)
    return 1 + longest * rng.random(n)


@COUNTS.rate("double_counting", stage=2, strength=(0.002, 0.3), least=(0.6, 1.0))
def missed_reset(n, at, by, rng):
    """The counter was not reset before a share of the events, which hold another event too, or most of it."""
    return 1 + (rng.random(n) < by.strength) * rng.uniform(by.least, 1, n)


# Events of another origin, and counts of another origin within events


@COUNTS.replace("flat_background", strength=(0.0004, 0.3), reach=(0.85, 2.2), soft=(0.02, 0.2), slope=(-0.3, 0.3))
def stray_intervals(n, at, by, rng):
    """Events of noise have any number of counts, nearly evenly up to an end that is washed out."""
    u = rng.random((n, 1))
    tilted = np.where(rng.random((n, 1)) < abs(by.slope), np.sqrt(u) if by.slope > 0 else 1 - np.sqrt(u), u)
    end = by.reach * np.maximum(at.quantile(0.995), 3) * np.maximum(1 + by.soft * rng.standard_normal((n, 1)), 0.1)
    return np.floor((end + 1) * tilted)


@COUNTS.replace("flat_background", strength=(0.0003, 0.008), start=(0.2, 0.8), reach=(1.5, 3.0))
def cosmic_plateau(n, at, by, rng):
    """Cosmic showers have counts that are spread evenly from well above nothing to far beyond the source's."""
    low, high = np.floor(by.start * at.mean), np.ceil(by.reach * np.maximum(at.quantile(0.995), 3))
    return np.floor(rng.uniform(low, high + 1, (n, 1)))


@COUNTS.replace("flat_background", strength=(0.002, 0.3), edge=(1.4, 5.0), rise=(0.0, 0.8))
def compton_continuum(n, at, by, rng):
    """Some events are gamma rays that scatter once and deposit anything up to the Compton edge, about evenly."""
    u = rng.random((n, 1))
    rising = rng.random((n, 1)) < by.rise / (3 + by.rise)
    return rng.poisson(by.edge * at.mean * np.where(rising, np.cbrt(u), u))


@COUNTS.replace("flat_background", strength=(0.005, 0.2), reach=(1.2, 3.0))
def pulser_sweep(n, at, by, rng):
    """Some events are those of a test pulser whose rate swings like a sine over the whole scale of the counter."""
    highest = by.reach * np.maximum(at.quantile(0.995), 4)
    return rng.poisson(highest * (1 - np.cos(rng.uniform(0, np.pi, (n, 1)))) / 2)


@COUNTS.replace("flat_background", strength=(0.002, 0.2), least=(0.0, 0.2), largest=(3.0, 9.0))
def air_showers(n, at, by, rng):
    """Some events are air showers, of which there are as many in each octave of the number of counts."""
    least, largest = np.maximum(by.least * at.mean, 1), by.largest * at.mean + 1
    return np.floor(least * (largest / least) ** rng.random((n, 1)))


@COUNTS.replace("flat_background", strength=(0.002, 0.15), length=(1.2, 2.5))
def discharge_train(n, at, by, rng):
    """Some events are trains of small discharges, each of which has the same chance to be the last."""
    return rng.geometric(1 / (by.length * at.mean), (n, 1))


@COUNTS.add("flat_background", strength=(0.003, 0.2), size=(0.7, 2.0))
def cosmic_showers(x, at, by, rng):
    """A cosmic particle showers in the shielding during some events, and adds counts with an exponential tail."""
    return (rng.random(x.shape) < by.strength) * rng.geometric(1 / (1 + by.size * at.mean), x.shape)


@COUNTS.add("flat_background", strength=(0.003, 0.15), endpoint=(1.5, 4.0))
def radioactive_glass(x, at, by, rng):
    """A nucleus in the glass of the counter decays during some events, and adds counts of a broad beta spectrum."""
    energy = rng.beta(1.5, 2.5, x.shape)
    return (rng.random(x.shape) < by.strength) * rng.poisson(by.endpoint * at.mean * energy)


@COUNTS.add("flat_background", strength=(0.01, 0.9), lifetimes=(0.5, 3.0))
def cooling_activation(x, at, by, rng):
    """Materials that the beam has made radioactive add counts of their own, fewer as the run goes on."""
    return rng.poisson(by.strength * at.mean * np.exp(-by.lifetimes * rng.random(x.shape)))


# A pulse is counted more than once


@COUNTS.add("double_counting", stage=2, strength=(0.003, 0.5), again=(0.0, 0.7))
def ringing_pulse(x, at, by, rng):
    """A pulse rings or is followed by a false one, which is counted too and may be followed by one more."""
    first = thinned(x, by.strength, rng)
    return first + np.where(first > 0, rng.negative_binomial(np.maximum(first, 1), 1 - by.again), 0)


@COUNTS.add("double_counting", stage=2, strength=(0.01, 0.35))
def light_crosstalk(x, at, by, rng):
    """The avalanche of a count shines into other cells and fires some of them, and these fire others in their turn.

    Source: Vinogradov, Nucl. Instrum. Meth. A 695 (2012) 247.
    """
    fired, last = np.zeros_like(x), x
    while last.any():
        last = rng.poisson(by.strength * last)
        fired += last
    return fired


@COUNTS.add("double_counting", stage=2, strength=(0.008, 0.12), delay=(0.05, 0.8))
def cascading_afterpulses(x, at, by, rng):
    """A pulse releases another one later on, which may do the same, but what comes after the gate is not counted."""
    event, time = np.repeat(np.arange(len(x)), x[:, 0].astype(int)), rng.random(int(x.sum()))
    added = np.zeros(len(x))
    while len(event):
        made = rng.random(len(event)) < by.strength
        event, time = event[made], time[made] + by.delay * rng.standard_exponential(made.sum())
        event, time = event[time < 1], time[time < 1]
        added += np.bincount(event, minlength=len(x))
    return added[:, None]


@COUNTS.add("double_counting", stage=2, strength=(0.003, 0.1), electrons=(1.0, 3.0))
def ion_feedback(x, at, by, rng):
    """A count may set an ion free that knocks several electrons out of the cathode, each of which is counted."""
    return rng.poisson(by.electrons * thinned(x, by.strength, rng))


@COUNTS.branch("double_counting", strength=(0.003, 0.3), evenness=(1, 10))
def uneven_ringing(x, at, by, rng):
    """Pulses ring and are counted twice, in some events many of them and in others hardly any.

    Source: Skellam, J. R. Stat. Soc. B 10 (1948) 257, beta-binomial counts.
    """
    return rng.beta(by.evenness * by.strength, by.evenness * (1 - by.strength), x.shape)


@COUNTS.branch("double_counting", strength=(0.015, 0.25), power=(1, 4))
def creeping_baseline(x, at, by, rng):
    """The baseline creeps towards the threshold, so that late in the run ever more pulses are counted twice."""
    return by.strength * run_time(len(x)) ** by.power


@COUNTS.branch("double_counting", strength=(0.001, 0.7), echo=(0.1, 1.0))
def cable_reflection(x, at, by, rng):
    """A cable is badly terminated in some events, and its echoes make many of their pulses count a second time."""
    return by.echo * (rng.random(x.shape) < by.strength)


@COUNTS.branch("double_counting", strength=(0.01, 0.5), stretch=(0.2, 0.8))
def ring_buffer_reread(x, at, by, rng):
    """In some events a stretch of the ring buffer is read once more, and the pulses in it are counted twice."""
    return by.stretch * rng.uniform(0.5, 1, x.shape) * (rng.random(x.shape) < by.strength)


# Events that read nothing


@COUNTS.flip("zero_inflation", strength=(0.0005, 0.25), partial=(0.0, 0.2))
def trips(x, at, by, rng):
    """The counter is off in some events, and where it goes off or comes back a part of the event is counted."""
    return thinned(x, np.where(rng.random(x.shape) < by.partial, rng.random(x.shape), 0), rng)


@COUNTS.map("zero_inflation", stage=4, strength=(0.001, 0.25), length=log(2, 40), dark=(0.0, 0.1))
def outages(x, at, by, rng):
    """The counter falls out for several events in a row, in which nothing but rare dark pulses is read."""
    length = round(by.length)
    spell = (np.arange(len(x)) + rng.integers(length)) // length
    out = rng.random(spell.max(initial=0) + 1) < by.strength
    return np.where(out[spell][:, None], rng.poisson(by.dark, x.shape), x)


@COUNTS.flip("zero_inflation", strength=(0.002, 0.2), dark=log(0.01, 0.6))
def leaky_shutter(x, at, by, rng):
    """The shutter is closed in some events, which then hold a few dark counts or none."""
    return rng.poisson(by.dark, x.shape)


@COUNTS.flip("zero_inflation", strength=(0.0005, 0.15), caught=log(0.001, 0.08))
def late_gate(x, at, by, rng):
    """In some events the gate opens so late that it catches a tiny part of the pulses, mostly none at all."""
    return thinned(x, np.minimum(by.caught * rng.standard_exponential(x.shape), 1), rng)


@COUNTS.map("zero_inflation", strength=(0.002, 0.2), power=(0.2, 1.0))
def discharges(x, at, by, rng):
    """A busy event is more likely to end in a discharge that erases what was counted."""
    return np.where(rng.random(x.shape) < by.strength * (x / at.mean) ** by.power, 0, x)


@COUNTS.map("zero_inflation", stage=4, strength=(0.0005, 0.7), header=(0.0, 0.9))
def damaged_records(x, at, by, rng):
    """A record that is damaged on its way reads zero, and the more counts it holds the longer it is."""
    length = by.header + (1 - by.header) * x / at.mean
    return np.where(rng.random(x.shape) < np.exp(-by.strength * length), x, 0)


@COUNTS.map("zero_inflation", strength=(0.002, 0.15))
def dropout(x, at, by, rng):
    """The molecules of a gene are not copied in some cells, the more easily the fewer they are, and zero is read."""
    constant = at.mean * by.strength / (1 - by.strength)
    return np.where(rng.random(x.shape) < constant / (constant + x), 0, x)


# Counts that are lost


@COUNTS.thin("inefficiency", stage=1, strength=(0.005, 0.3), variation=(0.0, 0.1))
def uneven_inefficiency(x, at, by, rng):
    """Each pulse is lost with a probability that varies a little between events."""
    return 1 - by.strength * (1 + by.variation * rng.uniform(-1, 1, x.shape))


@COUNTS.thin("inefficiency", stage=1, strength=(0.005, 0.3), channels=(20, 100))
def channels_off(x, at, by, rng):
    """The pulses spread over many channels, each of which is off now and then."""
    return rng.binomial(int(by.channels), 1 - by.strength, x.shape) / int(by.channels)


@COUNTS.thin("inefficiency", strength=(0.01, 0.9))
def ageing(x, at, by, rng):
    """Each pulse is seen with a chance that declines steadily from the start of the run to its end."""
    return 1 - by.strength * rng.random(x.shape)


@COUNTS.map("dead_time", strength=(0.006, 0.8), paralysis=(0.0, 1.0), spread=(0.0, 0.8))
def hybrid_dead_time(x, at, by, rng):
    """After a pulse the counter is blind for a while, and a pulse that it does not see may prolong this.

    Source: Lee and Gardner, Applied Radiation and Isotopes 53 (2000) 731.
    """
    seen, free_at = np.zeros(len(x)), np.zeros(len(x))
    for time in arrivals(x, rng).T:
        counted = (time < 1) & (time >= free_at)
        blinds = counted | ((time < 1) & (rng.random(len(x)) < by.paralysis))
        until = time + by.strength / at.mean * (1 + by.spread * rng.uniform(-1, 1, len(x)))
        free_at = np.where(blinds, np.maximum(free_at, until), free_at)
        seen += counted
    return seen[:, None]


@COUNTS.map("dead_time", strength=(0.005, 1.8), slots=(1, 3), spread=(0.2, 1.0))
def readout_buffer(x, at, by, rng):
    """Each pulse waits for a time of its own in one of few places to be digitised, and is lost if all are taken.

    Source: Erlang's loss formula (1917).
    """
    event, seen, free_at = np.arange(len(x)), np.zeros(len(x)), np.zeros((len(x), int(by.slots)))
    for time in arrivals(x, rng).T:
        slot = free_at.argmin(axis=1)
        stored = (time < 1) & (time >= free_at[event, slot])
        until = time + rng.gamma(by.spread**-2, by.spread**2 * by.strength / at.mean, len(x))
        free_at[event[stored], slot[stored]] = until[stored]
        seen += stored
    return seen[:, None]


@COUNTS.map("dead_time", strength=(0.006, 0.4))
def slow_recovery(x, at, by, rng):
    """After each pulse the counter wakes up gradually, and the sooner the next one comes the likelier it is lost."""
    gaps = np.diff(arrivals(x, rng), axis=1)
    return x - (rng.random(gaps.shape) < np.exp(-gaps * at.mean / by.strength)).sum(axis=1, keepdims=True)


@COUNTS.map("dead_time", strength=(0.008, 1.0), daylight=(0.0, 0.3))
def one_per_bucket(x, at, by, rng):
    """The counter fires once at most in each tick of a clock, and not at all in ticks that daylight has filled."""
    tick = np.floor(arrivals(x, rng) * at.mean / by.strength + rng.random((len(x), 1)))
    return thinned(x - (np.diff(tick, axis=1) == 0).sum(axis=1, keepdims=True), 1 - by.daylight, rng)


@COUNTS.map("dead_time", strength=(0.03, 1.5), recovery=(0.3, 1.0))
def overload_recovery(x, at, by, rng):
    """A rare huge pulse drives the amplifier into its rail, and the pulses until it has recovered are lost."""
    huge = thinned(x, np.minimum(by.strength / at.mean, 1), rng)
    first = rng.beta(1, np.maximum(huge, 1))
    blind = np.where(huge > 0, np.minimum(by.recovery, 1 - first), 0)
    return x - thinned(np.maximum(x - 1, 0), blind, rng)


# Events of few counts that are lost


@COUNTS.keep("threshold_loss", strength=(0.004, 0.6), width=(0.1, 0.8))
def soft_trigger(x, at, by, rng):
    """A trigger compares the noisy sum of an event with a level, and events around it are recorded by chance."""
    return special.ndtr((x + 0.5 - at.quantile(by.strength)) / (by.width * at.std))


@COUNTS.keep("threshold_loss", strength=(0.03, 1.0), seen=(0.4, 0.95), below=log(0.01, 0.5))
def partial_trigger(x, at, by, rng):
    """A trigger that sees a part of the pulses drops a share of the events in which it sees too few."""
    return 1 - by.strength * stats.binom.cdf(by.seen * at.quantile(by.below), x, by.seen)


@COUNTS.keep("threshold_loss", strength=(0.04, 1.0), below=log(0.03, 0.35))
def prescaled_trigger(x, at, by, rng):
    """Of the events with few counts a share is thrown away, and the others are kept as a sample for checks."""
    return 1 - by.strength * (x <= at.quantile(by.below))


@COUNTS.keep("threshold_loss", strength=(0.01, 0.4), spread=(0.1, 0.5))
def most_sensitive_comparator(x, at, by, rng):
    """An event is recorded if it is above the lowest of many comparators' levels, which scatter."""
    above = (x - at.quantile(by.strength)) / (by.spread * np.sqrt(at.mean))
    return -np.expm1(-np.exp(np.minimum(above, 20)))


@COUNTS.keep("threshold_loss", strength=(0.02, 0.6), width=(0.15, 0.6))
def any_pulse_trigger(x, at, by, rng):
    """A share of the triggers waits for a pulse beyond a number and may miss each, so that events with few are lost."""
    more = np.maximum(x - at.quantile(0.02), 0)
    return 1 - by.strength * np.exp(-more / (by.width * np.sqrt(at.mean)))


@COUNTS.keep("threshold_loss", strength=(0.06, 0.9), top=(0.4, 0.8))
def sagging_supply(x, at, by, rng):
    """In brown-outs the threshold climbs in a ramp and falls back, and events that do not reach it are lost."""
    return 1 - by.strength * np.clip(1 - x / np.maximum(at.quantile(by.top), 1), 0, 1)


@COUNTS.keep("threshold_loss", strength=(0.05, 0.9), height=(0.4, 0.8), power=(1.0, 2.5))
def memory_of_the_last(x, at, by, rng):
    """The threshold sits high after an event with many counts, and the next one is lost if it has few."""
    largest_before = at.mean * (x / (by.height * at.mean)) ** (1 / by.power)
    not_larger = np.searchsorted(np.sort(at.reference[:, 0]), largest_before, side="right") / len(at.reference)
    return 1 - by.strength * (1 - not_larger)


@COUNTS.keep("threshold_loss", strength=(0.003, 0.3), polya=(1, 5))
def avalanche_threshold(x, at, by, rng):
    """Electrons are multiplied in avalanches of fluctuating size, and an event of too little charge is lost."""
    scale = 1 + 1 / by.polya
    threshold = scale * special.gammaincinv(at.mean / scale, by.strength)
    return np.where(x > 0, special.gammaincc(by.polya * np.maximum(x, 1), by.polya * threshold), 0)


@COUNTS.map("threshold_loss", strength=(0.005, 0.6), softness=(0.05, 0.5))
def zero_suppression(x, at, by, rng):
    """A count is reported only if it stands out from the noise, and what fails the blurred limit is read as zero."""
    limit = np.maximum(at.quantile(by.strength), 0.5 + by.strength)
    return np.where(rng.random(x.shape) < special.expit((x - limit) / (by.softness * at.std)), x, 0)


@COUNTS.flip("threshold_loss", strength=(0.02, 0.8), height=(0.1, 0.6))
def warm_discriminators(x, at, by, rng):
    """The threshold has drifted up in the events taken while the crate is warm, and small counts are read as zero."""
    return np.where(x < np.maximum(at.quantile(by.height), 2), 0, x)


# Events beyond a limit that are lost


@COUNTS.keep("truncation", strength=(0.0005, 0.3), banks=(1, 4))
def overflow_discarded(x, at, by, rng):
    """An event whose count exceeds what the buffer holds, which differs a little between its banks, is discarded."""
    limits = np.floor(at.quantile(1 - by.strength)) + np.arange(int(by.banks))
    return (x <= limits).mean(axis=1)


@COUNTS.keep("truncation", strength=(0.005, 0.6), spread=(0.05, 1.0))
def shared_buffer(x, at, by, rng):
    """An event that does not fit into the buffer is dropped, and any part of a few places may be taken already."""
    above = x - at.quantile(1 - by.strength)
    return np.clip(1 - above / (by.spread * np.sqrt(at.mean)), 0, 1)


@COUNTS.keep("truncation", strength=(0.001, 0.35), words=log(0.02, 0.25))
def record_length(x, at, by, rng):
    """A record that is longer than the format allows is lost, and it holds a few other words whose number varies."""
    words = by.words * at.mean
    return stats.poisson.cdf(at.quantile(1 - by.strength) + np.rint(words) - x, words)


@COUNTS.keep("truncation", strength=(0.002, 0.3), rest=(0.05, 0.5))
def longest_packet(x, at, by, rng):
    """An event that does not fit into a packet beside other data, whose length is exponential, is not sent."""
    room = np.floor(at.mean - special.ndtri(by.strength) * at.std) + 1 - x
    return -np.expm1(-np.maximum(room, 0) / (by.rest * at.std))


@COUNTS.keep("truncation", strength=(0.01, 0.5), power=log(8, 40))
def tracking_timeout(x, at, by, rng):
    """The time that an event takes to be analysed grows steeply with its counts, and if it is too long it is lost."""
    slot = np.maximum(at.quantile(1 - by.strength), 1)
    return -np.expm1(-((slot / np.maximum(x, 0.5)) ** by.power))


@COUNTS.keep("truncation", strength=(0.002, 0.3), spread=(0.05, 0.35))
def processing_timeout(x, at, by, rng):
    """An event takes a time in proportion to its counts, on a computer that is more or less busy, or is given up."""
    limit = at.mean - special.ndtri(by.strength) * at.std
    return special.ndtr(np.log(limit / np.maximum(x, 1)) / (by.spread * at.std / at.mean))


@COUNTS.keep("truncation", strength=(0.001, 0.2), later=(0.1, 0.6), ratio=log(0.02, 0.4))
def raised_limit(x, at, by, rng):
    """Events with more counts than a limit are thrown away, and the limit is raised during the run."""
    lower, higher = at.quantile(1 - by.strength), at.quantile(1 - by.strength * by.ratio)
    return np.where(x <= lower, 1, by.later * (x <= higher))


@COUNTS.keep("truncation", strength=(0.01, 0.6), kept=(0.0, 0.3))
def spot_finder(x, at, by, rng):
    """Frames with fewer spots than the finder asks for are thrown away, but for a few that are kept as a check."""
    return np.where(x < np.maximum(at.quantile(by.strength), 1), by.kept, 1)


# The ends of the scale


@COUNTS.map("censoring", stage=4, strength=(0.0003, 0.25), late=(0.0, 0.4))
def counter_full(x, at, by, rng):
    """A counter stops at its last value, which is recorded for all larger counts, and some stop one later."""
    return np.minimum(x, np.floor(at.quantile(1 - by.strength)) + (rng.random(x.shape) < by.late))


@COUNTS.map("censoring", stage=4, strength=(0.001, 0.7), share=(0.03, 1.0))
def short_register(x, at, by, rng):
    """A share of the events is recorded by short registers, which stop at their last value."""
    last = np.maximum(np.floor(at.quantile(1 - by.strength)), 1)
    return np.where(rng.random(x.shape) < by.share, np.minimum(x, last), x)


@COUNTS.map("censoring", stage=4, strength=(0.01, 0.5), spread=(0.0, 0.03))
def full_well(x, at, by, rng):
    """A pixel holds so many electrons and no more, and how many differs a little between pixels."""
    well = np.maximum(at.quantile(1 - by.strength), 1) * (1 + by.spread * rng.standard_normal(x.shape))
    return np.minimum(x, np.rint(well))


@COUNTS.map("censoring", stage=4, strength=(0.005, 0.4), spread=(0.05, 0.3))
def scale_ends(x, at, by, rng):
    """Four converters share the load, and each records what is beyond the end of its scale as that end."""
    ends = at.quantile(1 - by.strength) + np.rint(np.arange(4) * by.spread * np.sqrt(at.mean))
    return np.minimum(x, np.maximum(ends, 1)[rng.integers(4, size=x.shape)])


@COUNTS.map("censoring", stage=4, strength=(0.005, 0.4))
def two_halves(x, at, by, rng):
    """Each half of the counter has its own scaler, which stays at its last number, and an event is the sum of both."""
    half = at.mean / 2
    full = np.maximum(np.rint(half - special.ndtri(by.strength) * np.sqrt(half)), 1)
    first = thinned(x, 0.5, rng)
    return np.minimum(first, full) + np.minimum(x - first, full)


@COUNTS.map("censoring", stage=4, strength=(0.003, 0.25), shift=(-0.4, 0.4))
def narrow_window(x, at, by, rng):
    """The range of the digitiser is a window around the usual counts, and what lies outside is read as its end."""
    middle, half = at.mean + by.shift * at.std, -special.ndtri(by.strength) * at.std
    return np.clip(x, np.rint(middle - half), np.rint(middle + half))


@COUNTS.map("censoring", stage=4, strength=(0.0005, 0.3), samples=(0.06, 1.0))
def detection_limit(x, at, by, rng):
    """Laboratories that measure a share of the samples report their limit wherever they have counted less."""
    limit = np.floor(at.quantile(by.strength)) + 1
    return np.where(rng.random(x.shape) < by.samples, np.maximum(x, limit), x)


# The reading is noisy


@COUNTS.blur("readout_noise", stage=4, strength=(0.15, 0.8))
def amplifier_noise(x, at, by, rng):
    """The amplifier adds thermal noise to a signal, and the reading is the whole number next to it."""
    return by.strength * at.std


@COUNTS.blur("readout_noise", stage=4, strength=(0.2, 1.5), switch=(0.2, 0.6), ratio=(3.0, 8.0))
def gain_stages(x, at, by, rng):
    """Large signals are read at low gain, at which the noise of the digitiser weighs much more."""
    return by.strength * at.std * np.where(x > at.quantile(by.switch), 1, 1 / by.ratio)


@COUNTS.map("readout_noise", stage=4, strength=(0.1, 1.5), tail=(0.1, 0.4))
def landau_noise(x, at, by, rng):
    """The number read out is disturbed by noise that has a tail to large values in some events.

    Source: Moyal, Philosophical Magazine 46 (1955) 263.
    """
    tail = (stats.moyal.rvs(size=x.shape, random_state=rng) - stats.moyal.mean()) / stats.moyal.std()
    noise = np.where(rng.random(x.shape) < by.tail, tail, rng.standard_normal(x.shape))
    return x + by.strength * at.std * noise


@COUNTS.map("readout_noise", stage=4, strength=(0.1, 1.5), growth=(0.0, 1.0))
def trembling_needle(x, at, by, rng):
    """A trembling needle is read by eye, mostly close to the count and at times far off, more so at high counts."""
    return x + rng.laplace(0, np.sqrt(0.5), x.shape) * by.strength * at.std * (x / at.mean) ** by.growth


@COUNTS.map("readout_noise", stage=4, strength=(0.03, 1.5), hum=(0.4, 1.0))
def mains_hum(x, at, by, rng):
    """The signal picks up the hum of the mains, which is read at a random phase, besides a weaker thermal noise."""
    sine = np.sqrt(2) * np.sin(rng.uniform(0, 2 * np.pi, x.shape))
    noise = np.sqrt(by.hum) * sine + np.sqrt(1 - by.hum) * rng.standard_normal(x.shape)
    return x + by.strength * at.std * noise


@COUNTS.flip("readout_noise", stage=4, strength=(0.01, 0.3), swing=(0.5, 1.2))
def hum_on_the_line(x, at, by, rng):
    """The hum of the mains rides on the sum of some events, most of which are off by nearly its full swing."""
    return x + (0.4 + by.swing * np.sqrt(2 * at.mean)) * np.sin(rng.uniform(0, 2 * np.pi, x.shape))


@COUNTS.flip("readout_noise", stage=4, strength=(0.005, 0.15), depth=(0.4, 1.2))
def undershoot_noise(x, at, by, rng):
    """Undershoots of earlier pulses pull some readings down by random amounts, and never up."""
    return x - by.depth * np.sqrt(at.mean) * rng.standard_exponential(x.shape)


@COUNTS.map("readout_noise", stage=4, strength=(0.08, 0.45), memory=log(2, 100), jumps=(0.02, 0.2))
def wandering_pedestal(x, at, by, rng):
    """The pedestal wanders up and down with a few jumps, and is added to the count before it is rounded."""
    size = np.where(rng.random(x.shape) < by.jumps, 2.5, 0.8)
    return x + by.strength * np.sqrt(at.mean) * size * wandering(len(x), by.memory, rng)


@COUNTS.flip("readout_noise", stage=4, strength=(0.005, 0.6), step=(0.7, 2.0))
def telegraph_noise(x, at, by, rng):
    """A trap in the transistor fills or empties during some readings, which are one fixed step too high or too low."""
    return x + np.maximum(np.rint(by.step * at.std), 1) * rng.choice([-1, 1], x.shape)


@COUNTS.flip("readout_noise", stage=4, strength=(0.005, 0.4), lowness=(0.7, 2.0))
def single_event_upset(x, at, by, rng):
    """A heavy ion flips one bit of the register, and the reading is too large or too small by a power of two."""
    bits = np.ceil(np.log2(np.maximum(at.quantile(0.995), 2) + 1))
    return x.astype(int) ^ np.left_shift(1, (bits * rng.random(x.shape) ** by.lowness).astype(int))


# The reading is coarse


@COUNTS.flip("quantisation", stage=4, strength=(0.02, 1.0), line=(-1.5, 1.5))
def stuck_bit(x, at, by, rng):
    """A line of the data bus makes bad contact, and its bit reads as not set in some of the readings."""
    weight = 2.0 ** np.maximum(np.rint(np.log2(at.std) + by.line), 0)
    return x - weight * (x // weight % 2)


@COUNTS.flip("quantisation", stage=4, strength=(0.01, 0.9), weight=(0.3, 0.9))
def hanging_bit(x, at, by, rng):
    """One of the low bits of the register hangs at one in some of the readings."""
    weight = 2.0 ** np.floor(np.log2(np.maximum(by.weight * at.std, 1)))
    return x + weight * (1 - x // weight % 2)


@COUNTS.map("quantisation", stage=4, strength=(0.05, 1.0), step=(2, 5))
def coarse_range(x, at, by, rng):
    """Above some count the converter changes to a range with larger steps, and cuts down to them."""
    return np.where(x >= at.quantile(1 - by.strength), x - x % int(by.step), x)


@COUNTS.flip("quantisation", stage=4, strength=(0.002, 0.06), bits=(1, 3))
def floating_point_word(x, at, by, rng):
    """Some counts are sent as short floating-point words, whose steps are the coarser the larger the count is."""
    step = 2 ** np.maximum(np.floor(np.log2(np.maximum(x, 1))) - int(by.bits) + 1, 0)
    return np.where(x > 2, np.rint(x / step) * step, 2 * (x // 2))


@COUNTS.flip("quantisation", stage=4, strength=(0.002, 1.0), ratio=log(2, 10))
def prescaler(x, at, by, rng):
    """Some events are counted behind a prescaler that passes every n-th pulse, and what is left goes to the next."""
    ratio = round(by.ratio)
    return ratio * np.floor((x + rng.integers(ratio, size=x.shape)) / ratio)


@COUNTS.flip("quantisation", stage=4, strength=(0.01, 1.0), step=log(0.25, 2), phase=(0.0, 1.0))
def root_compression(x, at, by, rng):
    """The square root of some counts is sent with few bits and squared on the ground, so that few values arrive."""
    level = np.maximum(np.rint(np.sqrt(x) / by.step - by.phase) + by.phase, 0)
    return (by.step * level) ** 2


@COUNTS.flip("quantisation", stage=4, strength=(0.01, 0.5))
def tally_bundles(x, at, by, rng):
    """The person at the tally sheet bundles strokes by five, and adds up only the full bundles of some events."""
    return np.where(x >= 5, 5 * np.floor(x / 5), x)


@COUNTS.map("quantisation", stage=4, strength=(0.003, 0.1), fives=(0.3, 1.0))
def rounded_by_hand(x, at, by, rng):
    """Counts are read off by eye, and a large one is often written down as the nearest multiple of five, or of two."""
    unit = np.where(rng.random(x.shape) < by.fives, 5, 2)
    chance = by.strength * np.minimum(2 * (x + 1) / (x + 1 + at.mean), 1.5)
    return np.where(rng.random(x.shape) < chance, np.rint(x / unit) * unit, x)


@COUNTS.map("quantisation", stage=4, strength=(0.02, 0.9), fall=(1, 2))
def round_numbers(x, at, by, rng):
    """Counts are written down as a round number that is close, and round numbers are sparser at high counts."""
    unit = np.select([x < 40, x < 200, x < 500], [5, 10, 20], 50)
    near = unit * np.rint(x / unit)
    chance = by.strength * (1 - by.fall * np.abs(x - near) / unit)
    return np.where((near > 0) & (rng.random(x.shape) < chance), near, x)


@COUNTS.map("quantisation", stage=4, strength=(0.02, 0.8))
def round_tallies(x, at, by, rng):
    """People report a multiple of five or ten instead of the count, with a chance to the power of its distance."""
    base = np.where(at.std > 5, 10, 5)
    near = base * np.maximum(np.rint(x / base), 1)
    return np.where((x > 0) & (rng.random(x.shape) < by.strength ** np.abs(x - near)), near, x)


@COUNTS.map("quantisation", stage=4, strength=(0.02, 1.0), marks=(0.7, 1.6))
def dial_marks(x, at, by, rng):
    """Counts are read from a dial by eye, and a needle close to a mark is read as standing on it."""
    step = np.maximum(np.rint(by.marks * at.std), 2)
    mark = step * np.floor(x / step + 0.5)
    drawn_to = by.strength * np.exp(-np.maximum(np.abs(x - mark) - 1, 0) / (step / 4))
    return np.where(rng.random(x.shape) < drawn_to, mark, x)


@COUNTS.map("quantisation", stage=4, strength=(0.008, 0.2), every=(2, 5), phase=(0, 5))
def missing_codes(x, at, by, rng):
    """The converter may skip every k-th code, and records the code below or above in its place."""
    every = int(by.every)
    skipped = (x % every == int(by.phase) % every) & (rng.random(x.shape) < by.strength)
    return np.where(skipped, np.abs(x + rng.choice([-1, 1], x.shape)), x)
