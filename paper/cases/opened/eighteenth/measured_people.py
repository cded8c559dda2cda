"""Measured data of people and what they make. Their sources are in data/README.md."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import lognormal, negative_binomial, normal, poisson

Rng = np.random.Generator
read = reader(__file__)


def ten_words(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of ten words somebody knows, with the same chance for everybody."""
    return rng.binomial(10, theta[:, 0])


def cents(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal amounts, rounded to cents."""
    return np.round(lognormal(theta, rng), 2)


def months_begun(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal times, in months that have begun."""
    return np.ceil(lognormal(theta, rng))


def twentieths(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to steps of 0.05."""
    return np.round(20 * normal(theta, rng)) / 20


def hundredths_in_log(theta: NDArray, rng: Rng) -> NDArray:
    """Return the decimal logarithms of lognormal values that are rounded to hundredths, of which the least is one."""
    return np.log10(np.maximum(np.round(10 ** normal(theta, rng), 2), 0.01))


def homes(theta: NDArray, rng: Rng) -> NDArray:
    """Return areas that are lognormal, and prices on a straight line of them with normal errors of one width.

    Areas, in hundreds of square feet, are rounded to halves, and prices, in thousands of dollars, to tens.
    """
    area = lognormal(theta, rng)
    price = theta[:, 2] + theta[:, 3] * area + theta[:, 4] * rng.standard_normal(len(theta))
    return np.stack([np.round(2 * area) / 2, np.round(price / 10) * 10], axis=1)


KICKS = task(poisson, prior={"rate": (0.1, 4)}, features=["deaths"], name="horse-kicks")
WORDS = task(ten_words, prior={"chance": (0.1, 0.95)}, features=["right"], name="ten-words")
PARK = task(negative_binomial, prior={"mean": (0.3, 40), "shape": (0.1, 5)}, features=["visits"], name="park-visits")
WAGES = task(cents, prior={"median": (2, 25), "log_width": (0.2, 1.2)}, features=["wage"], name="wages-by-the-hour")
PAY = task(twentieths, prior={"mean": (2, 6), "width": (0.05, 2.5)}, features=["log_pay"], name="pay-of-game-makers")
AMES = task(
    homes,
    prior={"median": (8, 25), "log_width": (0.1, 0.8), "base": (-100, 120), "slope": (2, 25), "noise": (10, 150)},
    features=["area", "price"],
    name="homes-of-ames",
)
GIANTS = task(
    hundredths_in_log, prior={"mean": (-1.5, 2), "width": (0.2, 1.5)}, features=["log_value"], name="largest-companies"
)
PRISON = task(
    months_begun, prior={"median": (10, 2000), "log_width": (0.5, 4)}, features=["months"], name="return-to-prison"
)


@case(KICKS)
def soldiers_kicked_by_horses(rng: Rng) -> NDArray:
    """Deaths by the kick of a horse in ten corps of the Prussian army in each of twenty years: counts of Poisson.

    L. von Bortkiewicz (1898), Das Gesetz der kleinen Zahlen; R. A. Fisher (1925), Statistical Methods for Research
    Workers, who tests these 200 counts and finds that the law of Poisson describes them.
    """
    return read("horse_kicks", counts=True)


@case(
    WORDS,
    "single",
    right=("spread", "overdispersion"),
    defensible=("mixture", "zero_inflation", "flat_background", "double_counting"),
)
def meanings_of_ten_words(rng: Rng) -> NDArray:
    """How many of ten words Americans know, where the model gives everybody the same chance: some know many more words.

    General Social Survey, the test Wordsum; A. Beaujean and Y. Sheng (2010), Examining the Flynn effect in the General
    Social Survey vocabulary test using item response theory, Pers. Individ. Differ. 48, 294: ability is a
    distribution. It is a spread of the chance, or in other words a greater variance than the binomial one.
    """
    return read("ten_words", counts=True)


@case(PARK, "single", right=("threshold_loss",))
def visits_of_park_goers(rng: Rng) -> NDArray:
    """Visits to a park in a year, asked of people in the park: who never came, and so has none, cannot be among them.

    J. Loomis (2003), Water Resour. Res. 39, 1105, who corrects for it; J. Hilbe (2011), Negative Binomial Regression.
    Who comes rarely is also met less often there, which is a loss towards few counts as well.
    """
    return read("park_visits", counts=True)


@case(WAGES, "single", right=("quantisation", "heaping"), defensible=("peak_background",))
def wages_by_the_hour(rng: Rng) -> NDArray:
    """Dollars an hour that Americans earned in May 1985: 5.00, 7.50 or 10.00 come far more often than 5.13.

    E. Berndt (1991), The Practice of Econometrics, chapter 5, with the textbook's lognormal wage; on the bunching of
    wages at round numbers A. Dube, A. Manning and S. Naidu (2018), NBER Working Paper 24991. Employers pay round
    wages and people tell them rounded, so that a share of the values is a multiple of a step.
    """
    return read("wages_1985")


@case(
    PAY,
    "single",
    right=("mixture",),
    defensible=("peak_background", "outliers", "radiative_tail", "flat_background", "second_exponential"),
)
def pay_of_game_makers(rng: Rng) -> NDArray:
    """Logarithm of the pay that makers of computer games wrote into a shared table: some by the hour, most by the year.

    Employees of Blizzard, 2020 (Bloomberg, 3 August 2020); the table has a column that says which of the two it is,
    but the pay is taken as it was written. So two populations are in it, each with its own mean and width.
    Logarithms are rounded to 0.05, measured and simulated, as people tell round sums.
    """
    return np.round(20 * np.log10(read("game_makers"))) / 20


@case(
    AMES,
    "single",
    right=("conditional_response on price", "spread on slope"),
    defensible=("outliers on price", "mixture", "spread", "conditional_response", "resolution on price"),
)
def homes_of_ames(rng: Rng) -> NDArray:
    """Areas of homes in Ames, and prices on a straight line of them: prices of large homes scatter far more about it.

    D. De Cock (2011), Ames, Iowa: alternative to the Boston housing data, J. Stat. Educ. 19(3). The error has one
    width in the model, but grows with the area in truth: a smearing of the price that depends on the area, which is
    also what a price per square foot that differs from home to home makes.
    """
    return read("ames_homes")


@case(
    GIANTS,
    "single",
    right=("edge_acceptance", "turn_on"),
    defensible=("truncation", "threshold_loss", "radiative_tail", "second_exponential", "dead_region"),
)
def market_values_of_giants(rng: Rng) -> NDArray:
    """Logarithm of the market value of the 2000 largest companies: the smaller its value, the rarer one is in the list.

    Forbes, 2004; sizes of firms are lognormal by the textbook (R. Gibrat 1931; M. Stanley et al. 1995, Econ. Lett. 49,
    453). The list ranks by sales, profits, assets and market value together, so that companies of a low value are
    lost gradually and not at one limit.
    """
    return np.log10(np.maximum(read("giants"), 0.01))


@case(
    PRISON,
    "single",
    right=("saturation", "censoring"),
    defensible=("peak_background", "edge_acceptance", "truncation", "mixture"),
)
def months_until_prison_again(rng: Rng) -> NDArray:
    """Months until released men returned to prison: most did not while they were followed, and have that time instead.

    C.-F. Chung, P. Schmidt and A. Witte (1991), J. Quant. Criminol. 7, 59; J. Wooldridge, Introductory Econometrics,
    chapter 17, whose example of censored times it is. They were followed for 70 to 81 months, which differed
    from man to man: later returns are recorded as that limit.
    """
    return read("prison_again")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
