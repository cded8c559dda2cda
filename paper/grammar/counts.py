"""The primitives for counts, each with the regions that families of the catalogue claim."""

import numpy as np

from avobench.effects.counts.exposure import exposed
from avobench.effects.counts.pulses import counted
from paper.grammar.functions import GRID
from paper.grammar.sentences import (
    ANYHOW,
    OUTSIDE,
    Grammar,
    Rule,
    Words,
    average,
    best,
    between,
    chosen,
    mix,
    noise,
    nothing,
    one_of,
    regions,
    rounded,
    transposed,
    vary,
)

COUNTS = Grammar()

# Single counts are lost, or cause others.


def of_many(words: Words) -> str | None:
    """A loss of single counts that is largest for high ones, as by a dead time."""
    return "dead_time" if words.f.values[-1] > words.f.values[0] else None


OF_MANY = Rule(("dead_time",), of_many)


@COUNTS.change(
    nothing("inefficiency") | regions(OF_MANY, "value", "linear", "monotone") | regions(OUTSIDE, "value", "local"),
    (0.05, 0.95),
)
def thinned(at, y, u, words, rng):
    """Each count is lost with a chance."""
    return rng.binomial(y.astype(int), 1 - words.strength * words.f(u))


@COUNTS.change(nothing("dead_time"), (0.02, 1.5))
def blinded(at, y, u, words, rng):
    """After each count the counter is blind for a time, which may scatter and may be prolonged by what it misses."""
    tau = (
        words.strength
        / max(at.values.mean(), 1)
        * rng.gamma(1 / (0.01 + words.r[0] ** 3), 0.01 + words.r[0] ** 3, len(y))
    )
    return counted(y.astype(int), tau, np.full(len(y), one_of(words.r[1], (0.0, 1.0, words.r[2]))), rng)


@COUNTS.change(
    nothing("double_counting") | {("value", "monotone"): "double_counting", ("time", "monotone"): "double_counting"},
    (0.02, 0.7),
)
def branched(at, y, u, words, rng):
    """A count causes others: one at most, a Poisson number, or a chain."""
    chance, n = words.strength * words.f(u), y.astype(int)
    more = one_of(
        words.r[0],
        (
            lambda: rng.binomial(n, chance),
            lambda: rng.poisson(n * chance),
            lambda: np.where(n > 0, rng.negative_binomial(np.maximum(n, 1), 1 - 0.9 * chance), 0),
        ),
    )
    return y + more()


# The exposure is another one, or events are merged.


@COUNTS.event(
    nothing("overdispersion") | regions("overdispersion", "time", "monotone", "smooth", "stepped", "periodic"),
    (0.05, 0.7),
)
def exposed_unequally(simulate, theta, places, words, rng):
    """The rate differs from event to event, at random or with the time, and has a mean of one."""
    n = len(theta)
    if words.f.kind == "constant":
        law = one_of(
            words.r[0],
            (
                lambda: rng.gamma(words.strength**-2, words.strength**2, n),
                lambda: np.exp(words.strength * rng.standard_normal(n) - words.strength**2 / 2),
                lambda: 1 + words.strength * noise(n, words.r[1], rng),
            ),
        )
        rate = law()
    else:
        swing = words.f(np.linspace(0, 1, n)) - words.f.values.mean()
        rate = 1 + words.strength * swing / words.f.values.std()
    return exposed(simulate, theta, np.maximum(rate, 0.25), rng)


@COUNTS.event(nothing("pile_up"), (0.03, 1.5))
def piled(simulate, theta, places, words, rng):
    """A part of other events is counted too: of one now and then, or of several."""
    n, most = len(theta), 0.2 + 0.8 * words.r[1]
    if words.r[0] < 0.5:
        overlap = (rng.random(n) < min(words.strength, 1)) * rng.beta(1, between(words.r[2], 0.5, 2), n) * most
    else:
        overlap = rng.poisson(words.strength, n) * most
    return exposed(simulate, theta, 1 + overlap, rng)


