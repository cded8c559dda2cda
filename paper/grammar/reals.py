"""The primitives for real numbers, each with the regions that families of the catalogue claim."""

import numpy as np

from avobench.effects.rejection import accepted
from paper.grammar.functions import GRID
from paper.grammar.sentences import (
    ANYHOW,
    OUTSIDE,
    Grammar,
    Place,
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

REALS = Grammar()


# Values are changed.


@REALS.change(
    nothing("offset")
    | regions("offset", "time", "monotone", "stepped")
    | regions("resolution", "time", "periodic")  # a swing that is seen as an error
    | regions(OUTSIDE, "value", "local", "stepped")
    | regions("conditional_response", "other", "smooth", "stepped", "local", "periodic"),
    (0.02, 1.0),
)
def shifted(at, y, u, words, rng):
    """Values are moved; a swing has no mean."""
    mean = words.f.values.mean() if words.f.kind == "periodic" else 0
    return y + words.sign * words.strength * at.std * (words.f(u) - mean)


@REALS.change(
    nothing("scale")
    | regions("scale", "value", "monotone", "linear", "stepped")
    | regions("scale", "time", "monotone", "stepped", "periodic")
    | regions("conditional_response", "other", "linear", "monotone", "smooth", "stepped", "local", "periodic"),
    (0.02, 0.7),
)
def stretched(at, y, u, words, rng):
    """Values are stretched about zero, or about the middle of the range."""
    centre = 0.0 if words.f.kind == "constant" or words.r[0] < 0.4 else at.at(np.array(0.5))
    return centre + (y - centre) * (1 + words.sign * words.strength * words.f(u))


@REALS.change({("value", "monotone"): "saturation"}, (0.3, 10.0))
def bent(at, y, u, words, rng):
    """The response bends over beyond a knee, at the upper end, the lower or both."""
    centre, width = np.median(at.values), at.half / words.strength
    knee = np.quantile(at.values, 0.5 + 0.45 * words.r[0]) - centre
    law, side = one_of(words.r[1], (np.tanh, np.log1p, lambda t: t / (1 + t))), one_of(words.r[2], (1, 1, -1, 0))
    beyond = np.maximum(np.abs(y - centre) - knee, 0) * ((side == 0) | (np.sign(y - centre) == side))
    return y - np.sign(y - centre) * (beyond - width * law(beyond / width))


@REALS.change(
    nothing("resolution")
    | regions("resolution", "value", "linear", "monotone", "smooth", "stepped")
    | regions("resolution", "time", "linear", "monotone", "stepped")
    | regions("conditional_response", "other", "linear", "monotone", "smooth", "stepped", "local"),
    (0.05, 1.0),
)
def blurred(at, y, u, words, rng):
    """Values have a random error."""
    return y + words.strength * at.std * words.f(u) * noise(len(y), words.r[0], rng)


@REALS.change(nothing("radiative_tail") | regions("radiative_tail", "value", "monotone"), (0.02, 1.2))
def delayed(at, y, u, words, rng):
    """A share of the values is moved to one side by a random distance, or loses a random part."""
    hit, n = chosen(u, words, rng), len(y)
    if words.r[0] < 0.3 and (at.values >= 0).all():
        return np.where(hit, y * (1 - rng.beta(between(words.r[1], 0.1, 2), between(words.r[2], 0.5, 4), n)), y)
    way = one_of(words.r[2], (rng.standard_exponential(n), rng.gamma(0.5, 2, n), rng.pareto(2.5, n)))
    return np.where(hit, y + words.sign * between(words.r[1], 0.03, 0.6) * at.half * way, y)


@REALS.change(nothing("outliers"), (0.003, 0.3))
def thrown(at, y, u, words, rng):
    """A few values are far off."""
    n, side = len(y), one_of(words.r[0], (0, 0, 1, -1))
    error = one_of(words.r[1], (rng.standard_normal(n), 0.4 * rng.standard_cauchy(n), rng.standard_exponential(n)))
    error = side * np.abs(error) if side else error
    return np.where(chosen(u, words, rng), y + between(words.r[2], 1, 12) * at.half * error, y)


def signed(at: Place) -> bool:
    """Whether at least 5 % of the values have either sign."""
    return bool(0.05 < (at.values > 0).mean() < 0.95)


@REALS.change(nothing("charge_misid") | regions("charge_misid", "value", "linear", "monotone"), (0.01, 0.6), signed)
def flipped(at, y, u, words, rng):
    """The sign of a value is taken wrongly, more often for one sign, or with a chance by its size."""
    by_size = words.f.kind != "constant" and words.r[0] < 0.6
    where = np.clip(np.abs(y) / max(np.abs(at.ends)), 0, 1) if by_size else u
    return np.where(chosen(where, words, rng), -y, y)


@REALS.change(nothing("quantisation") | regions("quantisation", "value", "monotone", "stepped"), (0.1, 2.0))
def stepped(at, y, u, words, rng):
    """A share of the values is known in steps: even ones, ones that grow, or only near a multiple or in a part."""
    step = between(words.r[0], 0.02, 0.5) * at.half
    coarse = rounded(y, step, words.r[1])
    if words.f.kind == "monotone":  # steps that are even in a function of the value
        rising = (
            np.maximum.accumulate(words.f.values if words.f.values[-1] > 0.5 else words.f.values[::-1]) + 1e-6 * GRID
        )
        inside = (y >= at.ends[0]) & (y <= at.ends[1])
        share = between(words.r[0], 0.02, 0.3)
        even = np.clip(rounded(np.interp(u, GRID, rising), share, 0), 0, rising[-1])
        coarse = np.where(inside, at.at(np.interp(even, rising, GRID)), y)
        return np.where(rng.random(len(y)) < min(words.strength, 1), coarse, y)
    near = words.r[2] > 0.3 or np.abs(y - coarse) < between(words.r[3], 0.05, 0.4) * step
    return np.where(chosen(u, words, rng) & near, coarse, y)


@REALS.change({("value", "stepped"): "saturation"}, (0.2, 3.0))
def clipped(at, y, u, words, rng):
    """A share of the values beyond a limit, on one side or both, is recorded as the limit, or as one value."""
    beyond, side = between(words.r[0], 0.005, 0.3), one_of(words.r[1], (0, 1, 1, -1))
    low = np.quantile(at.values, beyond) if side <= 0 else -np.inf
    high = np.quantile(at.values, 1 - beyond) if side >= 0 else np.inf
    value = np.clip(y, low, high)
    if words.r[2] < 0.2:
        value = np.where(y > high, high + words.r[3] * at.half, np.where(y < low, low - words.r[3] * at.half, y))
    hit = (value != y) & (rng.random(len(y)) < min(words.strength, 1))
    ripple = 0.02 * at.half * rng.standard_normal(len(y)) if words.r[4] < 0.2 else 0
    return np.where(hit, value + ripple, y)


@REALS.change({("value", "stepped"): OUTSIDE}, (0.2, 3.0))
def wrapped(at, y, u, words, rng):
    """Values beyond the end of a scale begin again at its other end."""
    high = np.quantile(at.values, 1 - between(words.r[0], 0.02, 0.3))
    back = at.ends[0] + (y - high)
    return np.where((y > high) & (rng.random(len(y)) < min(words.strength, 1)), back, y)


@REALS.change(ANYHOW, (0.05, 2.0))
def misread(at, y, u, words, rng):
    """The first two digits of a share of the values have changed places."""
    return np.where(chosen(u, words, rng), transposed(y), y)


# Events come from elsewhere.


@REALS.change(
    nothing("flat_background")
    | regions("flat_background", "density", "linear")
    | {("density", "local"): "peak_background", ("density", "periodic"): OUTSIDE},
    (0.01, 0.6),
)
def replaced(at, y, u, words, rng):
    """A share of the events comes from elsewhere: the function is the density over the range, or over a wider one."""
    wide = 1 if words.r[0] < 0.4 else between(words.r[1], 1, 3)
    place = at.at(0.5 + wide * (words.f.sample(len(y), rng) - 0.5))
    place = np.abs(place) if (at.values >= 0).all() else place
    return np.where(rng.random(len(y)) < words.strength, place, y)


@REALS.change({("density", "monotone"): "second_exponential"}, (0.02, 0.6))
def decaying(at, y, u, words, rng):
    """A share of the events comes from elsewhere, and falls off exponentially from one end of the range."""
    way = between(words.r[0], 0.05, 1.5) * at.half * rng.standard_exponential(len(y))
    place = at.ends[0] + way if words.r[1] < 0.7 else at.ends[1] - way
    return np.where(rng.random(len(y)) < words.strength, place, y)


# Events are lost.


def wavy(words: Words) -> str | None:
    """Losses in several places are none of the acceptances."""
    return OUTSIDE if words.f.turns > 2 else None


def on_a_side(words: Words) -> str | None:
    """Losses that rise or fall over the range: towards an end or on one side, by where they are half of the largest."""
    f = words.f
    where = f.half if f.values[-1] > f.values[0] else 1 - f.half  # in the direction in which ever more are lost
    if f.turns:
        return None
    return "edge_acceptance" if where > 0.72 else "forward_backward_acceptance" if 0.35 < where < 0.62 else None


def inside(words: Words) -> str | None:
    """Losses at one place that has events on both sides."""
    return "dead_region" if 0.12 < GRID[words.f.values.argmax()] < 0.88 else None


ON_A_SIDE = Rule(("edge_acceptance", "forward_backward_acceptance"), on_a_side)


@REALS.keep(
    regions("forward_backward_acceptance", "value", "linear")
    | regions(ON_A_SIDE, "value", "monotone", "stepped")
    | regions(Rule(("dead_region",), inside), "value", "local")
    | regions(Rule((OUTSIDE,), wavy), "value", "smooth", "periodic"),
    (0.05, 2.0),
)
def lost(u, words):
    """Events are lost by the value of a feature."""
    return min(words.strength, 1) * words.f(u)


def at_both_ends(words: Words) -> str | None:
    """Losses that rise towards the ends, most of them near these."""
    return "edge_acceptance" if words.f.values[-1] == 1 and words.f.half > 0.5 else None


@REALS.keep({("value", "monotone"): Rule(("edge_acceptance",), at_both_ends)}, (0.05, 2.0))
def lost_at_both_ends(u, words):
    """Events are lost the more, the nearer they are to either end of the range."""
    return min(words.strength, 1) * words.f(np.abs(2 * u - 1))


@REALS.event({("all", "local"): OUTSIDE}, (0.3, 2.0))
def hole(simulate, theta, places, words, rng):
    """Events are lost in a region of two features, or one of them is by chance where the other one is."""
    first, second = places[0], places[1 + int(words.r[0] * (len(places) - 1))]
    centre, width = 0.2 + 0.6 * words.r[1:3], between(words.r[3], 0.08, 0.3)

    def kept(x, rows):
        u = [at.unit(x[:, at.feature]) for at in (first, second)]
        inside = (np.abs(u[0] - centre[0]) < width) & (np.abs(u[1] - centre[1]) < width)
        return 1 - min(words.strength, 1) * inside

    return accepted(simulate, theta, kept, rng)


# Features go together in another way.


@REALS.event(regions("crosstalk", "all", "linear", "monotone"), (0.03, 1.0))
def leaked(simulate, theta, places, words, rng):
    """A part of another feature, of what it exceeds a level by, or of all others, is added to one or to each."""
    x = simulate(theta, rng)
    z = (x - x.mean(axis=0)) / [at.std for at in places]
    d = len(places)
    j, k = a_pair(words.r, d)
    signal = np.maximum(z[:, k] - 2 * words.r[2] + 0.5, 0) if words.f.kind == "monotone" else z[:, k]
    if words.r[3] < 0.3:  # into each, from all others or from the next
        every = (z.sum(axis=1, keepdims=True) - z) / (d - 1) if words.r[4] < 0.5 else np.roll(z, -1, axis=1)
        return x + words.sign * words.strength * every * [at.std for at in places]
    x[:, j] += words.sign * words.strength * places[j].std * signal
    return x


def a_pair(r, d):
    """Two different features of d that uniform numbers choose."""
    j = int(r[0] * d)
    return j, (j + 1 + int(r[1] * (d - 1))) % d


@REALS.event(regions("correlation", "all", "constant", "linear"), (0.05, 1.0))
def shared(simulate, theta, places, words, rng):
    """Two features, or all, have an error in common: each is moved, or stretched about zero, by the same amount."""
    x, d = simulate(theta, rng), len(places)
    error, gains = words.strength * noise(len(x), words.r[2], rng), words.f.kind == "linear" and words.r[3] < 0.5
    lever = np.ones(d) if words.f.kind == "constant" else np.linspace(-1, 1, d) + 4 * words.r[3] - 2
    if words.r[4] < 0.4:
        lever = np.isin(np.arange(d), a_pair(words.r, d)) * np.where(np.arange(d) == int(words.r[0] * d), words.sign, 1)
    if gains:
        return x * (1 + 0.5 * error[:, None])
    return x + error[:, None] * lever * [at.std for at in places]


@REALS.event({("all", "constant"): OUTSIDE}, (0.03, 1.5))
def exchanged(simulate, theta, places, words, rng):
    """In a share of the events a feature is that of another event, or two features have changed places."""
    x = simulate(theta, rng)
    rows, (j, k) = rng.random(len(x)) < min(words.strength, 1), a_pair(words.r, len(places))
    if words.r[2] < 0.5:
        mean, std = x.mean(axis=0), x.std(axis=0)
        z = (x[rows] - mean) / std  # as if they had one unit
        x[rows, j], x[rows, k] = mean[j] + std[j] * z[:, k], mean[k] + std[k] * z[:, j]
    else:
        x[rows, j] = simulate(theta, rng)[rows, j]
    return x


# The parameters are not the same in all events; and what no family claims.

REALS.event(nothing("spread") | regions("spread", "time", "monotone", "periodic"), (0.05, 0.6))(vary)
REALS.event(nothing("mixture"), (0.02, 0.6))(mix)
REALS.event(ANYHOW, (0.05, 2.0))(best)
REALS.event(ANYHOW, (0.05, 2.0))(average)
