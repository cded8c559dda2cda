"""Measured data of the earth and life sciences, with an answer that was written down first. Sources: data/README.md."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import negative_binomial, poisson

Rng = np.random.Generator
read = reader(__file__)


def activity(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal activities, rounded to tenths; what is rounded to nothing is written as a tenth."""
    return np.maximum(np.round(theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta))), 1), 0.1)


def weight(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal weights, rounded to hundredths."""
    return np.round(rng.normal(theta[:, 0], theta[:, 1]), 2)


def two_temperatures(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal temperatures with a correlation, rounded to tenths."""
    z = rng.standard_normal((2, len(theta)))
    second = theta[:, 4] * z[0] + np.sqrt(1 - theta[:, 4] ** 2) * z[1]
    return np.round(np.stack([theta[:, 0] + theta[:, 1] * z[0], theta[:, 2] + theta[:, 3] * second], axis=1), 1)


def two_pressures(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal pressures that have nothing to do with each other, in whole mmHg."""
    return np.round(theta[:, [0, 2]] + theta[:, [1, 3]] * rng.standard_normal((len(theta), 2)))


CHILDREN = task(
    negative_binomial,
    prior={"mean": (0.5, 6), "shape": (0.3, 10)},
    features=["children"],
    name="children-of-bangladesh",
)
CANES = task(poisson, prior={"density": (0.3, 8)}, features=["canes"], name="bramble-canes")
RADON = task(
    activity, prior={"median": (0.5, 15), "log_width": (0.2, 2)}, features=["radon"], name="radon-of-minnesota"
)
MICE = task(weight, prior={"mean": (20, 50), "width": (1.5, 15)}, features=["weight"], name="weights-of-mice")
SEATTLE = task(
    two_temperatures,
    prior={"highest": (0, 18), "width": (1, 9), "lowest": (-5, 12), "spread": (1, 9), "tie": (-0.95, 0.95)},
    features=["highest", "lowest"],
    name="winters-of-seattle",
)
PRESSURES = task(
    two_pressures,
    prior={"systolic": (100, 190), "width": (10, 70), "diastolic": (50, 110), "spread": (7, 45)},
    features=["systolic", "diastolic"],
    name="heart-attack-pressures",
)


@case(CHILDREN, "single", right=("censoring",), defensible=("saturation",))
def children_of_bangladesh(rng: Rng) -> NDArray:
    """Living children of women in Bangladesh, 1988: the file has 0, 1, 2, and 3 for three or more, so it is censored.

    N. Huq and J. Cleland (1990), Bangladesh Fertility Survey 1989; D. Bates, R package mlmRev, Contraception, where the
    levels are 0, 1, 2 and 3+. Counts beyond a limit are recorded as the limit.
    """
    return read("children_of_bangladesh", counts=True)


@case(CANES, "single", right=("overdispersion", "spread"), defensible=("mixture", "zero_inflation", "double_counting"))
def bramble_canes(rng: Rng) -> NDArray:
    """Canes of bramble in squares of 45 cm: they grow in clumps, so their density differs from square to square.

    M. Hutchings (1979), Oikos 31, 349; P. Diggle (1983), Statistical Analysis of Spatial Point Patterns, who finds that
    they are clustered; A. Davison and D. Hinkley (1997), Bootstrap Methods.
    """
    return read("bramble_canes", counts=True)


@case(RADON)
def radon_of_minnesota(rng: Rng) -> NDArray:
    """Radon in houses of Minnesota, pCi/l: it is lognormal, as indoor radon is nearly everywhere.

    A. Nero et al. (1986), Science 234, 992; P. Price, A. Nero and A. Gelman (1996), Health Phys. 71, 922, who take it
    as lognormal. The simulator rounds to tenths as the file does.
    """
    return read("radon_of_minnesota")


@case(
    MICE, "single", right=("mixture",), defensible=("second_exponential", "radiative_tail", "peak_background", "spread")
)
def mice_of_both_sexes(rng: Rng) -> NDArray:
    """Weights of grown mice that were fed chow: 200 females and 194 males, and males are heavier by a good deal.

    R. Irizarry, R package dslabs, mice_weights: the sexes differ in mean and in width, so one normal law is two. The
    ratio of the sexes is near one to one, so neither is a background of the other.
    """
    return read("mice_of_both_sexes")


@case(SEATTLE, "single", right=("quantisation",))
def winters_of_seattle(rng: Rng) -> NDArray:
    """Highest and lowest temperatures of winter days in Seattle: read in whole degrees Fahrenheit, and then converted.

    NOAA, Global Historical Climatology Network, in vega_datasets; on such steps X. Zhang, F. Zwiers and G. Hegerl
    (2009), Int. J. Climatol. 29, 321. They are 5/9 of a degree Celsius; the simulator rounds to tenths alone.
    """
    return read("seattle_winters")


@case(
    PRESSURES,
    "single",
    right=("correlation",),
    defensible=("crosstalk", "conditional_response", "mixture", "spread"),
)
def pressures_at_a_heart_attack(rng: Rng) -> NDArray:
    """Systolic and diastolic blood pressure of patients with a heart attack: they go together, which the model lacks.

    D. Hosmer, S. Lemeshow and S. May (2008), Applied Survival Analysis, Worcester Heart Attack Study. On the tie of the
    two B. Gavish, I. Ben-Dov and M. Bursztyn (2008), J. Hypertens. 26, 199. Each is normal, and in whole mmHg.
    """
    return read("heart_attack_study")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
