"""Measured data with an answer from the literature. Their sources are in README.md, and the files in data/."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import normal, poisson

Rng = np.random.Generator
read = reader(__file__)


def normal_hundredths(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to hundredths."""
    return np.round(normal(theta, rng), 2)


def full_years(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal ages in full years."""
    return np.floor(normal(theta, rng))


def whole_pounds(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal values above a least one, rounded to whole units."""
    return np.round(theta[:, 0] + theta[:, 1] * np.exp(theta[:, 2] * rng.standard_normal(len(theta))))


def power(theta: NDArray, rng: Rng) -> NDArray:
    """Return values between 0 and 1 whose density is a power."""
    return (1 - rng.random(len(theta))) ** (1 / theta[:, 0])


def growth(theta: NDArray, rng: Rng) -> NDArray:
    """Return a week from 1 to 12 and a weight about a curve that bends, of one width, rounded to tenths."""
    week = rng.integers(1, 13, len(theta))
    mean = theta[:, 0] + theta[:, 1] * (week - 1) + theta[:, 2] * (week - 1) ** 2
    return np.stack([week, np.round(rng.normal(mean, theta[:, 3]), 1)], axis=1)


def two_alone(theta: NDArray, rng: Rng) -> NDArray:
    """Return two normal values that have nothing to do with each other."""
    return np.stack([rng.normal(theta[:, 0], theta[:, 1]), rng.normal(theta[:, 2], theta[:, 3])], axis=1)


POLONIUM = task(poisson, prior={"rate": (1, 10)}, features=["scintillations"], name="polonium")
FRUITS = task(poisson, prior={"rate": (2, 150)}, features=["fruits"], name="thale-cress")
INFARCTS = task(full_years, prior={"mean": (45, 90), "width": (3, 25)}, features=["age"], name="infarcts")
PUPILS = task(
    whole_pounds,
    prior={"least": (0, 90), "above": (20, 180), "log_width": (0.1, 1)},
    features=["weight"],
    name="weights-of-pupils",
)
CHOICES = task(normal_hundredths, prior={"mean": (0.3, 4), "width": (0.1, 2)}, features=["time"], name="choices")
CORAL = task(power, prior={"power": (0.1, 1.5)}, features=["p"], name="genes-of-coral")
PIGS = task(
    growth,
    prior={"start": (10, 40), "gain": (1, 12), "bend": (-0.4, 0.4), "width": (1, 20)},
    features=["week", "weight"],
    name="pigs",
)
WIND = task(
    two_alone,
    prior={"dublin": (1, 6), "width": (0.2, 2), "mullingar": (1, 6), "spread": (0.2, 2)},
    features=["dublin", "mullingar"],
    name="irish-wind",
)


@case(POLONIUM)
def scintillations_of_polonium(rng: Rng) -> NDArray:
    """Scintillations of polonium in each eighth of a minute: decays come by chance, and obey the law of Poisson.

    E. Rutherford and H. Geiger, with a note by H. Bateman (1910), Philos. Mag. 20, 698; W. Feller (1968), An
    Introduction to Probability Theory and Its Applications, vol. 1, VI.7, whose test of the fit finds nothing.
    """
    return read("scintillations", counts=True)


@case(FRUITS, "single", right=("overdispersion",), defensible=("mixture", "zero_inflation", "flat_background"))
def fruits_of_thale_cress(rng: Rng) -> NDArray:
    """Fruits of plants of Arabidopsis of 24 lines, fed or not and clipped or not: far more spread than by chance.

    J. Banta, M. Stevens and M. Pigliucci (2010), Oikos 119, 359; B. Bolker et al. (2009), Trends Ecol. Evol. 24, 127,
    who give each plant a rate of its own, as Poisson's law fails.
    """
    return read("thale_cress", counts=True)


@case(INFARCTS, "single", right=("edge_acceptance", "truncation", "analysis_window"))
def ages_of_women_with_infarcts(rng: Rng) -> NDArray:
    """Ages of women at a heart attack, in full years: the register takes those of 35 to 69, and most are older.

    Newcastle centre of the WHO MONICA project; The WHO MONICA Study, Australia, 1984-1993 (Australian Institute of
    Health and Welfare, 2000). The ages end at 69, the commonest one. A cut at one end and a window are both right.
    """
    return read("infarcts")


@case(PUPILS, "single", right=("quantisation", "heaping"))
def weights_of_pupils(rng: Rng) -> NDArray:
    """Weights that pupils of high schools tell, in pounds: those that end in 0 or 5 are more than half of all.

    N. Brener et al. (2004), Methodology of the Youth Risk Behavior Surveillance System, MMWR 53 (RR-12); on how people
    round their weight M. Rowland (1990), Am. J. Clin. Nutr. 52, 1125. The simulator knows that pounds are whole.
    """
    return read("pupils")


@case(
    CHOICES,
    "single",
    right=("radiative_tail",),
    defensible=("second_exponential", "mixture", "spread", "outliers", "edge_acceptance"),
)
def times_of_hard_choices(rng: Rng) -> NDArray:
    """Seconds in which patients with Parkinson's disease choose one of two signs: some choices take far longer.

    J. Cavanagh et al. (2011), Nat. Neurosci. 14, 1462. A time of reaction is the sum of a normal one and an
    exponential one: R. Luce (1986), Response Times. So the normal law lacks a tail to one side.
    """
    return read("choices")


@case(
    CORAL,
    "single",
    right=("flat_background", "mixture"),
    defensible=("spread", "peak_background", "second_exponential"),
)
def genes_of_young_coral(rng: Rng) -> NDArray:
    """P-values of genes, of coral before and after it settles: those of genes that do not change are uniform.

    L. Grasso et al. (2008), BMC Genomics 9, 540; S. Pounds and S. Morris (2003), Bioinformatics 19, 1236, who describe
    p-values by a power and a uniform part. The power 1 is uniform, so a mixture of two powers says the same.
    """
    return read("coral")


@case(
    PIGS,
    "single",
    right=("conditional_response on weight", "spread on gain"),
    defensible=("spread", "mixture", "resolution on weight", "scale on weight"),
)
def pigs_that_grow_apart(rng: Rng) -> NDArray:
    """Weights of pigs in 12 weeks: each has its own gain a week, so the weights spread more the later it is.

    C. Lauridsen, S. Hoejsgaard and M. Soerensen (1999), J. Anim. Sci. 77, 906; such a gain of its own is in P. Diggle
    et al. (2002), Analysis of Longitudinal Data. The weeks are those of the plan, and the mean may bend.
    """
    return read("pigs")


@case(WIND, "single", right=("correlation",), defensible=("crosstalk", "spread", "conditional_response", "mixture"))
def wind_of_two_stations(rng: Rng) -> NDArray:
    """Roots of the daily mean wind in Dublin and in Mullingar, 1961 to 1978: each is normal, but they rise together.

    J. Haslett and A. Raftery (1989), Appl. Stat. 38, 1, who take the root to make them normal, and model how the
    stations go together, as they have the same weather. The simulator takes each by itself.
    """
    return read("irish_wind")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
