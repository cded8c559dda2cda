"""Measured data with an answer from the literature. Their sources are in README.md, and the files in data/."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import lognormal, negative_binomial, normal, one_and_more, poisson, whole_normal

Rng = np.random.Generator
read = reader(__file__)


EASE = np.array([2.730, 0.999, 0.240, 1.306, 2.099])
"""How easy the five items of Bock and Lieberman are, in logits."""


def rasch(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of five items somebody solves, whose ability is normal."""
    logit = theta[:, :1] + theta[:, 1:] * rng.standard_normal((len(theta), 1)) + EASE
    return (rng.random(logit.shape) < 1 / (1 + np.exp(-logit))).sum(axis=1)


def weibull_days(theta: NDArray, rng: Rng) -> NDArray:
    """Return times with a Weibull distribution, in days that have begun."""
    return np.ceil(theta[:, 0] * rng.weibull(theta[:, 1]))


def two_normals(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values with a correlation."""
    z = rng.standard_normal((2, len(theta)))
    second = theta[:, 4] * z[0] + np.sqrt(1 - theta[:, 4] ** 2) * z[1]
    return np.stack([theta[:, 0] + theta[:, 1] * z[0], theta[:, 2] + theta[:, 3] * second], axis=1)


def two_tenths(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values with a correlation, rounded to tenths."""
    return np.round(two_normals(theta, rng), 1)


def two_wholes(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values with a correlation, rounded to whole units."""
    return np.round(two_normals(theta, rng))


TEETH = task(poisson, prior={"rate": (0.5, 8)}, features=["teeth"], name="decayed-teeth")
NODES = task(negative_binomial, prior={"mean": (0.5, 12), "shape": (0.2, 6)}, features=["nodes"], name="lymph-nodes")
DRINKS = task(one_and_more, prior={"further": (0.3, 5), "shape": (0.15, 4)}, features=["drinks"], name="drinks")
ITEMS = task(rasch, prior={"ease": (-1, 1), "spread": (0, 2)}, features=["right"], name="law-items")
TREES = task(poisson, prior={"density": (1, 15)}, features=["trees"], name="trees-in-squares")
CURRENTS = task(normal, prior={"mean": (4, 20), "width": (1, 10)}, features=["current"], name="currents")
MELANOMA = task(
    lognormal, prior={"median": (0.5, 6), "log_width": (0.4, 2)}, features=["thickness"], name="melanoma-thickness"
)
FIBROSIS = task(weibull_days, prior={"scale": (40, 1200), "shape": (0.5, 2.5)}, features=["days"], name="exacerbations")
SKINFOLD = task(whole_normal, prior={"mean": (10, 45), "width": (4, 30)}, features=["skinfold"], name="skinfold")
FILMS = task(whole_normal, prior={"mean": (50, 130), "width": (8, 60)}, features=["length"], name="film-lengths")
NOX = task(lognormal, prior={"median": (5, 60), "log_width": (0.2, 1.5)}, features=["nox"], name="nitrogen-oxides")
POUND = task(normal, prior={"mean": (-0.2, 0.2), "width": (0.2, 1)}, features=["change"], name="mark-and-pound")
NOTES = task(
    two_tenths,
    prior={"margin": (8, 11), "width": (0.5, 3), "diagonal": (138, 143), "spread": (0.4, 3), "tie": (-0.95, 0.95)},
    features=["margin", "diagonal"],
    name="bank-notes",
)
MEN = task(
    two_tenths,
    prior={"forearm": (24, 33), "width": (0.8, 4), "wrist": (14, 20), "spread": (0.4, 2.5), "tie": (-0.95, 0.95)},
    features=["forearm", "wrist"],
    name="girths-of-men",
)
DRIVE = task(
    two_wholes,
    prior={"speed": (70, 110), "width": (10, 40), "height": (60, 72), "spread": (2, 7), "tie": (-0.8, 0.8)},
    features=["speed", "height"],
    name="fastest-drive",
)


@case(TEETH, "single", right=("zero_inflation",), defensible=("mixture", "overdispersion", "spread"))
def decayed_teeth(rng: Rng) -> NDArray:
    """Decayed, missing and filled milk teeth of children in Belo Horizonte: far too many children have none.

    D. Boehning et al. (1999), The zero-inflated Poisson model and the decayed, missing and filled teeth index in
    dental epidemiology, J. R. Stat. Soc. A 162, 195: the textbook's example of excess zeros.
    """
    return read("decayed_teeth", counts=True)


@case(NODES, "single", right=("threshold_loss",))
def lymph_nodes(rng: Rng) -> NDArray:
    """Lymph nodes with cancer, in a trial of women whose nodes were positive: those with none are not in it.

    M. Schumacher et al. (1994), J. Clin. Oncol. 12, 2086 (German Breast Cancer Study Group): zero is truncated.
    """
    return read("lymph_nodes", counts=True)


@case(DRINKS, "single", right=("quantisation",), defensible=("mixture", "flat_background", "overdispersion", "spread"))
def drinks_in_a_day(rng: Rng) -> NDArray:
    """Drinks on a day on which somebody drinks, as told: 6 comes far more often than 5, as do 8, 10, 12, 15 and 24.

    NESARC, wave 1 (2001); on heaping in such numbers R. Klesges et al. (1995), J. Clin. Epidemiol. 48, 1225, and
    H. Wang and D. Heitjan (2008), Stat. Med. 27, 3789.
    """
    return read("drinks", counts=True)


@case(ITEMS)
def law_school_items(rng: Rng) -> NDArray:
    """Items solved of the five of section 6 of the Law School Admission Test: the model of Rasch describes them.

    R. Bock and M. Lieberman (1970), Psychometrika 35, 179; D. Rizopoulos (2006), J. Stat. Softw. 17(5), who fits it
    to these data, and whose test of the fit finds nothing.
    """
    return read("law_items", counts=True)


@case(TREES, "single", right=("overdispersion", "spread"), defensible=("mixture", "zero_inflation", "double_counting"))
def trees_in_squares(rng: Rng) -> NDArray:
    """Trees of Beilschmiedia pendula in squares of 25 m on Barro Colorado: they stand in clumps and follow the ground.

    R. Condit et al. (2000), Science 288, 1414; J. Moeller and R. Waagepetersen (2007), Scand. J. Stat. 34, 643.
    """
    return read("trees_in_squares", counts=True)


@case(
    CURRENTS,
    "single",
    right=("mixture",),
    defensible=("peak_background", "radiative_tail", "second_exponential", "spread", "flat_background"),
)
def currents_in_quanta(rng: Rng) -> NDArray:
    """Spontaneous currents in cells of the thalamus of guinea pigs: of one quantum mostly, and of two or more.

    O. Paulsen and P. Heggelund (1994), J. Physiol. 480, 505; A. Davison and D. Hinkley (1997), Bootstrap Methods,
    who ask how many modes there are.
    """
    return read("currents")


@case(MELANOMA, "single", right=("quantisation",))
def melanoma_thickness(rng: Rng) -> NDArray:
    """Thicknesses of melanomas in Odense: 0.16, 0.32, 0.48, 0.65, ..., 1.29 mm are steps of the scale in the eyepiece.

    P. Andersen et al. (1993), Statistical Models Based on Counting Processes; on how such values are rounded L. Ge et
    al. (2016), Ann. Surg. Oncol. 23, 2658.
    """
    return read("melanoma")


@case(FIBROSIS, "single", right=("saturation",), defensible=("peak_background", "edge_acceptance"))
def days_to_an_exacerbation(rng: Rng) -> NDArray:
    """Days to a first exacerbation in cystic fibrosis: the trial ended after 24 weeks, and 6 in 10 are censored there.

    H. Fuchs et al. (1994), N. Engl. J. Med. 331, 637; T. Therneau and P. Grambsch (2000), Modeling Survival Data.
    """
    return read("cystic_fibrosis")


@case(SKINFOLD, "single", right=("peak_background",), defensible=("outliers", "mixture"))
def skinfold_of_nothing(rng: Rng) -> NDArray:
    """Folds of skin of Pima women: 227 of 768 are 0 mm, which is how a value that was not measured was written.

    J. Breault (2001), Data mining diabetic databases: are rough sets a useful addition?, Comput. Sci. Stat. 33; the
    corrected data are PimaIndiansDiabetes2 of mlbench.
    """
    return read("skinfold")


@case(
    FILMS,
    "single",
    right=("mixture", "peak_background"),
    defensible=("second_exponential", "flat_background", "quantisation", "outliers"),
)
def films_long_and_short(rng: Rng) -> NDArray:
    """Lengths of films: beside those of an hour and a half there are the short ones, of 7 minutes mostly.

    H. Wickham, R package ggplot2movies; A. Unwin (2015), Graphical Data Analysis with R, chapter 3.
    """
    return read("film_lengths")


@case(NOX)
def nitrogen_oxides(rng: Rng) -> NDArray:
    """Nitrogen oxides in the air of Altdorf, means of the days of 2004: lognormal, as air pollution is said to be.

    R. Larsen (1971), A Mathematical Model for Relating Air Quality Measurements to Air Quality Standards; W. Ott
    (1990), J. Air Waste Manage. Assoc. 40, 1378.
    """
    return read("nitrogen_oxides")


@case(POUND, "single", right=("spread", "outliers"), defensible=("mixture", "second_exponential", "radiative_tail"))
def mark_and_pound(rng: Rng) -> NDArray:
    """Changes of the pound in marks from day to day, 1984 to 1991: the width of the normal law varies with time.

    T. Bollerslev and E. Ghysels (1996), J. Bus. Econ. Stat. 14, 139: the benchmark of models of such a width.
    """
    return read("mark_pound")


@case(NOTES, "single", right=("mixture",), defensible=("peak_background", "conditional_response"))
def bank_notes_of_a_forger(rng: Rng) -> NDArray:
    """Lower margin and diagonal of Swiss bank notes of 1000 francs: half of them are forged, and smaller inside.

    B. Flury and H. Riedwyl (1988), Multivariate Statistics.
    """
    return read("bank_notes")


@case(MEN)
def girths_of_men(rng: Rng) -> NDArray:
    """Girths of the forearms and the wrists of 247 active men, which are normal and go together.

    G. Heinz, L. Peterson, R. Johnson and C. Kerk (2003), J. Stat. Educ. 11(2).
    """
    return read("men")


@case(DRIVE, "single", right=("quantisation on speed",), defensible=("outliers on speed", "mixture", "peak_background"))
def fastest_drive(rng: Rng) -> NDArray:
    """The fastest that students say they have driven, with their height: mostly a multiple of five or ten miles.

    M. Cetinkaya-Rundel et al., OpenIntro Statistics; some never drove, and say 0. The heights are in whole inches,
    which the simulator knows.
    """
    return read("fastest_drive")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
