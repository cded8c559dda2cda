"""Measured data with an answer from the literature. Their sources are in data/README_a.md, and the files in data/."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import lognormal, normal, whole_normal

Rng = np.random.Generator
read = reader(__file__)


def alleles(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of the two genes of a person are N, where both are drawn from one pool: Hardy and Weinberg."""
    return rng.binomial(2, theta[:, 0])


def poisson_without_zeros(theta: NDArray, rng: Rng) -> NDArray:
    """Return Poisson counts of which those of nothing are not in the table.

    The first event comes at a time that is exponential and below 1; the others fall into the time that is left.
    """
    rate = theta[:, 0]
    first = -np.log1p(rng.random(len(rate)) * np.expm1(-rate)) / rate
    return 1 + rng.poisson(rate * np.clip(1 - first, 0, 1))


def gutenberg_richter(theta: NDArray, rng: Rng) -> NDArray:
    """Return magnitudes that fall off exponentially, to hundredths; those of 2.50 and more are in the table."""
    return np.round(2.495 + rng.exponential(1 / (np.log(10) * theta[:, 0])), 2)


def two_enzymes(theta: NDArray, rng: Rng) -> NDArray:
    """Return logarithms of two lognormal values that have nothing to do with each other, read in whole units."""
    z = theta[:, [0, 2]] + theta[:, [1, 3]] * rng.standard_normal((len(theta), 2))
    return np.log(np.maximum(np.round(np.exp(z)), 1))


def blades(theta: NDArray, rng: Rng) -> NDArray:
    """Return a lognormal length, and a width on a straight line of it, with one error for all."""
    length = lognormal(theta, rng)
    width = theta[:, 2] + theta[:, 3] * length + theta[:, 4] * rng.standard_normal(len(theta))
    return np.stack([length, width], axis=1)


BLOOD = task(alleles, prior={"share_of_n": (0.05, 0.95)}, features=["n_genes"], name="mn-blood-groups")
CORMORANTS = task(poisson_without_zeros, prior={"rate": (0.3, 15)}, features=["birds"], name="cormorants")
RIDGECREST = task(gutenberg_richter, prior={"b": (0.4, 2.5)}, features=["shock_magnitude"], name="ridgecrest")
VIRUS = task(normal, prior={"mean": (0, 14), "width": (0.5, 8)}, features=["log_load"], name="viral-loads")
PRESSURE = task(whole_normal, prior={"mean": (90, 180), "width": (8, 70)}, features=["systolic"], name="icu-pressures")
NUCLEI = task(lognormal, prior={"median": (8, 24), "log_width": (0.05, 0.8)}, features=["radius"], name="cell-nuclei")
LIVER = task(
    two_enzymes,
    prior={"alt": (1.5, 4.5), "alt_width": (0.1, 1.2), "ast": (1.5, 4.5), "ast_width": (0.1, 1.2)},
    features=["log_alt", "log_ast"],
    name="liver-enzymes",
)
BLADES = task(
    blades,
    prior={"median": (3, 30), "log_width": (0.2, 1.5), "start": (-4, 6), "slope": (0.02, 1.2), "error": (0.3, 12)},
    features=["length", "width"],
    name="leaf-blades",
)


@case(BLOOD)
def genes_for_m_and_n(rng: Rng) -> NDArray:
    """Blood groups M, MN and N of 1000 Britons, as genes for N in each: the law of Hardy and Weinberg holds.

    T. Cleghorn (1960); D. Hartl, A Primer of Population Genetics, has it as the example of a population in which
    298, 489 and 213 people are observed where 294.3, 496.4 and 209.3 are expected.
    """
    return read("blood_groups", counts=True)


