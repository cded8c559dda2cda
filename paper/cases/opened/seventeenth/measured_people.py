"""Measured data from people and what they make. Their sources are in README_b.md, and the files in data/."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import negative_binomial, poisson

Rng = np.random.Generator
read = reader(__file__)


def milliseconds(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal times in seconds, to the millisecond."""
    return np.round(rng.normal(theta[:, 0], theta[:, 1]), 3)


def hundredths(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to hundredths."""
    return np.round(rng.normal(theta[:, 0], theta[:, 1]), 2)


def lognormal_tenths(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal values, rounded to tenths."""
    return np.round(theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta))), 1)


BEANS_THROWN = np.array([23, 65, 107, 147, 156, 135, 122, 107, 69, 45, 26, 14, 11])
"""How often Jevons found 3, 4, ..., 15 beans in the box when he counted them."""


def guesses(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many beans lay in the box, and a guess whose error has one width whatever their number."""
    actual = rng.choice(np.arange(3, 16), size=len(theta), p=BEANS_THROWN / BEANS_THROWN.sum())
    return np.stack([actual, np.round(rng.normal(actual + theta[:, 0], theta[:, 1]))], axis=1).astype(float)


def two_alone(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values that have nothing to do with each other: in whole points, and in half ones."""
    z = rng.standard_normal((2, len(theta)))
    language = np.round(theta[:, 0] + theta[:, 1] * z[0])
    return np.stack([language, np.round(2 * (theta[:, 2] + theta[:, 3] * z[1])) / 2], axis=1)


SHELLS = task(
    negative_binomial, prior={"mean": (0.1, 2), "shape": (0.2, 5)}, features=["accidents"], name="shell-workers"
)
TENURE = task(negative_binomial, prior={"mean": (1, 20), "shape": (0.3, 6)}, features=["years"], name="years-in-a-job")
CALLS = task(poisson, prior={"rate": (50, 400)}, features=["calls"], name="bank-calls")
WORDS = task(
    milliseconds,
    prior={"mean": (0.3, 2), "width": (0.05, 1)},
    features=["time"],
    feature_units={"time": "s"},
    name="word-decisions",
)
FERTILITY = task(
    hundredths, prior={"mean": (2, 8), "width": (0.5, 4)}, features=["children"], name="fertility-of-nations"
)
HOUSES = task(
    lognormal_tenths, prior={"median": (30, 120), "log_width": (0.1, 1)}, features=["price"], name="windsor-houses"
)
BEANS = task(
    guesses, prior={"bias": (-1.5, 1.5), "width": (0.2, 3)}, features=["actual", "estimated"], name="numbers-of-beans"
)
PUPILS = task(
    two_alone,
    prior={"language": (30, 50), "width": (3, 18), "iq": (8, 16), "spread": (0.8, 5)},
    features=["language", "iq"],
    name="dutch-pupils",
)


@case(SHELLS)
def accidents_of_shell_workers(rng: Rng) -> NDArray:
    """Accidents in five weeks of 647 women who made shells: some are more prone to them, as the simulator knows.

    M. Greenwood and G. Yule (1920), J. R. Stat. Soc. 83, 255, made the negative binomial law for these numbers, and it
    has fitted them in the textbooks ever since.
    """
    return read("shell_workers", counts=True)


@case(TENURE, "single", right=("censoring",), defensible=("saturation", "flat_background", "mixture"))
def years_in_a_job_of_borrowers(rng: Rng) -> NDArray:
    """Whole years that borrowers have been in their job: those of ten years and more are all written as 10.

    Loans of Lending Club in 2018, whose description says so: "If longer than 10 years, then this is represented by the
    value 10". So the counts end at 10, and there is a crowd there.
    """
    return read("years_in_job", counts=True)


@case(CALLS, "single", right=("overdispersion", "spread"), defensible=("mixture", "flat_background"))
def bank_calls_in_five_minutes(rng: Rng) -> NDArray:
    """Calls to a bank in five minutes, on weekdays from 7:00 to 21:05: the rate rises and falls during each day.

    J. Weinberg, L. Brown and J. Stroud (2007), J. Am. Stat. Assoc. 102, 1185: a Poisson process whose rate is not the
    same at all times. The simulator has one rate, so the counts scatter more than it says.
    """
    return read("bank_calls", counts=True)


@case(
    WORDS,
    "single",
    right=("radiative_tail",),
    defensible=("outliers", "second_exponential", "resolution", "mixture", "spread"),
)
def words_told_from_nonwords(rng: Rng) -> NDArray:
    """Times in which one person tells words from strings that are none: normal, with an exponential tail to the right.

    R. Hohle (1965), J. Exp. Psychol. 69, 382, and R. Ratcliff (1979), Psychol. Bull. 86, 446: times of reactions are a
    normal one plus an exponential one. Data of E. Freeman et al. (2010), J. Mem. Lang. 62, 1.
    """
    return read("word_decisions")


@case(FERTILITY, "single", right=("mixture",), defensible=("peak_background",))
def fertility_of_two_worlds(rng: Rng) -> NDArray:
    """Children per woman in the nations in 1962 and 1972: few in the rich ones, six or seven in the poor ones.

    C. Wilson (2001), Popul. Dev. Rev. 27, 155, and R. Irizarry, Introduction to Data Science, on data of Gapminder: the
    world was then two groups, each about its own mean, where the simulator has one.
    """
    return read("fertility")


@case(HOUSES, "single", right=("quantisation",), defensible=("peak_background",))
def houses_of_windsor(rng: Rng) -> NDArray:
    """Prices of houses sold in Windsor, Ontario, in 1987, in 1000 dollars: people agree on round sums.

    P. Anglin and R. Gencay (1996), J. Appl. Econom. 11, 633; on round prices D. Pope, J. Pope and J. Sydnor (2015),
    Games Econ. Behav. 93. The simulator rounds to 100 dollars only, and two thirds of the prices are whole thousands.
    """
    return read("windsor_houses")


@case(
    BEANS,
    "single",
    right=("conditional_response on estimated",),
    defensible=("resolution on estimated", "scale on estimated", "conditional_response", "crosstalk"),
)
def beans_that_jevons_guessed(rng: Rng) -> NDArray:
    """Beans in a box, and how many Jevons thought there were at a glance: the more there are, the more he errs.

    W. Jevons (1871), Nature 3, 281: up to four he is never wrong, above ten more often than not, and then he mostly
    says too few. The simulator takes the numbers as they fell, but gives all guesses the same error.
    """
    return read("beans")


@case(PUPILS, "single", right=("correlation",), defensible=("crosstalk", "conditional_response"))
def language_and_wits_of_pupils(rng: Rng) -> NDArray:
    """Language scores and verbal IQ of Dutch pupils of about 11 years: who does well in one does so in the other.

    T. Snijders and R. Bosker (1999), Multilevel Analysis, whose example it is. In the simulator each is normal and
    independent of the other, so that it lacks what they share.
    """
    return read("dutch_pupils")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
