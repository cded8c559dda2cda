"""Measured data on people, sport and language, with an answer from the literature. Their sources are in README.md."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import poisson

Rng = np.random.Generator
read = reader(__file__)


ASKED = read("polls", counts=True)[:, 1]
"""How many were asked in each poll."""
AT_BATS = read("batting")[:, 0]
"""How often each player was at bat."""
EASE = np.array(
    [
        0.91,
        0.41,
        0.05,
        1.31,
        0.52,
        0.00,
        0.38,
        -0.52,
        -1.15,
        0.80,
        -0.27,
        -0.78,
        0.91,
        0.28,
        -0.66,
        0.64,
        -0.05,
        -1.12,
        -0.16,
        -1.13,
        -2.29,
        0.52,
        -0.29,
        -1.51,
    ]
)
"""How easily people say yes to each of the 24 items on verbal aggression, in logits."""


def people_alike(theta: NDArray, rng: Rng) -> NDArray:
    """Return to how many of the 24 items somebody says yes, where all people are equally inclined to."""
    chance = 1 / (1 + np.exp(-theta[:, :1] - EASE))
    return (rng.random(chance.shape) < chance).sum(axis=1)


def sichel(theta: NDArray, rng: Rng) -> NDArray:
    """Return how often a word is used, at a rate that is inverse Gaussian; of words with at most 100 uses."""
    uses = np.full(len(theta), 101)
    while (again := np.flatnonzero(uses > 100)).size:
        uses[again] = rng.poisson(np.maximum(rng.wald(theta[again, 0], theta[again, 1]), 0))
    return uses


def poll(theta: NDArray, rng: Rng) -> NDArray:
    """Return the share found in a poll, in whole per cent, with the error of a random sample alone."""
    asked = rng.choice(ASKED, len(theta))
    return np.round(100 * rng.binomial(asked, theta[:, 0] / 100) / asked)


def trip(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal distances, in tenths of a mile, of trips of half a mile at least."""
    distance = np.zeros(len(theta))
    while (again := np.flatnonzero(distance < 0.5)).size:
        distance[again] = np.round(theta[again, 0] * np.exp(theta[again, 1] * rng.standard_normal(again.size)), 1)
    return distance


def batter(theta: NDArray, rng: Rng) -> NDArray:
    """Return times at bat, as those of the season, and an average that is normal about a line in their logarithm."""
    at_bats = rng.choice(AT_BATS, len(theta))
    line = theta[:, 0] + theta[:, 1] * np.log10(at_bats / 200)
    average = np.clip(line + theta[:, 2] * rng.standard_normal(len(theta)), 0, 1)
    return np.stack([at_bats, np.round(np.round(average * at_bats) / at_bats, 3)], axis=1)


def fair_draw(theta: NDArray, rng: Rng) -> NDArray:
    """Return a day of the year and the number drawn for it, both of them any whole number from 1 to the last."""
    return np.ceil(theta[:, :1] * (1 - rng.random((len(theta), 2))))