@COUNTS.event(nothing("double_counting"), (0.02, 1.0))
def merged(simulate, theta, places, words, rng):
    """A share of the events is read twice, or two are taken for one."""
    x = simulate(theta, rng)
    twice = rng.random((len(x), 1)) < words.strength
    return x + twice * (simulate(theta, rng) if words.r[0] < 0.7 else x)


# Events are lost, or read nothing.


@COUNTS.change(nothing("zero_inflation") | {("value", "monotone"): "zero_inflation"}, (0.02, 0.9))
def emptied(at, y, u, words, rng):
    """A share of the events reads nothing, or next to nothing."""
    left = rng.binomial(y.astype(int), 0.3 * words.r[0] ** 3) if words.r[1] < 0.4 else 0
    return np.where(chosen(u, words, rng), left, y)


def at_an_end(words: Words) -> str | None:
    """Events of few counts are lost, or those of many: by where the loss is half of the largest."""
    f = words.f
    few = f.values[0] > f.values[-1]
    if f.turns or (f.half < 0.5) != few:
        return None
    return "threshold_loss" if few else "truncation"


def of_few(words: Words) -> str | None:
    """Events of few counts alone."""
    return "threshold_loss" if at_an_end(words) == "threshold_loss" else None


def inside(words: Words) -> str | None:
    """A band of counts, or several, which no family claims."""
    return OUTSIDE if words.f.turns > 2 or 0.15 < GRID[words.f.values.argmax()] < 0.85 else None


AT_AN_END, INSIDE = Rule(("threshold_loss", "truncation"), at_an_end), Rule((OUTSIDE,), inside)


@COUNTS.keep(
    regions(AT_AN_END, "value", "monotone", "stepped") | regions(INSIDE, "value", "local", "periodic"), (0.1, 2.0)
)
def lost(u, words):
    """Events are lost by their counts."""
    return min(words.strength, 1) * words.f(u)


OF_FEW = Rule(("threshold_loss",), of_few)


@COUNTS.change(regions(OF_FEW, "value", "monotone", "stepped"), (0.1, 2.0))
def suppressed(at, y, u, words, rng):
    """Events of few counts are recorded as empty."""
    return np.where(chosen(u, words, rng), 0, y)


# Events, or counts, come from elsewhere.


@COUNTS.change(
    nothing("flat_background") | {("density", "linear"): "flat_background", ("density", "local"): OUTSIDE}, (0.02, 0.8)
)
def replaced(at, y, u, words, rng):
    """A share of the events comes from elsewhere: spread widely, or gathered at one place."""
    n, reach = len(y), between(words.r[0], 0.5, 3) * at.ends[1]
    broad = one_of(
        words.r[1],
        (
            reach * words.f.sample(n, rng),
            reach / 2 * rng.standard_exponential(n),
            rng.poisson(reach * words.f.sample(n, rng)),
        ),
    )
    other = rng.poisson(at.at(words.f.sample(n, rng))) if words.f.kind == "local" else np.floor(broad)
    return np.where(rng.random(n) < words.strength, other, y)


@COUNTS.change(nothing("flat_background"), (0.02, 0.8))
def added(at, y, u, words, rng):
    """In a share of the events counts from elsewhere are added, of widely spread numbers."""
    n, reach = len(y), between(words.r[0], 0.3, 2) * at.ends[1]
    more = reach * one_of(words.r[1], (rng.random(n), 0.5 * rng.standard_exponential(n)))
    return y + np.where(rng.random(n) < words.strength, np.floor(more), 0)


# The reading is another number.


