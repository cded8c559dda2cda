"""Measured data sets with the first model of a textbook, and what the literature says is wrong with it."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avobench import task
from avobench.tasks import Task
from paper.cases.case import Case, case


def read(name: str) -> NDArray:
    """Return a table of the folder `data`: one column as (n,), more as (n, d)."""
    return np.loadtxt(Path(__file__).parent / "data" / f"{name}.csv", delimiter=",", skiprows=1)


def counts(name: str) -> NDArray:
    """Return a table of counts."""
    return read(name).astype(int)


def poisson(feature: str, name: str, low: float, high: float) -> Task:
    """Return a task in which a count is a Poisson number."""

    def simulator(theta: NDArray, rng: np.random.Generator) -> NDArray:
        return rng.poisson(theta[:, 0])

    return task(simulator, prior={"mean": (low, high)}, features=[feature], name=name)


def normal(
    feature: str, name: str, mean: tuple[float, float], sd: tuple[float, float], step: float = 0, log: bool = False
) -> Task:
    """Return a task in which a value, or its logarithm, is normal, written in steps (as in the data)."""

    def simulator(theta: NDArray, rng: np.random.Generator) -> NDArray:
        x = rng.normal(theta[:, 0], theta[:, 1])
        x = np.exp(x) if log else x
        return step * np.rint(x / step) if step else x

    prior = {"mean": mean, "deviation": sd}
    return task(simulator, prior=prior, features=[feature], kinds={feature: "continuous"}, name=name)


def attendance(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Classes attended of 32, each with the same chance."""
    return rng.binomial(32, theta[:, 0])