def two_wholes(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values with a correlation, rounded to whole units."""
    z = rng.standard_normal((2, len(theta)))
    second = theta[:, 4] * z[0] + np.sqrt(1 - theta[:, 4] ** 2) * z[1]
    return np.round(np.stack([theta[:, 0] + theta[:, 1] * z[0], theta[:, 2] + theta[:, 3] * second], axis=1))


WARS = task(poisson, prior={"rate": (0.1, 3)}, features=["wars"], name="outbreaks-of-war")
AGGRESSION = task(people_alike, prior={"inclination": (-2, 2)}, features=["reactions"], name="verbal-aggression")
WORDS = task(sichel, prior={"mean": (0.1, 12), "scale": (0.01, 3)}, features=["uses"], name="uses-of-words")
POLLS = task(poll, prior={"share": (30, 60)}, features=["clinton"], name="election-polls")
TAXI = task(trip, prior={"median": (0.8, 15), "log_width": (0.3, 2)}, features=["distance"], name="taxi-trips")
BATTING = task(
    batter,
    prior={"level": (0.15, 0.35), "slope": (-0.1, 0.15), "width": (0.01, 0.12)},
    features=["at_bats", "average"],
    name="batting-averages",
)
DRAFT = task(fair_draw, prior={"last": (330, 400)}, features=["day", "number"], name="draft-lottery")
TESTS = task(
    two_wholes,
    prior={"visual": (15, 45), "width": (3, 15), "straight": (120, 260), "spread": (15, 80), "tie": (-0.9, 0.9)},
    features=["visual", "straight"],
    name="school-tests",
)


@case(WARS)
def wars_broken_out(rng: Rng) -> NDArray:
    """Wars that broke out in each of the 432 years from 1500 to 1931: as many as come by chance at one rate.

    L. F. Richardson (1944), The distribution of wars in time, J. R. Stat. Soc. 107, 242: the law of Poisson fits.
    """
    return read("wars", counts=True)


@case(
    AGGRESSION,
    "single",
    right=("overdispersion", "spread"),
    defensible=("mixture", "zero_inflation", "flat_background", "double_counting"),
)
def verbal_aggression(rng: Rng) -> NDArray:
    """To how many of 24 ways of cursing, scolding and shouting a student says yes: people differ in how inclined.

    P. De Boeck and M. Wilson (2004), Explanatory Item Response Models: each person has an inclination of their own,
    which is the trait that the items measure. The simulator knows the items, and takes all people to be alike.
    """
    return read("verbal_reactions", counts=True)


@case(WORDS, "single", right=("threshold_loss",))
def words_of_shakespeare(rng: Rng) -> NDArray:
    """How often Shakespeare used each of his words: those that he knew and never used are not in the list.

    B. Efron and R. Thisted (1976), How many words did Shakespeare know?, Biometrika 63, 435; the law of rates is that
    of H. Sichel (1975), J. Am. Stat. Assoc. 70, 542. The list ends at 100 uses, which the simulator knows.
    """
    return read("words_of_shakespeare", counts=True)


@case(POLLS, "single", right=("resolution", "spread"), defensible=("mixture", "outliers", "flat_background"))
def polls_for_clinton(rng: Rng) -> NDArray:
    """Per cent for Clinton in national polls from August 2016 on: they differ by more than random samples would.

    H. Shirani-Mehr, D. Rothschild, S. Goel and A. Gelman (2018), Disentangling bias and variance in election polls, J.
    Am. Stat. Assoc. 113, 607: the error is about twice the stated one, as pollsters ask and weigh in their own ways.
    """
    return read("polls")[:, 0]


@case(TAXI, "single", right=("peak_background", "mixture"), defensible=("second_exponential", "flat_background"))
def taxis_to_the_airport(rng: Rng) -> NDArray:
    """Miles of taxi trips in Chicago: beside the short ones in the city there are those to and from the airports.

    City of Chicago, Taxi Trips (2022). O'Hare is 17 or 18 miles from the centre and Midway 11, so that trips there form
    peaks of their own.
    """
    return read("taxi_trips")


@case(
    BATTING,
    "single",
    right=("conditional_response on average",),
    defensible=("outliers on average", "spread on width", "mixture"),
)
def batting_averages(rng: Rng) -> NDArray:
    """Times at bat and batting averages of 2010, without pitchers: averages of few times at bat scatter more widely.

    B. Efron and C. Morris (1975), J. Am. Stat. Assoc. 70, 311; L. Brown (2008), Ann. Appl. Stat. 2, 113. The variance
    has a part that falls as one over the times at bat; the simulator has the same width for all.
    """
    return read("batting")


@case(DRAFT, "single", right=("correlation", "conditional_response on number"), defensible=("conditional_response",))
def draft_lottery(rng: Rng) -> NDArray:
    """Days of the year and the numbers drawn for them in the draft of 1970: late days have low numbers too often.

    S. Fienberg (1971), Randomization and social affairs: the 1970 draft lottery, Science 171, 255. The capsules were
    put in month by month and hardly mixed, so day and number are correlated, by -0.23.
    """
    return read("draft")


@case(TESTS)
def tests_of_two_schools(rng: Rng) -> NDArray:
    """Scores of 301 pupils in visual perception and in telling straight from curved capitals: normal, and tied.

    K. Holzinger and F. Swineford (1939), A Study in Factor Analysis; K. Joereskog (1969), Psychometrika 34, 183, whose
    analysis by maximum likelihood takes such scores to be normal.
    """
    return read("school_tests")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