@COUNTS.change(
    nothing("readout_noise")
    | regions("readout_noise", "value", "linear", "monotone")
    | regions("readout_noise", "time", "monotone"),
    (0.1, 1.0),
)
def blurred(at, y, u, words, rng):
    """Noise is added to the reading, to all or a share of them: of any law, a hum, jumps, or a wrong bit."""
    n = len(y)
    width, hit = words.strength * (at.std + 0.5) * words.f(u), rng.random(n) < (1 if words.r[1] < 0.6 else words.r[2])
    if words.r[0] < 0.15:
        wrong = y.astype(int) ^ (1 << rng.integers(0, 1 + int(np.log2(at.ends[1] + 1)), n))
        return np.where(rng.random(n) < words.strength, wrong, y)
    if words.r[0] < 0.45:
        error = one_of(words.r[3], (np.sqrt(2) * np.sin(2 * np.pi * rng.random(n)), rng.choice([-1.0, 1.0], n)))
        return y + width * error * hit
    return y + width * noise(n, words.r[3], rng) * hit


@COUNTS.change(nothing("quantisation") | regions("quantisation", "value", "stepped", "monotone"), (0.1, 2.0))
def stepped(at, y, u, words, rng):
    """A share of the readings is known in steps: all, those near a multiple, or those in a part; or a bit sticks."""
    step = one_of(words.r[0], (2, 2, 3, 4, 5, 5, 6, 8, 10, 10, 12, 16))
    coarse = rounded(y, step, words.r[1])
    if words.r[2] < 0.15:
        bit = 1 << int(4 * words.r[3])
        coarse = y.astype(int) | bit if words.r[4] < 0.5 else y.astype(int) & ~bit
    near = words.r[2] < 0.7 or np.abs(y - coarse) <= step / 4
    return np.where(chosen(u, words, rng) & near, coarse, y)


@COUNTS.change({("value", "stepped"): "censoring"}, (0.2, 3.0))
def clipped(at, y, u, words, rng):
    """A share of the counts beyond a limit is recorded as the limit, which may scatter a little."""
    beyond, above = between(words.r[0], 0.01, 0.4), words.r[1] < 0.75
    limit = np.rint(np.quantile(at.values, 1 - beyond if above else beyond))
    limit = limit + rng.integers(0, 2, len(y)) if words.r[2] < 0.3 else limit
    over = y > limit if above else y < limit
    return np.where(over & (rng.random(len(y)) < min(words.strength, 1)), limit, y)


# The parameters are not the same in all events; and what no family claims.


@COUNTS.change(ANYHOW, (0.1, 1.0))
def shifted(at, y, u, words, rng):
    """Each count is too high, or too low, by the same number."""
    return y + words.sign * max(1, round(words.strength * at.std))


@COUNTS.change(ANYHOW, (0.05, 2.0))
def favoured(at, y, u, words, rng):
    """A share of the counts near one number is recorded as that number."""
    favourite = max(np.rint(np.quantile(at.values, 0.2 + 0.6 * words.r[0])), 1)
    near = np.abs(y - favourite) <= between(words.r[1], 0.3, 1.5) * at.std + 1
    return np.where(near & chosen(u, words, rng), favourite, y)


@COUNTS.change(ANYHOW, (0.05, 2.0))
def misread(at, y, u, words, rng):
    """The first two digits of a share of the counts have changed places."""
    return np.where(chosen(u, words, rng) & (y >= 10), transposed(y), y)


@COUNTS.event(ANYHOW, (0.05, 2.0))
def differences(simulate, theta, places, words, rng):
    """In a share of the cases the difference of two events is recorded."""
    x = simulate(theta, rng)
    return np.where(rng.random((len(x), 1)) < min(words.strength, 1), np.abs(x - simulate(theta, rng)), x)


COUNTS.event(ANYHOW, (0.05, 2.0))(best)
COUNTS.event(ANYHOW, (0.05, 2.0))(average)
COUNTS.event(nothing("mixture"), (0.02, 0.6))(mix)


@COUNTS.event(
    nothing("spread") | {("time", "monotone"): "spread"}, (0.1, 0.6), lambda task: len(task.parameter_names) == 2
)
def vary_form(simulate, theta, places, words, rng):
    """The second parameter is not the same in every event. That the first, a rate, is not, is overdispersion."""
    return vary(simulate, theta, places, words._replace(r=np.full(5, 0.9)), rng)
