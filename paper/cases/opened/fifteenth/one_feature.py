"""Simulated cases of one real number: levels of the tide, ages by radiocarbon, blood sugar, sound beside a road."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def level(theta: NDArray, rng: Rng) -> NDArray:
    """Return the level of the sea at any time, in m above its mean: the tide, larger at springs, and what wind adds."""
    n = len(theta)
    tide = theta[:, 0] * (1 + theta[:, 1] * np.cos(2 * np.pi * rng.random(n))) * np.cos(2 * np.pi * rng.random(n))
    return tide + theta[:, 2] * rng.standard_normal(n)


def age(theta: NDArray, rng: Rng) -> NDArray:
    """Return the age of a seed from a village, lived in evenly until its end, with an error of measurement of 35."""
    n = len(theta)
    return theta[:, 0] + theta[:, 1] * rng.random(n) + 35 * rng.standard_normal(n)


def sugar(theta: NDArray, rng: Rng) -> NDArray:
    """Return the sugar in the blood of a patient, in mmol/l: never below 3.6, and more for a while after each meal."""
    return 3.6 + theta[:, 1] * rng.gamma(theta[:, 0])


def loudness(theta: NDArray, rng: Rng) -> NDArray:
    """Return the sound level beside a road, in dB: that of the nearest car, which may be near or far."""
    n = len(theta)
    far = theta[:, 1] * rng.exponential(size=n)
    return theta[:, 0] - 10 * np.log10(1 + far**2) + theta[:, 2] * rng.standard_normal(n)


TIDE = task(
    level,
    prior={"amplitude": (0.5, 4), "springs": (0.05, 0.45), "wind": (0.05, 0.5)},
    features=["level"],
    name="tidal-levels",
)
SEEDS = task(age, prior={"end": (1500, 4000), "duration": (100, 1200)}, features=["age"], name="radiocarbon-ages")
SUGAR = task(sugar, prior={"meals": (1, 8), "rise": (0.2, 2)}, features=["sugar"], name="glucose-meters")
ROAD = task(
    loudness,
    prior={"source": (65, 85), "spacing": (0.4, 8), "width": (0.5, 4)},
    features=["sound"],
    name="sound-levels",
)


@case(TIDE, "single", right=("offset",), defensible=("mixture", "forward_backward_acceptance"))
def tide_with_a_slipped_wire(rng: Rng) -> NDArray:
    """The wire of the float slipped on its wheel, and from then on, for 55 % of the record, levels read 0.3 m too low.

    It slipped in steps, so that some of these are wrong by 0.2 m only.
    """
    n = 1350
    slip = np.where(some(rng, n, 0.2), 0.2, 0.3)
    return one(TIDE, rng, n, 1.5, 0.2, 0.12) - slip * some(rng, n, 0.55)


@case(
    TIDE,
    "pair",
    right=("saturation", "outliers"),
    defensible=("censoring", "peak_background", "mixture", "radiative_tail", "flat_background"),
)
def tide_at_a_dry_well_with_ships(rng: Rng) -> NDArray:
    """The harbour runs dry at low water: where the tide is below -1.75 m, the radar sees the mud, which has ripples.

    In 4 % of the readings it sees a ship, some metres higher, or the water by way of a ship, which makes it lower.
    """
    n = 10500
    x = one(TIDE, rng, n, 2.0, 0.25, 0.2)
    x = np.maximum(x, -1.75 + 0.012 * rng.standard_normal(n))
    ship = rng.choice([1.0, -1.0], n, p=[0.7, 0.3]) * rng.gamma(3.0, 1.0, n)
    return x + some(rng, n, 0.04) * ship


@case(TIDE, "outside")
def tide_read_from_the_wrong_mark(rng: Rng) -> NDArray:
    """One of two observers reads the staff downwards from the mark above: 2.2 m he writes as 2.8 m, and 2.8 as 2.2.

    Levels are mirrored within each metre, for 45 % of the readings. How far and which way a value moves depends on
    where it is between two marks; none is lost, stretched, rounded or smeared.
    """
    x = one(TIDE, rng, 7900, 2.25, 0.08, 0.09)
    return np.where(some(rng, len(x), 0.45), 2 * np.floor(x) + 1 - x, x)


@case(SEEDS, "single", right=("resolution",), defensible=("edge_acceptance", "outliers", "spread"))
def seeds_with_errors_too_small(rng: Rng) -> NDArray:
    """The errors that laboratories state leave out what happens before the counter: true ones are two to four times 35.

    How much larger they are differs from one laboratory to the next, as comparisons between them have found.
    """
    n = 1800
    larger = rng.choice([1.9, 2.6, 3.2, 4.0], n, p=[0.2, 0.3, 0.3, 0.2])
    return one(SEEDS, rng, n, 2650.0, 430.0) + 35 * np.sqrt(larger**2 - 1) * rng.standard_normal(n)


@case(SEEDS, "single", right=("dead_region",), defensible=("mixture", "edge_acceptance"))
def seeds_of_the_layer_that_was_dug_away(rng: Rng) -> NDArray:
    """A terrace was dug into the mound and took away most of the layers of two centuries in the middle of its time.

    Its slopes are not steep: towards older and younger layers ever more is left.
    """
    x = one(SEEDS, rng, 640, 2900.0, 880.0)
    left = 1 - 0.88 / (1 + (np.abs(x - 3420.0) / 105.0) ** 6)
    return x[rng.random(len(x)) < left]


@case(
    SEEDS,
    "pair",
    right=("radiative_tail", "quantisation"),
    defensible=("heaping", "second_exponential", "mixture", "outliers", "edge_acceptance"),
)
def seeds_and_old_wood_in_fifties(rng: Rng) -> NDArray:
    """Two in five samples are charcoal and not seeds: the wood had stood as a tree before, 170 years in the mean.

    Older lists, of which a third of the ages come, give them to the next 50 years, and a few of them to a century.
    """
    n = 3300
    x = one(SEEDS, rng, n, 1950.0, 420.0) + some(rng, n, 0.4) * rng.gamma(1.3, 130.0, n)
    step = np.where(some(rng, n, 0.15), 100.0, 50.0)
    return np.where(some(rng, n, 1 / 3), np.round(x / step) * step, x)


@case(
    SUGAR,
    "single",
    right=("radiative_tail",),
    defensible=("outliers", "mixture", "second_exponential", "flat_background", "spread"),
)
def sugar_on_the_fingers(rng: Rng) -> NDArray:
    """One patient in twelve had eaten fruit and not washed his hands: the sugar on his finger adds to that in the drop.

    Mostly this is a few mmol/l, with a long tail of those who had peeled an orange.
    """
    n = 1000
    juice = rng.lognormal(np.log(3.5), 0.5, n)
    return one(SUGAR, rng, n, 4.5, 0.6) + some(rng, n, 1 / 12) * juice


@case(SUGAR, "single", right=("forward_backward_acceptance",), defensible=("edge_acceptance", "mixture", "turn_on"))
def sugar_not_written_down_when_high(rng: Rng) -> NDArray:
    """Patients would rather not show their doctor a high value: of those above 8 mmol/l six in ten are left out.

    The limit that they have in mind differs by some tenths. Of low ones a few are forgotten, as it happens.
    """
    x = one(SUGAR, rng, 7000, 4.2, 1.05)
    high = 1 / (1 + np.exp(-(x - 8.0) / 0.12))
    return x[rng.random(len(x)) > 0.04 + 0.58 * high]


@case(SUGAR, "outside")
def sugar_of_the_nicer_drop(rng: Rng) -> NDArray:
    """Whoever keeps the diary measures at two times of the day and writes down what is nearer to the goal of 6.5.

    Each event is chosen from two by how far they are from a goal, in the whole range: it is no peak of another source,
    no region or end in which values are lost, and no second kind of patient.
    """
    n = 4400
    x = one(SUGAR, rng, 2 * n, 3.4, 1.1).reshape(n, 2)
    return x[np.arange(n), np.argmin(np.abs(x - 6.5), axis=1)]


@case(ROAD, "single", right=("peak_background",), defensible=("mixture",))
def road_beside_a_cooling_plant(rng: Rng) -> NDArray:
    """In pauses of the traffic a cooling plant is heard: in 4 % of the samples, at 57 dB, and in frost at 58 dB."""
    n = 14000
    hum = np.where(some(rng, n, 0.3), 58.0, 57.0) + 0.3 * rng.standard_normal(n)
    return np.where(some(rng, n, 0.04), hum, one(ROAD, rng, n, 73.0, 3.1, 1.6))


@case(
    ROAD,
    "pair",
    right=("edge_acceptance", "flat_background"),
    defensible=("turn_on", "truncation", "outliers", "mixture"),
)
def road_with_a_trigger_in_the_wind(rng: Rng) -> NDArray:
    """The recorder starts at 60 dB, of a level that it knows to a dB, and keeps little of what is softer.

    Gusts on the microphone, 4 % of what it keeps, have any level from 55 to 105 dB, the louder the rarer.
    """
    x = one(ROAD, rng, 33000, 76.0, 4.2, 1.2)
    x = x[rng.random(len(x)) < 1 / (1 + np.exp(-(x - 60.0) / 0.6))]
    return np.where(some(rng, len(x), 0.04), 55 + 50 * rng.beta(1.0, 1.3, len(x)), x)


@case(ROAD, "outside")
def road_with_two_levels_in_one(rng: Rng) -> NDArray:
    """The logger saves memory: it writes one level for two samples, and takes the mean of their decibels for it.

    A loud sample and a soft one become one between them, which neither was. No event is lost, and none has an error
    of its own: two are made one, so that both ends of the range become thin and the middle full.
    """
    x = one(ROAD, rng, 2 * 2400, 76.0, 1.9, 0.9)
    return (x[::2] + x[1::2]) / 2


CASES: list[Case] = [
    plain("tide_alone", TIDE, 19000, 2.9, 0.3, 0.25),
    plain("seeds_alone", SEEDS, 310, 3200.0, 540.0),
    plain("sugar_alone", SUGAR, 420, 2.6, 0.9),
    plain("road_alone", ROAD, 5900, 78.0, 1.8, 2.4),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
