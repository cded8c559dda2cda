"""Measured data with an answer from the literature. Their sources are in data/README.md."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, reader
from paper.cases.laws import one_and_more, poisson, whole_normal

Rng = np.random.Generator
read = reader(__file__)


def of_five(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of five seeds are taken, each with the same chance."""
    return rng.binomial(5, theta[:, 0])


def whole_lognormal(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal values, rounded to whole units."""
    return np.round(theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta))))


def star_counts(theta: NDArray, rng: Rng) -> NDArray:
    """Return magnitudes up to 9.5, rounded to hundredths: stars become 10^slope times as many with each magnitude."""
    return np.round(9.5 + np.log10(1 - rng.random(len(theta))) / theta[:, 0], 2)


POINTS = np.array(
    [
        41.68,
        41.88,
        41.9,
        42.12,
        42.25,
        42.37,
        42.4,
        42.55,
        42.62,
        42.9,
        43.07,
        43.27,
        43.63,
        43.65,
        43.95,
        44.05,
        44.1,
        44.2,
        44.22,
        44.25,
        44.25,
        44.53,
        45.27,
        45.3,
        45.8,
        45.87,
        45.9,
        45.93,
        45.95,
        46.23,
        46.48,
        46.75,
        46.75,
        46.87,
        46.93,
        47.4,
        47.85,
        47.93,
        48.18,
    ]
)
"""True latitudes of the points that were looked up in the maps, in degrees."""


def map_latitudes(theta: NDArray, rng: Rng) -> NDArray:
    """Return latitudes of points as maps have them: with a shift and a normal error, to hundredths."""
    return np.round(rng.choice(POINTS, len(theta)) + rng.normal(theta[:, 0], theta[:, 1]), 2)


HITS = task(one_and_more, prior={"further": (3, 40), "shape": (0.4, 12)}, features=["weeks"], name="weeks-of-hits")
CHOIR = task(whole_normal, prior={"mean": (60, 75), "width": (1.5, 8)}, features=["height"], name="choir-heights")
SEEDS = task(of_five, prior={"chance": (0.005, 0.6)}, features=["taken"], name="seeds-on-trays")
TWEETS = task(
    whole_lognormal, prior={"median": (30, 250), "log_width": (0.2, 1.5)}, features=["length"], name="tweet-lengths"
)
CONES = task(poisson, prior={"rate": (10, 120)}, features=["cones"], name="fir-cones")
HIPPARCOS = task(star_counts, prior={"slope": (0.2, 0.9)}, features=["magnitude"], name="hipparcos-magnitudes")
MAPS = task(map_latitudes, prior={"shift": (-3, 3), "width": (0.1, 4)}, features=["latitude"], name="great-lakes-maps")


@case(
    HITS,
    "single",
    right=("censoring",),
    defensible=("quantisation", "heaping", "truncation", "flat_background", "mixture"),
)
def weeks_of_hits(rng: Rng) -> NDArray:
    """Weeks that songs of 2000 were in the Billboard Hot 100: a rule takes most of those off that reach week 20.

    A song that has had its 20 weeks and is below place 50 is removed as a recurrent one (Billboard, since 1991). So a
    quarter of the songs end at 20 weeks exactly, and only the best go on: a share of the counts beyond a limit reads
    the limit. Data: H. Wickham (2014), Tidy Data, J. Stat. Softw. 59(10).
    """
    return read("hot_hundred", counts=True)


@case(CHOIR, "single", right=("mixture",), defensible=("spread", "peak_background", "flat_background"))
def choir_of_high_and_low_voices(rng: Rng) -> NDArray:
    """Heights in inches of singers of the New York Choral Society: sopranos and altos are women, the others men.

    J. Chambers et al. (1983), Graphical Methods for Data Analysis; W. Cleveland (1993), Visualizing Data: heights are
    normal within a part, and their means go from 64 inches of sopranos to 71 of basses. Inches are whole, which the
    simulator knows.
    """
    return read("choir")


@case(SEEDS, "single", right=("zero_inflation",), defensible=("overdispersion", "mixture", "spread"))
def seeds_on_trays(rng: Rng) -> NDArray:
    """Seeds taken of five that were laid out in a forest of Uganda: no animal comes to most of the stations.

    B. Bolker (2008), Ecological Models and Data in R, who takes the zero-inflated binomial for these data of R. Duncan,
    as a seed may be safe because nobody has found the place. The events are those of one of the species of seeds.
    """
    return read("seeds", counts=True)


@case(
    TWEETS,
    "single",
    right=("saturation",),
    defensible=("censoring", "edge_acceptance", "truncation", "peak_background"),
)
def tweets_cut_to_fit(rng: Rng) -> NDArray:
    """Lengths of tweets of D. Trump before November 2017, in characters: what would be longer is cut to fit into 140.

    K. Gligoric, A. Anderson and R. West (2018), How Constraints Affect Content, ICWSM: lengths pile up just below the
    limit, as long messages are shortened to it rather than not sent. Without a limit lengths of messages are
    lognormal: P. Sobkowicz et al. (2013), EPJ Data Sci. 2, 2.
    """
    return read("tweets")


@case(CONES, "single", right=("overdispersion", "spread"), defensible=("mixture", "zero_inflation", "double_counting"))
def cones_of_firs(rng: Rng) -> NDArray:
    """Cones of single firs (Abies balsamea), summed over years: trees are of different size and on different ground.

    M. Dodd and J. Silvertown (2000), Heredity 85, 604; B. Bolker (2008), Ecological Models and Data in R, who takes
    a negative binomial about a power of the diameter: the rate differs from tree to tree.
    """
    return read("fir_cones", counts=True)


@case(
    HIPPARCOS,
    "single",
    right=("edge_acceptance",),
    defensible=("turn_on", "truncation", "forward_backward_acceptance"),
)
def stars_for_hipparcos(rng: Rng) -> NDArray:
    """Magnitudes up to 9.5 of the stars of Hipparcos: of faint ones only a part was chosen to be observed.

    The catalogue is complete to magnitude 7.3 to 9.0, depending on latitude and colour (ESA 1997, The Hipparcos and
    Tycho Catalogues, SP-1200). Counts of all stars rise as a power of ten of the magnitude, and these fall behind.
    """
    return read("hipparcos")


@case(MAPS, "single", right=("charge_misid",), defensible=("outliers", "flat_background", "mixture"))
def maps_of_the_great_lakes(rng: Rng) -> NDArray:
    """Latitudes of 39 points in eleven maps of 1688 to 1818: 34 of 429 got a minus sign in the printed table.

    D. Andrews and A. Herzberg (1985), Data, table 10.1; the description of OldMaps in the R package HistData calls
    them inexplicably negative, and an error of type setting. All points are north of the equator. The simulator knows
    the true latitudes of the points.
    """
    return read("old_maps")


CASES: list[Case] = [made for made in list(globals().values()) if isinstance(made, Case)]
