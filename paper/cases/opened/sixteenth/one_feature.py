"""Simulated cases of one real number: craters, bonds that are torn, eyes that need glasses, dives of seals."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def crater(theta: NDArray, rng: Rng) -> NDArray:
    """Return the decimal logarithm of the diameter in km of a crater of 1 km or more: diameters fall as a power."""
    return rng.exponential(1 / (np.log(10) * theta[:, 0]))


def rupture(theta: NDArray, rng: Rng) -> NDArray:
    """Return the force in pN at which a bond tears that is pulled ever more (Bell and Evans)."""
    return theta[:, 0] * np.log1p(theta[:, 1] * rng.standard_exponential(len(theta)))


def refraction(theta: NDArray, rng: Rng) -> NDArray:
    """Return the lens in dioptres that an eye needs: more peaked than a normal law, hence logistic."""
    return rng.logistic(theta[:, 0], theta[:, 1])


def dive(theta: NDArray, rng: Rng) -> NDArray:
    """Return the minutes that a seal stays under water."""
    return rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1])


CRATERS = task(crater, prior={"slope": (1, 4)}, features=["log_diameter"], name="craters")
BONDS = task(rupture, prior={"scale": (5, 30), "rate": (3, 400)}, features=["force"], name="torn-bonds")
EYES = task(refraction, prior={"centre": (-4, 3), "width": (0.3, 2)}, features=["lens"], name="refractions-of-eyes")
SEALS = task(dive, prior={"mean": (2, 20), "shape": (1.2, 9)}, features=["minutes"], name="dives-of-seals")


@case(CRATERS, "single", right=("edge_acceptance", "turn_on"), defensible=("truncation", "dead_region"))
def craters_worn_down(rng: Rng) -> NDArray:
    """Small craters are worn down, and filled with dust: of those of 1 km a third is still seen, of 2 km nine in ten.

    One quarter of the map is young ground, on which all are seen.
    """
    n = 1050
    x = one(CRATERS, rng, n, 2.1)
    seen = 0.1 + 0.9 / (1 + np.exp(-(x - 0.16) / 0.06))
    return x[rng.random(n) < np.where(some(rng, n, 0.25), 1.0, seen)]


@case(CRATERS, "single", right=("offset",), defensible=("mixture", "flat_background", "edge_acceptance", "resolution"))
def craters_given_by_their_radius(rng: Rng) -> NDArray:
    """One of the two lists gives the radius in place of the diameter, with the same heading: 30 % of all entries.

    A half is a shift by 0.301 of the logarithm. These men also drew the rim by 4 % too wide or too narrow.
    """
    n = 4700
    x = one(CRATERS, rng, n, 1.8)
    return np.where(some(rng, n, 0.3), x - np.log10(2) + rng.normal(0, 0.018, n), x)


@case(
    CRATERS,
    "pair",
    right=("peak_background", "quantisation"),
    defensible=("heaping", "mixture", "flat_background", "second_exponential"),
)
def craters_of_fragments_by_template(rng: Rng) -> NDArray:
    """One large impact threw out blocks, whose craters of 3 to 5 km are 9 % of all, most of them near 3.5.

    Two in three craters are measured with a template of circles of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, ... km.
    """
    n = 8000
    x = np.where(some(rng, n, 0.09), 0.48 + 0.25 * rng.beta(1.6, 3.0, n), one(CRATERS, rng, n, 2.4))
    circles = np.log10(np.outer([1, 10, 100, 1000], [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8]).ravel())
    nearest = circles[np.abs(x[:, None] - circles).argmin(axis=1)]
    return np.where(some(rng, n, 2 / 3), nearest, x)


@case(
    BONDS,
    "single",
    right=("second_exponential",),
    defensible=("mixture", "flat_background", "radiative_tail", "peak_background", "spread"),
)
def bonds_that_are_mere_stickiness(rng: Rng) -> NDArray:
    """In one of six curves the tip just sticks to the surface: these forces fall exponentially from zero.

    Their mean is 28 pN, and 40 pN with tips that were used for long, a third of them.
    """
    n = 1400
    sticky = rng.exponential(np.where(some(rng, n, 1 / 3), 40.0, 28.0))
    return np.where(some(rng, n, 1 / 6), sticky, one(BONDS, rng, n, 17.0, 160.0))


@case(
    BONDS,
    "pair",
    right=("edge_acceptance", "resolution"),
    defensible=("turn_on", "truncation", "spread", "scale", "mixture", "outliers"),
)
def bonds_lost_in_noise(rng: Rng) -> NDArray:
    """The level of zero force swings by 14 pN from curve to curve, more so with the soft levers, three in ten.

    A step of less than about 45 pN is not found in the noise of the curve, if that is a noisy one.
    """
    n = 9500
    x = one(BONDS, rng, n, 11.0, 300.0)
    x = x + np.where(some(rng, n, 0.3), 22.0, 14.0) * rng.standard_normal(n)
    return x[rng.random(n) < 1 / (1 + np.exp(-(x - rng.normal(45.0, 3.0, n)) / 1.5))]


@case(BONDS, "outside")
def bonds_nearest_to_the_expected(rng: Rng) -> NDArray:
    """A curve shows three steps, and the program reports that which is nearest to 70 pN, as the bond should tear there.

    Each reported force is a true one. Which of three is taken depends on how far it is from a guess.
    """
    n = 3000
    x = one(BONDS, rng, 3 * n, 21.0, 60.0).reshape(n, 3)
    return x[np.arange(n), np.abs(x - 70.0).argmin(axis=1)]


@case(EYES, "single", right=("charge_misid",), defensible=("mixture", "peak_background", "flat_background", "outliers"))
def eyes_without_a_sign(rng: Rng) -> NDArray:
    """A lens without a sign was typed as a plus: 12 % of the short-sighted eyes, but 5 % of those beyond -4 D.

    Opticians write a minus small. A plus is always written, and never read as a minus.
    """
    n = 550
    x = one(EYES, rng, n, -2.3, 0.6)
    return np.where((x < 0) & some(rng, n, np.where(x < -4, 0.05, 0.12)), -x, x)


@case(
    EYES,
    "single",
    right=("radiative_tail",),
    defensible=("mixture", "second_exponential", "outliers", "spread", "flat_background"),
)
def eyes_that_accommodate(rng: Rng) -> NDArray:
    """Without drops a child looks at the near target, and the machine reads too short-sighted: in a quarter of eyes.

    The excess is exponential, by 2.2 D in the mean, and ends at 7 to 9 D, beyond which no eye can go.
    """
    n = 2600
    x = one(EYES, rng, n, 0.8, 0.42)
    return x - some(rng, n, 0.25) * np.minimum(rng.exponential(2.2, n), rng.uniform(7.0, 9.0, n))


@case(EYES, "outside")
def eyes_by_quota(rng: Rng) -> NDArray:
    """The study wanted as many eyes of each class of a dioptre, from -5 to 3 D: a class was closed when it was full.

    So its classes hold the same number, but within each eyes are as common as they are: a staircase of densities.
    Nothing is lost towards an end or in one place, but ever more the more common an eye is.
    """
    n, quota = 43000, 800
    x = one(EYES, rng, n, -0.9, 0.9)
    x = x[(x > -5) & (x < 3)]
    klass = np.floor(x).astype(int)
    return rng.permutation(np.concatenate([x[klass == k][:quota] for k in range(-5, 3)]))


@case(SEALS, "single", right=("quantisation",))
def seals_looked_at_now_and_then(rng: Rng) -> NDArray:
    """The tag looks each 40 s whether it is wet, so that a dive is a whole number of these: one more or one less.

    As the dive starts at any time between two looks, either comes by chance. One tag in six looks each second.
    """
    n = 760
    x = one(SEALS, rng, n, 5.2, 4.0)
    step = 40 / 60
    return np.where(some(rng, n, 1 / 6), x, step * np.maximum(np.floor(x / step + rng.random(n)), 1))


@case(
    SEALS,
    "pair",
    right=("edge_acceptance", "saturation"),
    defensible=("censoring", "turn_on", "truncation", "peak_background"),
)
def seals_short_and_long_dives(rng: Rng) -> NDArray:
    """A dive counts from a depth of 4 m on, which short ones do not reach: half of those of 2 min are missed.

    The message has room for dives up to 15 min, and sends 15 for longer ones. New tags, one in ten, send up to 25.
    """
    x = one(SEALS, rng, 14500, 8.0, 2.2)
    x = x[rng.random(len(x)) < 1 / (1 + np.exp(-(x - 2.0) / 0.35))]
    return np.minimum(x, np.where(some(rng, len(x), 0.1), 25.0, 15.0))


@case(SEALS, "outside")
def seals_heard_in_stripes(rng: Rng) -> NDArray:
    """The satellite listens for a part of each 2.4 min since the dive began, so that dives are received in stripes.

    Seven or more gaps lie side by side, with soft edges, all over the range. The times are not rounded.
    """
    n = 11000
    x = one(SEALS, rng, n, 9.5, 3.5)
    return x[rng.random(n) < 0.1 + 0.9 / (1 + np.exp(-4.0 * np.cos(2 * np.pi * (x - 0.7) / 2.4)))]


CASES: list[Case] = [
    plain("craters_alone", CRATERS, 390, 3.1),
    plain("bonds_alone", BONDS, 1900, 13.0, 90.0),
    plain("eyes_alone", EYES, 26000, -1.4, 1.2),
    plain("seals_alone", SEALS, 20000, 11.0, 1.8),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