def years(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Years of practice, as a negative binomial number."""
    return rng.poisson(theta[:, 0] * rng.gamma(theta[:, 1], 1 / theta[:, 1]))


def dishes(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Calories of a dish, by a gamma law."""
    return np.rint(theta[:, 0] * rng.gamma(theta[:, 1], 1 / theta[:, 1]))


def spells(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Days between two rains of a Poisson process, which are written in whole hours as days with two digits."""
    return np.round(np.ceil(24 * rng.exponential(theta[:, 0])) / 24, 2)


def margins(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Points by which a game departs from the bookmaker's spread, of which three in ten are given with a half."""
    half = 0.5 * (rng.random(len(theta)) < 0.29)
    return np.rint(rng.normal(theta[:, 0], theta[:, 1]) - half) + half


def tiles(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """How many of the five letters S one of two players draws."""
    return rng.binomial(5, theta[:, 0])


def binormal(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Two values of a normal law with a correlation."""
    u, v = rng.normal(size=(2, len(theta)))
    other = theta[:, 4] * u + np.sqrt(1 - theta[:, 4] ** 2) * v
    return np.column_stack([theta[:, 0] + theta[:, 1] * u, theta[:, 2] + theta[:, 3] * other])


def chests(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A man's chest across and shoulders around in centimetres, measured to a millimetre."""
    return np.round(binormal(theta, rng), 1)


def air(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Two pollutants of a day, each lognormal, in whole units."""
    return np.rint(np.exp(theta[:, [0, 2]] + theta[:, [1, 3]] * rng.normal(size=(len(theta), 2))))


CHILDREN = poisson("children", "children", 1, 5)
WOLVES = poisson("depredations", "depredations", 0.5, 5)
CLASSES = task(attendance, prior={"chance": (0.5, 0.95)}, features=["classes"], name="classes")
VISITS = poisson("visits", "prenatal-visits", 6, 18)
YEARS = task(years, prior={"mean": (3, 15), "shape": (0.5, 5)}, features=["years"], name="years-of-coding")
SCORES = normal("score", "inspections", (80, 105), (2, 15), step=1)
ONSET = normal("age", "onset", (15, 40), (4, 18), step=1)
MARRIAGE = normal("age", "marriage", (18, 30), (2, 8), step=1)
SALARIES = normal("salary", "salaries", (5.5, 9), (0.5, 2.5), log=True)
CALORIES = task(dishes, prior={"mean": (300, 900), "shape": (1, 8)}, features=["calories"], name="calories")
SPELLS = task(spells, prior={"days": (0.5, 5)}, features=["days"], name="dry-spells")
MARGINS = task(margins, prior={"bias": (-4, 4), "deviation": (6, 18)}, features=["error"], name="point-spreads")
TILES = task(tiles, prior={"chance": (0.2, 0.8)}, features=["letters"], name="tiles")
CHESTS = task(
    chests,
    prior={"across": (27, 33), "sd": (1, 4), "around": (105, 128), "deviation": (3, 12), "correlation": (0, 0.95)},
    features=["across", "around"],
    name="chests",
)
AIR = task(
    air,
    prior={"first": (3, 4.5), "sd": (0.1, 0.8), "second": (3, 4.5), "deviation": (0.2, 1)},
    features=["NO2", "PM10"],
    name="air",
)
RADAR = task(
    binormal,
    prior={"first": (-50, 50), "sd": (80, 500), "second": (-50, 50), "other": (80, 400), "correlation": (-0.6, 0.6)},
    features=["band1", "band2"],
    name="radar",
)


@case(CHILDREN, "single", right=("spread", "overdispersion"), defensible=("mixture", "zero_inflation"))
def children_of_botswana(rng: np.random.Generator) -> NDArray:
    """Children born to 4361 women of 15 to 49 years. A Poisson number has one mean for all, while it grows with age and
    falls with schooling: the variance is twice the mean (Wooldridge, Introductory Econometrics, data FERTIL2)."""
    return counts("children_botswana")


@case(WOLVES, "single", right=("threshold_loss", "overdispersion"), defensible=("spread", "mixture", "dead_time"))
def depredations_by_wolves(rng: np.random.Generator) -> NDArray:
    """Livestock lost to wolves on 434 farms of Minnesota. Only farms with a loss are in the list, so that there is no
    nought, and a few farms lose again and again (Harper et al. 2008, J. Wildlife Management 72, 778; Fox & Weisberg
    2019)."""
    return counts("wolf_depredations")


@case(CLASSES, "single", right=("spread", "overdispersion"), defensible=("mixture", "zero_inflation", "inefficiency"))
def classes_of_students(rng: np.random.Generator) -> NDArray:
    """Classes that 680 students attended of 32. The chance differs much from student to student, with marks and habits,
    so that the count is not binomial (Wooldridge, data ATTEND; Romer 1993, J. Econ. Perspectives 7, 167)."""
    return counts("classes_attended")


@case(VISITS, "single", right=("quantisation",), defensible=("readout_noise", "mixture"))
def visits_before_birth(rng: np.random.Generator) -> NDArray:
    """Visits of 1764 mothers to a doctor before birth, from birth certificates: a third is 12, and 10, 15, 20 and 30
    stand out, as numbers that are estimated are heaped (Wooldridge, data BWGHT2; Heitjan & Rubin 1991, Ann. Stat. 19,
    2244, on heaping)."""
    return counts("prenatal_visits")


@case(YEARS, "single", right=("censoring",), defensible=("mixture", "truncation", "threshold_loss"))
def coding_for_years(rng: np.random.Generator) -> NDArray:
    """Years for which 5594 programmers have coded in their job. The form of Stack Overflow's survey of 2017 ends with
    "20 or more", which is written as 20 (Kuhn & Johnson, data stackoverflow of modeldata)."""
    return counts("years_of_coding")


@case(SCORES, "single", right=("saturation",), defensible=("edge_acceptance", "peak_background", "radiative_tail"))
def scores_of_restaurants(rng: np.random.Generator) -> NDArray:
    """Scores of 1967 inspections of restaurants in Anchorage in 2009. No score is above 100, and a fifth is 100: a
    ceiling, which a normal law has not (Huntington-Klein 2021, The Effect; Tobin 1958, Econometrica 26, 24)."""
    return read("inspection_scores")


@case(ONSET, "single", right=("mixture",), defensible=("radiative_tail", "spread", "second_exponential"))
def onset_of_schizophrenia(rng: np.random.Generator) -> NDArray:
    """Age at which schizophrenia set in, 251 patients: an early and a late kind, the textbook's mixture of two normal
    laws (Everitt & Hothorn, Handbook of Statistical Analyses Using R, chapter on density; Levine 1981)."""
    return read("age_of_onset")


@case(MARRIAGE, "single", right=("radiative_tail",), defensible=("mixture", "spread", "edge_acceptance"))
def first_marriages(rng: np.random.Generator) -> NDArray:
    """Age of 5534 women at their first marriage (National Survey of Family Growth). It is skew: Coale & McNeil (1972,
    JASA 67, 743) describe it as a normal age of entering the market and exponential delays added to it."""
    return read("age_at_marriage")


@case(SALARIES, "single", right=("saturation", "edge_acceptance"), defensible=("peak_background", "mixture"))
def salaries_of_players(rng: np.random.Generator) -> NDArray:
    """Salaries of 828 baseball players in 2010 in thousands. The league's contract sets a least salary of 400, on and
    just above which a quarter of the players are: a lognormal law has no floor (OpenIntro, data mlb; Scully 1974, AER
    64, 915, on pay under the reserve)."""
    return read("player_salaries")


@case(CALORIES, "single", right=("quantisation",), defensible=())
def calories_of_fast_food(rng: np.random.Generator) -> NDArray:
    """Calories of 515 dishes of fast food. The rule for labels in the United States has them rounded to tens above 50
    (21 CFR 101.9(c)(1); OpenIntro, data fastfood)."""
    return read("calories")


@case(SPELLS, "single", right=("mixture", "spread", "second_exponential"), defensible=("peak_background",))
def spells_without_rain(rng: np.random.Generator) -> NDArray:
    """Days between 2042 rains at Winnipeg. Rain comes in clusters: short breaks within a storm and long ones between
    storms, two laws and not one (Rodriguez-Iturbe, Cox & Isham 1987, Proc. R. Soc. A 410, 269; DAAG, data droughts)."""
    return read("dry_spells")


@case(MARGINS)
def spreads_of_bookmakers(rng: np.random.Generator) -> NDArray:
    """By how much 553 games of college basketball depart from the spread: a normal error about nothing, as an efficient
    market has it (Stern 1991, American Statistician 45, 179; Wooldridge, data PNTSPRD)."""
    return read("point_spreads")


@case(TILES)
def letters_drawn_in_a_game(rng: np.random.Generator) -> NDArray:
    """How many of the five letters S a player drew in each of 444 games of Words With Friends: the tiles are drawn at
    random, about half of them by each player, and the count is binomial (Cannon et al. 2019, STAT2, data
    WordsWithFriends)."""
    return counts("letters_drawn")


@case(CHESTS)
def chests_of_active_men(rng: np.random.Generator) -> NDArray:
    """Chest and shoulders of 247 men who exercise: one sex, and a bivariate normal law (Heinz et al. 2003, J. Stat.
    Education 11(2))."""
    return read("chests_of_men")


@case(
    AIR,
    "single",
    right=("correlation", "correlation on NO2", "correlation on PM10"),
    defensible=("crosstalk on NO2", "crosstalk on PM10", "conditional_response on PM10", "conditional_response on NO2"),
)
def air_of_a_winter(rng: np.random.Generator) -> NDArray:
    """Highest nitrogen dioxide and dust of 532 winter days in Leeds: traffic and still air raise both, so that they are
    not independent (Heffernan & Tawn 2004, J. R. Stat. Soc. B 66, 497)."""
    return read("air_of_leeds")


@case(
    RADAR,
    "single",
    right=("outliers", "outliers on band1", "outliers on band2"),
    defensible=("radiative_tail on band1", "mixture", "spread", "flat_background"),
)
def radar_of_munich(rng: np.random.Generator) -> NDArray:
    """Two bands of 1573 pixels of a radar image of a suburb of Munich. A few pixels lie ten deviations off (Maronna,
    Martin & Yohai 2006, Robust Statistics, chapter 6)."""
    return read("radar_bands")


CASES: list[Case] = [c for c in tuple(globals().values()) if isinstance(c, Case)]
