"""Simulated cases of counts: plankton, visits to a website, seedlings, arrivals at a hospital."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def cells(theta: NDArray, rng: Rng) -> NDArray:
    """Return the cells of plankton in a counting chamber of 1 ml, well stirred."""
    return rng.poisson(theta[:, 0])


def pages(theta: NDArray, rng: Rng) -> NDArray:
    """Return the pages seen in a visit: the first, and a negative binomial number of further ones."""
    return 1 + rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1]))


def emerged(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many of the 40 seeds in a tray come up."""
    return rng.binomial(40, theta[:, 0])


def patients(theta: NDArray, rng: Rng) -> NDArray:
    """Return the patients that arrive in an hour, of a day whose rate goes up and down."""
    return rng.poisson(theta[:, 0] * (1 + theta[:, 1] * np.sin(2 * np.pi * rng.random(len(theta)))))


PLANKTON = task(cells, prior={"density": (4, 60)}, features=["cells"], name="plankton")
VISITS = task(pages, prior={"further": (1, 12), "shape": (0.4, 6)}, features=["pages"], name="website-visits")
SEEDLINGS = task(emerged, prior={"chance": (0.2, 0.9)}, features=["seedlings"], name="seedlings")
ARRIVALS = task(patients, prior={"rate": (2, 30), "swing": (0, 0.8)}, features=["arrivals"], name="hospital-arrivals")


@case(PLANKTON, "single", right=("double_counting",), defensible=("overdispersion", "spread", "mixture", "pile_up"))
def plankton_dividing(rng: Rng) -> NDArray:
    """Cells that are about to divide are read as two by the camera, and one in six of those as three.

    In most chambers 12 % divide, but 40 % of them in samples of the late night, when the cells divide together.
    """
    n = 900
    x = one(PLANKTON, rng, n, 19.0)
    twice = rng.binomial(x, np.where(some(rng, n, 0.3), 0.4, 0.12))
    return x + twice + rng.binomial(twice, 1 / 6)


@case(PLANKTON, "pair", right=("quantisation", "overdispersion"), defensible=("spread", "mixture"))
def plankton_patches_and_tens(rng: Rng) -> NDArray:
    """Plankton is patchy: the density varies as a skewed Weibull. Counts above 30 are mostly written down in fives.

    Half of those above 60 are written as tens.
    """
    n = 3300
    x = rng.poisson(34 * (0.55 + 0.45 * rng.weibull(1.6, n)))
    x = np.where((x > 30) & some(rng, n, 0.7), 5 * np.round(x / 5), x)
    return np.where((x > 60) & some(rng, n, 0.5), 10 * np.round(x / 10), x).astype(int)


@case(VISITS, "single", right=("truncation",))
def visits_of_robots_dropped(rng: Rng) -> NDArray:
    """Visits of many pages are taken for those of robots and dropped: nine in ten above 24, all above 40.

    Between 18 and 24 pages a slower rule drops one in five.
    """
    x = one(VISITS, rng, 7600, 7.5, 1.1)
    lost = np.select([x > 40, x > 24, x > 18], [1.0, 0.9, 0.2], 0.0)
    return x[rng.random(len(x)) > lost]


@case(VISITS, "single", right=("censoring",))
def visits_of_twelve_and_more(rng: Rng) -> NDArray:
    """The yearly table ends with "12 and more", written as 12; an older table, of a quarter, with "15 and more"."""
    x = one(VISITS, rng, 1900, 5.2, 1.4)
    return np.minimum(x, np.where(some(rng, len(x), 0.25), 15, 12))


@case(VISITS, "pair", right=("threshold_loss", "flat_background"), defensible=("mixture", "overdispersion", "spread"))
def visits_without_bounces_with_crawlers(rng: Rng) -> NDArray:
    """Visits of one page end before the script has loaded: 85 % are not recorded, and of two pages 15 %.

    Crawlers, 6 % of what is recorded, see anything between 1 and 90 pages.
    """
    n = 9000
    x = one(VISITS, rng, n, 5.0, 1.6)
    x = x[rng.random(n) > np.select([x == 1, x == 2], [0.85, 0.15], 0.0)]
    return np.where(some(rng, len(x), 0.06), rng.integers(1, 91, len(x)), x)