@case(
    CORMORANTS,
    "single",
    right=("overdispersion", "spread"),
    defensible=("mixture", "double_counting", "flat_background"),
)
def cormorants_that_advertise(rng: Rng) -> NDArray:
    """Male cormorants that court, counted at six stations from April to July: the rate differs by week and by place.

    M. McRae (2015), in the R package vcdExtra. Courting ends as the chicks hatch, and low, full or dead trees have
    fewer birds, so one rate is too few. Kinds of trees without a bird are not in the table, which the simulator knows.
    """
    return read("cormorants", counts=True)


@case(
    RIDGECREST,
    "single",
    right=("edge_acceptance", "turn_on"),
    defensible=("forward_backward_acceptance", "truncation"),
)
def aftershocks_at_ridgecrest(rng: Rng) -> NDArray:
    """Magnitudes in the week after the earthquake of 6 July 2019 in California: many small aftershocks are missing.

    The list begins minutes after the main shock, as waves of large shocks hid the small ones, so that events towards
    the lower end are found less often. Y. Kagan (2004), Short-term properties of earthquake catalogs, Bull. Seismol.
    Soc. Am. 94, 1207; Y. Ogata and K. Katsura (1993), Geophys. J. Int. 113, 727: the law times an error function.
    """
    return read("ridgecrest")


@case(
    VIRUS,
    "single",
    right=("saturation", "censoring"),
    defensible=("peak_background", "mixture", "outliers"),
)
def virus_too_rare_to_be_seen(rng: Rng) -> NDArray:
    """Logarithms of HIV in the blood of patients in New York: 0 stands for a load below what the test can detect.

    P. Messeri et al. (2003), Med. Care 41, 512; Y.-S. Su et al. (2011), J. Stat. Softw. 45(2). On loads that are
    censored at the limit of detection J. Hughes (1999), Biometrics 55, 625.
    """
    return read("viral_load")


@case(PRESSURE, "single", right=("quantisation", "heaping"))
def pressures_in_intensive_care(rng: Rng) -> NDArray:
    """Systolic blood pressures on admission to intensive care: nurses write even numbers, and tens most of all.

    S. Lemeshow et al. (1988), J. Am. Stat. Assoc. 83, 348. The scale of a mercury column has steps of 2 mmHg, and
    readers prefer the digit 0: P. Hessel (1986), Int. J. Epidemiol. 15, 122. The simulator rounds to whole mmHg.
    """
    return read("intensive_care")


@case(
    NUCLEI,
    "single",
    right=("mixture",),
    defensible=("peak_background", "second_exponential", "radiative_tail", "spread", "flat_background"),
)
def nuclei_of_two_sorts_of_lumps(rng: Rng) -> NDArray:
    """Mean radii of the nuclei of cells out of lumps in the breast: 357 lumps are benign, and 212 malignant and larger.

    W. Street, W. Wolberg and O. Mangasarian (1993), Proc. SPIE 1905, 861: size is among what tells the two apart.
    """
    return read("nuclei")


@case(LIVER, "single", right=("correlation",), defensible=("crosstalk", "conditional_response"))
def enzymes_of_one_liver(rng: Rng) -> NDArray:
    """Logarithms of two enzymes in the blood before a trial: both leak from the same liver, so they rise together.

    H. Southworth and J. Heffernan (2012), Pharm. Stat. 11, 367, who model ALT and AST jointly. The simulator draws
    each by itself: what it lacks is that they share a part that varies from patient to patient.
    """
    return np.log(read("liver_enzymes"))


@case(
    BLADES,
    "single",
    right=("conditional_response on width", "spread on slope"),
    defensible=("resolution on width", "spread", "mixture", "outliers on width"),
)
def breadths_of_leaves(rng: Rng) -> NDArray:
    """Lengths and widths of leaves of trees from Borneo to Tasmania: the longer a leaf, the more its width scatters.

    D. King and J. Maindonald (1999), J. Ecol. 87, 1012; J. Maindonald and J. Braun, Data Analysis and Graphics Using
    R, take logarithms because of that. The simulator has one error for all leaves, about a straight line.
    """
    return read("leaves")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
