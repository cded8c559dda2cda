"""Measured data of the earth and life sciences with an answer from the literature. Their sources are in README_c.md."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import poisson, whole_normal

Rng = np.random.Generator
read = reader(__file__)


def poisson_in_classes(theta: NDArray, rng: Rng) -> NDArray:
    """Return counts at one rate, of which the table joins those up to 2 and those from 17 on."""
    return np.clip(rng.poisson(theta[:, 0]), 2, 17)


def hundredths_normal(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to hundredths."""
    return np.round(rng.normal(theta[:, 0], theta[:, 1]), 2)


def tenths_exponential(theta: NDArray, rng: Rng) -> NDArray:
    """Return exponential values, rounded to tenths."""
    return np.round(rng.exponential(theta[:, 0]), 1)


STEPS = np.array([0, 0.06, 0.12, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5])
"""The values, in miles, that a report of visibility may have below 3 miles; from there on they are whole miles."""


def visible(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal visibilities, rounded down to what may be reported, up to any distance."""
    seen = np.minimum(theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta))), 1e6)
    return np.where(seen < 3, STEPS[np.searchsorted(STEPS, seen, side="right") - 1], np.floor(seen))


AMERICIUM = task(poisson_in_classes, prior={"rate": (3, 20)}, features=["particles"], name="americium")
SALAMANDERS = task(poisson, prior={"rate": (0.2, 8)}, features=["salamanders"], name="salamanders")
BABIES = task(
    hundredths_normal, prior={"mean": (5, 9), "width": (0.4, 3)}, features=["weight"], name="weights-of-newborns"
)
NEWARK = task(
    visible, prior={"median": (2, 100), "log_width": (0.3, 3)}, features=["visibility"], name="newark-visibility"
)
WAKA = task(tenths_exponential, prior={"mean": (5, 80)}, features=["diameter"], name="trunks-of-waka")
SHAPLEY = task(
    whole_normal, prior={"mean": (5000, 25000), "width": (500, 15000)}, features=["velocity"], name="shapley"
)


@case(AMERICIUM)
def particles_of_americium(rng: Rng) -> NDArray:
    """Alpha particles of americium 241 in 1207 intervals: they come by chance at one rate, as Poisson's law says.

    J. Berkson (1966), Examination of randomness of alpha particle emissions; J. Rice, Mathematical Statistics and Data
    Analysis, chapter 8, whose test of the fit finds nothing. The table joins the counts up to 2 and from 17 on, and
    so does the simulator.
    """
    return read("americium", counts=True)


@case(SALAMANDERS, "single", right=("zero_inflation", "overdispersion"), defensible=("mixture", "spread"))
def salamanders_below_mines(rng: Rng) -> NDArray:
    """Salamanders found in streams of Appalachia: below mines there are hardly any, and kinds differ in number.

    S. Price et al. (2016), J. Appl. Ecol. 53, 459; M. Brooks et al. (2017), bioRxiv 132753, who try negative
    binomial laws and extra zeros for them. Here Poisson's law has one rate for all.
    """
    return read("salamanders", counts=True)


@case(
    BABIES,
    "single",
    right=("radiative_tail", "mixture"),
    defensible=("second_exponential", "outliers", "flat_background", "peak_background", "spread"),
)
def newborns_of_a_year(rng: Rng) -> NDArray:
    """Weights at birth in the United States, 2014: normal, but for a few per cent born early, who are far lighter.

    A. Wilcox and I. Russell (1983), Int. J. Epidemiol. 12, 314: birth weights are a predominant normal law and a
    residual one in the lower tail. So a tail to one side tells it, or a second population.
    """
    return read("births14")


@case(
    NEWARK,
    "single",
    right=("saturation", "censoring"),
    defensible=("peak_background", "edge_acceptance", "truncation", "quantisation"),
)
def haze_over_newark(rng: Rng) -> NDArray:
    """Visibility at Newark airport in each hour of 2013: whatever is 10 miles or more is reported as 10 miles.

    The Automated Surface Observing System User's Guide (NOAA, 1998), where 10 miles stands for 10 and more. The
    simulator knows the steps that are reported below.
    """
    return read("visibility")


@case(WAKA, "single", right=("edge_acceptance", "truncation"), defensible=("offset", "analysis_window", "turn_on"))
def trunks_of_waka(rng: Rng) -> NDArray:
    """Diameters of trees in the forest of Waka, Gabon: those below 10 cm were not recorded, three excepted.

    M. Balinga et al. (2006), A vegetation assessment of the Waka national park. By the law of de Liocourt (1898)
    diameters in such a forest fall off exponentially from the smallest on, which the simulator says.
    """
    return read("waka")


@case(
    SHAPLEY,
    "single",
    right=("mixture",),
    defensible=("flat_background", "peak_background", "outliers", "radiative_tail", "second_exponential", "spread"),
)
def galaxies_beside_shapley(rng: Rng) -> NDArray:
    """Velocities of galaxies about the Shapley supercluster: many are of other groups, before it or behind.

    M. Drinkwater et al. (2004), Publ. Astron. Soc. Aust. 21, 89: of their galaxies those from 8000 to 18 000 km/s
    belong to it, and a third does not. The model has one normal population.
    """
    return read("shapley")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