@case(VISITS, "outside")
def visits_cut_in_halves(rng: Rng) -> NDArray:
    """The clock of a visit runs out: each visit of 15 pages or more is recorded as two visits, each of about a half.

    A long visit is neither lost nor recorded as a limit, but comes back as two events in the middle of the others.
    """
    x = one(VISITS, rng, 9500, 9.0, 1.8)
    long = x[x >= 15]
    cut = rng.binomial(long, 0.5)
    both = np.concatenate([x[x < 15], cut, long - cut])
    return rng.permutation(both[both > 0])


@case(SEEDLINGS, "single", right=("overdispersion", "spread"), defensible=("mixture",))
def seedlings_damped_off(rng: Rng) -> NDArray:
    """The chance to come up differs from tray to tray with the damp, and has a long tail of bad trays."""
    return rng.binomial(40, 0.84 * rng.beta(9.0, 1.1, 850))


@case(SEEDLINGS, "single", right=("zero_inflation",), defensible=("mixture", "flat_background"))
def seedlings_not_watered(rng: Rng) -> NDArray:
    """Trays at the end of the pipe had no water: in 1.5 % nothing came up, and in 1.5 % a third of what should have."""
    n = 1250
    x = one(SEEDLINGS, rng, n, 0.62)
    u = rng.random(n)
    return np.where(u < 0.015, 0, np.where(u < 0.03, rng.binomial(x, 1 / 3), x))


@case(SEEDLINGS, "outside")
def seedlings_of_the_better_tray(rng: Rng) -> NDArray:
    """Each lot of seeds is sown in four trays, and the seedlings of the best are reported: a largest of four.

    Dead time narrows counts as well, but shortens the upper end; here the upper end stays the longer one.
    """
    return one(SEEDLINGS, rng, 4 * 9000, 0.38).reshape(-1, 4).max(axis=1)


@case(ARRIVALS, "single", right=("dead_time",), defensible=("inefficiency",))
def arrivals_at_a_busy_desk(rng: Rng) -> NDArray:
    """Who comes while the clerk is busy goes to the ward unrecorded: three minutes, and five after each sixth."""
    n = 1100
    x = one(ARRIVALS, rng, n, 17.0, 0.2)
    times = np.sort(np.where(np.arange(x.max()) < x[:, None], rng.random((n, x.max())) * 60, np.inf), axis=1)
    free, seen = np.zeros(n), np.zeros(n, dtype=int)
    for t in times.T:
        hit = np.isfinite(t) & (t >= free)
        seen += hit
        free = np.where(hit, t + np.where(seen % 6 == 0, 5.0, 3.0), free)
    return seen


@case(
    ARRIVALS,
    "pair",
    right=("pile_up", "zero_inflation"),
    defensible=("overdispersion", "mixture", "spread", "flat_background"),
)
def arrivals_late_or_not_recorded(rng: Rng) -> NDArray:
    """In one hour of seven most of the hour before is registered too, since the day's shift was late.

    In 4 % of the hours the terminal was down: two thirds of these read nothing, the others a fifth.
    """
    n = 6400
    x = one(ARRIVALS, rng, n, 11.0, 0.25)
    x = x + some(rng, n, 1 / 7) * rng.binomial(one(ARRIVALS, rng, n, 11.0, 0.25), 0.85)
    u = rng.random(n)
    return np.where(u < 0.027, 0, np.where(u < 0.04, rng.binomial(x, 0.2), x))


@case(ARRIVALS, "outside")
def arrivals_without_unlucky_numbers(rng: Rng) -> NDArray:
    """Nobody writes an unlucky number into the book of the ward: 4, 9 and 13 become one more or one less.

    Every other number, odd or even, is written as it is, so that there is no step to which counts are rounded.
    """
    n = 1500
    x = one(ARRIVALS, rng, n, 8.0, 0.3)
    return x + np.isin(x, [4, 9, 13]) * rng.choice([-1, 1], n, p=[0.35, 0.65])


CASES: list[Case] = [
    plain("plankton_alone", PLANKTON, 640, 27.0),
    plain("visits_alone", VISITS, 14000, 3.4, 0.9),
    plain("seedlings_alone", SEEDLINGS, 1200, 0.71),
    plain("arrivals_alone", ARRIVALS, 4300, 14.0, 0.55),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
