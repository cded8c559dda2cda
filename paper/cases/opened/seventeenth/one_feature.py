"""Simulated cases of one real number: fibres of wool, depths of air showers, notes of singers, birds over a radar."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def logistic(x: NDArray) -> NDArray:
    """Return a smooth step from 0 to 1 at zero."""
    return 1 / (1 + np.exp(-np.clip(x, -50, 50)))


def diameter(theta: NDArray, rng: Rng) -> NDArray:
    """Return the diameter of a fibre of wool in micrometres: log-normal, of a mean and a coefficient of variation."""
    log_width = np.sqrt(np.log1p(theta[:, 1] ** 2))
    return theta[:, 0] * np.exp(log_width * rng.standard_normal(len(theta)) - log_width**2 / 2)


def shower(theta: NDArray, rng: Rng) -> NDArray:
    """Return the depth of the maximum of an air shower in g/cm2: a generalised Gumbel variable."""
    shape = theta[:, 2]
    return theta[:, 0] - theta[:, 1] * np.log(rng.gamma(shape) / shape)


def note(theta: NDArray, rng: Rng) -> NDArray:
    """Return by how many cents a sung note is above the note in the score."""
    return rng.normal(theta[:, 0], theta[:, 1])


def flight(theta: NDArray, rng: Rng) -> NDArray:
    """Return the metres above ground at which a bird flies by night."""
    return rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1])


WOOL = task(diameter, prior={"mean": (14, 40), "variation": (0.1, 0.4)}, features=["diameter"], name="wool-fibres")
SHOWER = task(
    shower,
    prior={"mode": (600, 850), "width": (20, 70), "shape": (0.5, 2.5)},
    features=["depth_of_maximum"],
    name="air-showers",
)
SINGING = task(note, prior={"mean": (-40, 40), "width": (4, 40)}, features=["cents"], name="sung-notes")
MIGRANTS = task(flight, prior={"mean": (200, 1500), "shape": (1, 8)}, features=["altitude"], name="night-migrants")


@case(
    WOOL,
    "single",
    right=("mixture",),
    defensible=("radiative_tail", "second_exponential", "peak_background", "spread", "outliers", "flat_background"),
)
def wool_with_the_britch_left_in(rng: Rng) -> NDArray:
    """The wool of the hind legs was not sorted out: 14 % of the fibres come from there and are much coarser.

    They are wool as well, of the same shape, with a mean of 33 instead of 19.5 micrometres, or 29 in younger sheep.
    """
    n = 1890
    fine = one(WOOL, rng, n, 19.5, 0.19)
    coarse = np.where(some(rng, n, 0.3), one(WOOL, rng, n, 29.0, 0.21), one(WOOL, rng, n, 33.0, 0.21))
    return np.where(some(rng, n, 0.14), coarse, fine)


@case(WOOL, "single", right=("quantisation",), defensible=("heaping",))
def wool_under_the_projection_microscope(rng: Rng) -> NDArray:
    """The image of a fibre is laid on a ruler whose millimetres mean 2 micrometres, and read to the millimetre.

    Of one fibre in seven, with sharp edges, a half of a millimetre is read. So nearly all values are known in steps.
    """
    x = one(WOOL, rng, 550, 24.0, 0.22)
    step = np.where(some(rng, len(x), 1 / 7), 1.0, 2.0)
    return step * np.round(x / step)


@case(
    WOOL,
    "pair",
    right=("edge_acceptance", "outliers"),
    defensible=(
        "truncation",
        "analysis_window",
        "radiative_tail",
        "flat_background",
        "second_exponential",
        "mixture",
        "resolution",
        "spread",
    ),
)
def wool_without_dust_with_crossings(rng: Rng) -> NDArray:
    """The instrument takes thin fibres for dust: below 17 micrometres it drops more and more, and nearly all below 15.

    In 4 % of the readings two fibres cross or grease sticks to one, and the value is wrong by tens of micrometres,
    mostly too large.
    """
    n = 13250
    x = one(WOOL, rng, n, 21.0, 0.2)
    x = x[rng.random(n) < 0.03 + 0.97 * logistic((x - 16.3) / 0.5)]
    wrong = x + rng.choice([1.0, -0.35], len(x), p=[0.8, 0.2]) * rng.gamma(2.5, 12.0, len(x))
    return np.where(some(rng, len(x), 0.04), np.abs(wrong), x)


@case(
    SHOWER, "single", right=("dead_region",), defensible=("edge_acceptance", "mixture", "forward_backward_acceptance")
)
def showers_behind_a_cloud(rng: Rng) -> NDArray:
    """A layer of cloud hides the showers that have their maximum in it, between about 745 and 800 g/cm2.

    The layer drifts up and down by some g/cm2, so that its edges are smeared, and one night in seven was clear.
    """
    n = 1650
    x = one(SHOWER, rng, n, 752.0, 42.0, 1.1)
    middle = rng.normal(772.0, 7.0, n)
    hidden = (np.abs(x - middle) < rng.uniform(22.0, 32.0, n)) & some(rng, n, 6 / 7)
    return x[~hidden]


@case(
    SHOWER,
    "pair",
    right=("saturation", "flat_background"),
    defensible=("censoring", "peak_background", "outliers", "edge_acceptance", "mixture", "spread"),
)
def showers_at_the_bound_of_the_fit(rng: Rng) -> NDArray:
    """The fit may not go beyond 870 g/cm2, where the ground is, and four in five of the deeper showers end at it.

    The others were fitted later without a bound. Besides, 6 % of the events are tracks of a laser or of light of a
    town, of which the fit says anything between 450 and 1150 g/cm2.
    """
    n = 8740
    x = one(SHOWER, rng, n, 745.0, 47.0, 0.9)
    stray = 450 + 700 * rng.beta(1.1, 1.0, n)
    x = np.where(some(rng, n, 0.06), stray, x)
    return np.where((x > 870) & some(rng, n, 0.8), 870.0, x)


@case(SHOWER, "outside")
def showers_interpolated_backwards(rng: Rng) -> NDArray:
    """Between two rows of pixels, 56 g/cm2 apart, the program interpolates from the wrong row.

    Each depth is mirrored about the middle of its two rows: the order is turned round inside each block, over the
    whole range. No value is lost, added, rounded or moved beyond its block, and there is no limit.
    """
    x = one(SHOWER, rng, 16100, 720.0, 36.0, 1.4)
    low = 56.0 * np.floor(x / 56.0)
    return 2 * low + 56.0 - x


@case(
    SINGING,
    "single",
    right=("radiative_tail",),
    defensible=("outliers", "second_exponential", "mixture", "resolution", "spread", "flat_background"),
)
def notes_that_are_scooped(rng: Rng) -> NDArray:
    """Singers slide into a fifth of the notes from below, and the mean pitch of such a note is too low.

    By how much depends on how long the slide lasts: some cents as a rule, and more than fifty where the note is short.
    """
    n = 1400
    lag = 80.0 * rng.gamma(1.3, 0.35, n)
    return one(SINGING, rng, n, 6.0, 11.0) - some(rng, n, 0.2) * lag


@case(
    SINGING,
    "pair",
    right=("charge_misid", "dead_region"),
    defensible=("mixture", "peak_background", "flat_background", "forward_backward_acceptance", "edge_acceptance"),
)
def notes_off_the_green_lamp(rng: Rng) -> NDArray:
    """The tuner lights a green lamp within some 6 cents of the truth, and most of these notes are not written down.

    The pupil who writes takes flat for sharp, or the other way round, in 10 % of the rest: the sign is wrong.
    """
    n = 3000
    x = one(SINGING, rng, n, -17.0, 12.0)
    green = np.abs(x) < rng.normal(6.0, 0.7, n)
    x = x[~(green & some(rng, n, 0.9))]
    return np.where(some(rng, len(x), 0.1), -x, x)


@case(SINGING, "outside")
def notes_through_a_picket_fence(rng: Rng) -> NDArray:
    """The pitch is taken from a spectrum with a line each 13 cents: a note between two lines is weak in both of them.

    Such notes often fail the threshold and are left out, so that events are lost in stripes over the whole range, at
    both sides alike. No value is moved, and it is not one region that is lost but a dozen.
    """
    n = 47500
    x = one(SINGING, rng, n, -4.0, 18.0)
    loud = np.cos(np.pi * (x - 3.0) / 13.0) ** 2
    return x[rng.random(n) < 0.1 + 0.9 * logistic((loud - 0.4) / 0.12)]


@case(
    MIGRANTS,
    "single",
    right=("second_exponential",),
    defensible=("mixture", "flat_background", "peak_background", "radiative_tail", "spread"),
)
def migrants_among_moths(rng: Rng) -> NDArray:
    """One echo in eight is a moth: moths are most at the ground, and their number falls off with a length of 70 m.

    On warm nights, one in four, they fly up to twice as high.
    """
    n = 750
    moth = rng.exponential(np.where(some(rng, n, 0.25), 140.0, 70.0))
    return np.where(some(rng, n, 0.125), moth, one(MIGRANTS, rng, n, 760.0, 4.5))


@case(MIGRANTS, "single", right=("peak_background",), defensible=("mixture", "flat_background"))
def migrants_beside_an_airport(rng: Rng) -> NDArray:
    """One echo in fourteen is an aeroplane that waits for the glide path, level at 914 m, which is 3000 feet.

    Altimeters differ by some ten metres, and some aeroplanes have begun to sink, so that the peak has a foot below.
    """
    n = 4740
    sunk = some(rng, n, 0.3) * rng.exponential(45.0, n)
    plane = 914.0 + 14.0 * rng.standard_t(6, n) - sunk
    return np.where(some(rng, n, 1 / 14), plane, one(MIGRANTS, rng, n, 640.0, 2.3))


@case(MIGRANTS, "outside")
def migrants_met_at_each_turn(rng: Rng) -> NDArray:
    """The radar meets the same bird at each turn, some 15 times in the mean, and each echo is taken for a bird.

    Each altitude is right, and none is lost or added by anything else; but the events are not independent of each
    other. Some 430 birds make lumps all over the range as so many events of the simulator never would.
    """
    n = 6440
    turns = rng.geometric(1 / 15, n)
    bird = np.repeat(np.arange(n), turns)[:n]
    x = one(MIGRANTS, rng, n, 880.0, 3.0)[bird]
    return x * np.exp(0.012 * rng.standard_normal(n))


CASES: list[Case] = [
    plain("wool_as_shorn", WOOL, 300, 27.0, 0.25),
    plain("showers_of_dark_nights", SHOWER, 22000, 700.0, 50.0, 1.6),
    plain("notes_as_sung", SINGING, 3490, 11.0, 22.0),
    plain("migrants_by_themselves", MIGRANTS, 410, 520.0, 3.4),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
