"""Sealed cases whose events are one count: meteors, rallies of tennis, eggs of worms in sheep, votes at stations."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, plain, some


def meteors(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Meteors seen by a video camera in 15 minutes: some from anywhere, and a shower as high as its radiant stands."""
    height = np.sin(np.radians(rng.uniform(20, 80, len(theta))))
    return rng.poisson(theta[:, 1] + theta[:, 0] * height)


def rallies(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Strokes in a rally of tennis: a serve, which is returned with a chance, as is each later stroke with another."""
    return 1 + (rng.random(len(theta)) < theta[:, 0]) * rng.geometric(1 - theta[:, 1])


def eggs(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Eggs of worms counted on a slide of one sheep's dung, where a few sheep carry most worms (gamma and Poisson)."""
    return rng.poisson(theta[:, 0] * rng.gamma(theta[:, 1], 1 / theta[:, 1]))


def votes(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Votes for a party at a polling station with 1000 voters on its list, of whom about 60 per cent come."""
    came = rng.binomial(1000, rng.beta(60, 40, len(theta)))
    size = 1 / theta[:, 1] - 1
    return rng.binomial(came, rng.beta(theta[:, 0] * size, (1 - theta[:, 0]) * size))


METEORS = task(meteors, prior={"shower": (5, 60), "sporadic": (1, 10)}, features=["meteors"], name="meteors")
RALLIES = task(rallies, prior={"return": (0.4, 0.95), "stroke": (0.5, 0.92)}, features=["strokes"], name="rallies")
EGGS = task(eggs, prior={"mean": (10, 200), "aggregation": (0.4, 3)}, features=["eggs"], name="sheep-eggs")
VOTES = task(votes, prior={"share": (0.2, 0.7), "cluster": (0.005, 0.08)}, features=["votes"], name="polling-stations")


@case(METEORS, "single", right=("zero_inflation",), defensible=("overdispersion", "mixture", "spread", "inefficiency"))
def meteors_behind_clouds(rng: np.random.Generator) -> NDArray:
    """Banks of cloud drift by in 14 per cent of the intervals: from nothing up to six tenths of the meteors are left,
    more often little than much, as the cover factor of the visual counts of the IMO tells."""
    x = draw(METEORS, rng, 3200, 34, 4)[:, 0].astype(int)
    clear = np.where(some(rng, len(x), 0.14), 0.6 * rng.beta(0.6, 1.3, len(x)), 1)
    return rng.binomial(x, clear)


@case(METEORS, "single", right=("dead_time",), defensible=("inefficiency", "truncation", "censoring"))
def meteors_while_writing(rng: np.random.Generator) -> NDArray:
    """The camera sees nothing while it writes the clip of the last meteor, which takes 5 to 13 seconds as the clip is
    long: at a rate of one in twenty seconds the counts scatter much less than a Poisson number."""
    n = 6500
    rate = (5 + 52 * np.sin(np.radians(rng.uniform(20, 80, n)))) / 900
    gaps = rng.exponential(1 / rate[:, None], (n, 150))
    gaps[:, 1:] += rng.triangular(5, 6, 13, (n, 149))
    return (gaps.cumsum(axis=1) < 900).sum(axis=1)


@case(METEORS, "pair", right=("double_counting", "truncation"), defensible=("overdispersion",))
def meteors_in_pieces(rng: np.random.Generator) -> NDArray:
    """The software makes two detections of a meteor that flares or fragments (28 per cent), and now and then three; and
    intervals of more than about 52 detections overrun the disk and are lost, the fuller the more surely."""
    x = draw(METEORS, rng, 26000, 42, 6)[:, 0].astype(int)
    twice = rng.binomial(x, 0.28)
    x = x + twice + rng.binomial(twice, 0.15)
    return x[rng.random(len(x)) > 1 / (1 + np.exp((52 - x) / 1.2))]


@case(RALLIES, "single", right=("inefficiency",), defensible=("zero_inflation", "readout_noise", "flat_background"))
def rallies_by_ear(rng: np.random.Generator) -> NDArray:
    """The strokes are counted by a microphone that hears each with a chance from 75 to 97 per cent, as the seat is: a
    serve that is not returned may give no stroke at all."""
    x = draw(RALLIES, rng, 1500, 0.68, 0.78)[:, 0].astype(int)
    return rng.binomial(x, rng.uniform(0.75, 0.97, len(x)))


@case(RALLIES, "pair", right=("mixture", "censoring"), defensible=("spread", "overdispersion", "truncation"))
def rallies_on_two_courts(rng: np.random.Generator) -> NDArray:
    """A quarter of the points were played on clay, where strokes come back more often; and the sheet has one column for
    fifteen strokes and more."""
    x = draw(RALLIES, rng, 9000, 0.62, 0.58)[:, 0]
    clay = draw(RALLIES, rng, 9000, 0.85, 0.89)[:, 0]
    return np.minimum(np.where(some(rng, 9000, 0.25), clay, x), 15).astype(int)


@case(RALLIES, "outside", defensible=("threshold_loss",))
def rallies_on_television(rng: np.random.Generator) -> NDArray:
    """The broadcaster gives the longest rally of each game, of 4 to 8 points: the largest of several values, which no
    family of the catalogue draws."""
    x = draw(RALLIES, rng, 2400 * 8, 0.7, 0.72).reshape(2400, 8)
    played = rng.choice([4, 5, 6, 7, 8], 2400, p=[0.25, 0.25, 0.25, 0.05, 0.2])
    return np.where(np.arange(8) < played[:, None], x, 0).max(axis=1).astype(int)


@case(EGGS, "single", right=("pile_up",), defensible=("flat_background", "readout_noise", "mixture"))
def eggs_not_rinsed(rng: np.random.Generator) -> NDArray:
    """The chamber is only rinsed with water: of the eggs of the sheep before, 8 to 35 per cent stay in it and are
    counted again with the next. Few sheep are free of worms then."""
    x = draw(EGGS, rng, 9000, 75, 0.5)[:, 0].astype(int)
    before = draw(EGGS, rng, 9000, 75, 0.5)[:, 0].astype(int)
    return x + rng.binomial(before, rng.triangular(0.08, 0.12, 0.35, 9000))


@case(EGGS, "single", right=("quantisation",), defensible=("readout_noise",))
def eggs_in_a_tenth(rng: np.random.Generator) -> NDArray:
    """Slides on which more than about 80 eggs are seen at a glance are counted in two of ten fields only, and the count
    is multiplied by five: large counts are multiples of 5, and they have the scatter of the two fields."""
    x = draw(EGGS, rng, 1100, 95, 1.1)[:, 0].astype(int)
    full = x > rng.normal(80, 12, len(x))
    return np.where(full, 5 * rng.binomial(x, 0.2), x)


@case(EGGS, "outside")
def eggs_of_a_pen(rng: np.random.Generator) -> NDArray:
    """The dung of six sheep of a pen is mixed before the count: the means of six values scatter far less than the eggs
    of a single sheep may, and no family averages events."""
    worms = rng.gamma(1.6, 60 / 1.6, (4200, 6))
    return rng.poisson(worms.mean(axis=1))


@case(VOTES, "single", right=("threshold_loss",), defensible=("inefficiency", "dead_time"))
def votes_kept_secret(rng: np.random.Generator) -> NDArray:
    """Small results are not published, lest a vote be known: the districts draw the line at 100, 120 or 150
    votes, and one station in twelve is published all the same."""
    x = draw(VOTES, rng, 3400, 0.24, 0.06)[:, 0]
    line = np.where(some(rng, len(x), 1 / 12), 0, rng.choice([100, 120, 150], len(x), p=[0.6, 0.3, 0.1]))
    return x[x >= line].astype(int)


@case(VOTES, "pair", right=("flat_background", "zero_inflation"), defensible=("mixture", "overdispersion", "pile_up"))
def votes_stuffed(rng: np.random.Generator) -> NDArray:
    """At a sixth of the stations 60 to 400 votes were thrown in, as is said of several elections (Klimek et al. 2012);
    and at one station of eighteen the result was sent in before the count was over: none, or a part of it."""
    x = draw(VOTES, rng, 12000, 0.38, 0.015)[:, 0].astype(int)
    x = x + np.where(some(rng, len(x), 0.16), rng.integers(60, 400, len(x)), 0)
    part = np.where(some(rng, len(x), 0.4), 0, rng.uniform(0, 0.7, len(x)))
    return np.where(some(rng, len(x), 0.055), rng.binomial(x, part), x)


@case(VOTES, "outside")
def votes_counted_backward(rng: np.random.Generator) -> NDArray:
    """The tally runs backward when its register is full, as in Broward County in 2004 (there at 32 767, here at 350):
    360 votes read as 340. A fold of the scale, neither a limit nor a loss."""
    x = draw(VOTES, rng, 5200, 0.52, 0.03)[:, 0]
    return np.abs(np.where(x > 350, 700 - x, x)).astype(int)


CASES: list[Case] = [
    plain("meteors_of_a_clear_night", METEORS, 18000, 27, 5),
    plain("rallies_of_a_final", RALLIES, 420, 0.74, 0.8),
    plain("eggs_of_a_flock", EGGS, 4400, 52, 0.9),
    plain("votes_of_a_county", VOTES, 1600, 0.44, 0.03),
    *(c for c in tuple(globals().values()) if isinstance(c, Case)),
]
