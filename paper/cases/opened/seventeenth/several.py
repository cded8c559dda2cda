"""Simulated cases of several features: breaths of a spirometer, pedals of a bicycle, calls of bats, parcels."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator


def forced_breath(theta: NDArray, rng: Rng) -> NDArray:
    """Return the litres that a person blows out in all, those of the first second, and the peak flow in l/min."""
    body, airways, effort = rng.standard_normal((3, len(theta)))
    fvc = theta[:, 0] * np.exp(0.16 * body)
    odds = theta[:, 1] / (1 - theta[:, 1]) * np.exp(0.3 * airways)
    peak = theta[:, 2] * np.exp(0.1 * body + 0.12 * airways + 0.1 * effort)
    return np.stack([fvc, fvc * odds / (1 + odds), peak], axis=1)


def second_of_a_ride(theta: NDArray, rng: Rng) -> NDArray:
    """Return the watts of the left leg and of the right one, and the beats of the heart in a minute.

    The heart follows the sum of both, from 60 beats at rest towards 190.
    """
    n = len(theta)
    watts = theta[:, 0] * rng.gamma(9.0, 1 / 9.0, n)
    left = theta[:, 1] + 0.015 * rng.standard_normal(n)
    legs = np.stack([left * watts, (1 - left) * watts], axis=1) + 2.0 * rng.standard_normal((n, 2))
    heart = 60 + 130 * (1 - np.exp(-watts / theta[:, 2])) + 4.0 * rng.standard_normal(n)
    return np.concatenate([legs, heart[:, None]], axis=1)


def echolocation(theta: NDArray, rng: Rng) -> NDArray:
    """Return the ms of a bat's call, the kHz at which it is loudest, and the kHz that it sweeps.

    Near to leaves calls are short, sweep far, and are a little higher.
    """
    clutter, length, pitch, sweep = rng.standard_normal((4, len(theta)))
    duration = theta[:, 0] * np.exp(-0.2 * clutter + 0.1 * length)
    peak = theta[:, 1] + 1.1 * clutter + 1.9 * pitch
    return np.stack([duration, peak, theta[:, 2] * np.exp(0.45 * clutter + 0.2 * sweep)], axis=1)


def parcel(theta: NDArray, rng: Rng) -> NDArray:
    """Return the length, width and height of a parcel in cm, and its weight in kg."""
    n = len(theta)
    size = theta[:, 0] * np.exp(0.22 * rng.standard_normal(n))
    sides = size[:, None] * np.array([1.0, 0.7, 0.45]) * np.exp(theta[:, 1:2] * rng.standard_normal((n, 3)))
    weight = theta[:, 2] * sides.prod(axis=1) / 1000 * np.exp(0.4 * rng.standard_normal(n))
    return np.concatenate([sides, weight[:, None]], axis=1)


LUNGS = task(
    forced_breath,
    prior={"volume": (2.2, 6.0), "ratio": (0.6, 0.9), "flow": (250, 700)},
    features=["fvc", "fev1", "peak"],
    name="spirometry",
)
PEDALS = task(
    second_of_a_ride,
    prior={"power": (100, 350), "balance": (0.42, 0.58), "fitness": (130, 420)},
    features=["left", "right", "heart"],
    name="power-pedals",
)
BATS = task(
    echolocation,
    prior={"length": (3, 10), "pitch": (36, 62), "breadth": (6, 35)},
    features=["duration", "peak", "sweep"],
    name="calls-of-bats",
)
PARCELS = task(
    parcel,
    prior={"size": (18, 60), "shape": (0.08, 0.4), "density": (0.08, 0.5)},
    features=["length", "width", "height", "weight"],
    name="parcels",
)


@case(
    LUNGS,
    "single",
    right=("radiative_tail on fvc",),
    defensible=(
        "conditional_response on fvc",
        "second_exponential on fvc",
        "outliers on fvc",
        "crosstalk on fvc",
        "mixture",
        "spread",
    ),
)
def lungs_not_emptied(rng: Rng) -> NDArray:
    """About a third of the persons stop blowing too soon, more of those with narrow airways, who need long.

    What stays in the lungs, half a litre in the mean, is missing in the whole volume but not in the first second.
    """
    n = 1390
    x = draw(LUNGS, rng, n, 4.1, 0.76, 455.0)
    rest = x[:, 0] - x[:, 1]
    stops = rng.random(n) < 0.5 * rest / (rest + 0.5)
    x[:, 0] -= stops * np.minimum(rng.exponential(0.5, n), 0.9 * rest)
    return x


@case(
    LUNGS,
    "single",
    right=("saturation on peak",),
    defensible=("scale on peak", "conditional_response on peak", "edge_acceptance on peak"),
)
def lungs_against_a_wet_screen(rng: Rng) -> NDArray:
    """The screen of the flow meter is wet: fast breath is read too low, the more the faster it is.

    From about 420 l/min on the reading bends, sooner in some persons than in others, and 660 is hardly passed.
    """
    n = 4750
    x = draw(LUNGS, rng, n, 4.6, 0.81, 520.0)
    knee = rng.normal(420.0, 20.0, n)
    beyond = np.maximum(x[:, 2] - knee, 0)
    x[:, 2] -= beyond - 240 * np.tanh(beyond / 240)
    return x


@case(
    LUNGS,
    "pair",
    right=("quantisation on peak", "edge_acceptance on fvc"),
    defensible=("truncation on fvc", "analysis_window on fvc", "heaping on peak", "forward_backward_acceptance on fvc"),
)
def lungs_of_recruits(rng: Rng) -> NDArray:
    """The nurse reads the pointer of the peak flow in tens, and in two of five persons only in fifties.

    Recruits of small lungs are sent home: the doctor draws the line near 3.4 litres, but not always at the same place.
    """
    n = 2570
    x = draw(LUNGS, rng, n, 3.8, 0.84, 480.0)
    x = x[x[:, 0] > rng.normal(3.4, 0.12, n)]
    step = np.where(some(rng, len(x), 0.4), 50.0, 10.0)
    x[:, 2] = np.round(x[:, 2] / step) * step
    return x


@case(
    PEDALS,
    "single",
    right=("offset on left",),
    defensible=("crosstalk on left", "scale on left", "conditional_response on left", "resolution on left", "spread"),
)
def pedals_from_a_warm_cellar(rng: Rng) -> NDArray:
    """The bicycle comes from a warm cellar, and the zero of the left pedal falls by 15 W while it cools in the snow.

    Most of this is over after a sixth of the ride; in sun and shade the zero then still moves by 2 W.
    """
    n = 3500
    x = draw(PEDALS, rng, n, 195.0, 0.51, 240.0)
    time = np.arange(n) / n
    x[:, 0] -= 15.0 * (1 - np.exp(-time / 0.08)) + 2.0 * np.sin(40 * time)
    return x


@case(
    PEDALS,
    "single",
    right=("peak_background on heart",),
    defensible=("outliers on heart", "flat_background on heart", "radiative_tail on heart", "mixture", "spread"),
)
def pedals_that_lead_the_heart(rng: Rng) -> NDArray:
    """The optical sensor at the wrist locks on to the beat of the legs: in one second of twenty it tells the cadence.

    This is near 88 turns a minute, a little more of them in a sprint; it is told oftener when the effort is great.
    """
    n = 1020
    x = draw(PEDALS, rng, n, 240.0, 0.485, 260.0)
    watts = x[:, 0] + x[:, 1]
    locked = rng.random(n) < 0.1 * watts / (watts + 240.0)
    x[:, 2] = np.where(locked, 85 + watts / 80 + 3.5 * rng.standard_normal(n), x[:, 2])
    return x


@case(PEDALS, "outside")
def pedals_with_one_sensor(rng: Rng) -> NDArray:
    """In the last third of the ride the battery of the right pedal is flat, and the computer writes the left one twice.

    The right value is then a copy of the left, to the last digit: each feature by itself looks as it should.
    """
    n = 1890
    x = draw(PEDALS, rng, n, 165.0, 0.5, 300.0)
    flat = np.arange(n) >= 2 * n // 3
    x[flat, 1] = x[flat, 0]
    return x


@case(
    BATS,
    "single",
    right=("mixture",),
    defensible=("peak_background on peak", "spread", "flat_background on peak", "radiative_tail on peak"),
)
def bats_of_a_hidden_species(rng: Rng) -> NDArray:
    """One in eleven calls is of the soprano pipistrelle, which nobody tells from the common one by its looks.

    It calls 9 kHz higher, with calls that are a little shorter and sweep further, and is otherwise as its sister.
    """
    n = 550
    common, soprano = draw(BATS, rng, n, 5.8, 45.5, 14.0), draw(BATS, rng, n, 5.1, 54.5, 18.0)
    return either(some(rng, n, 1 / 11), soprano, common)


@case(
    BATS,
    "pair",
    right=("radiative_tail on duration", "dead_region on peak"),
    defensible=("second_exponential on duration", "outliers on duration", "mixture", "spread"),
)
def bats_over_a_pond(rng: Rng) -> NDArray:
    """In a fifth of the calls the echo from the water is taken for the call's end, which lengthens it by 1.5 ms or so.

    A filter against the whistle of a lamp, at 46.5 kHz, hides most of the calls that are loudest near it.
    """
    n = 8780
    x = draw(BATS, rng, n, 5.2, 47.8, 20.0)
    x = x[rng.random(n) > 0.85 * np.exp(-(((x[:, 1] - 46.5) / 0.8) ** 4))]
    x[:, 0] += some(rng, len(x), 0.2) * rng.gamma(1.3, 1.2, len(x))
    return x


@case(BATS, "outside")
def bats_with_sweeps_filled_in(rng: Rng) -> NDArray:
    """Where a call is too faint to see how far it sweeps, in four of nine, the program reckons this from its duration.

    These calls lie on one curve without any scatter about it. Nothing is smeared, shifted or lost.
    """
    n = 11900
    x = draw(BATS, rng, n, 6.4, 42.5, 24.0)
    curve = 24.0 * (x[:, 0] / 6.4) ** -1.8
    x[:, 2] = np.where(some(rng, n, 4 / 9), curve, x[:, 2])
    return x


@case(
    PARCELS,
    "single",
    right=("conditional_response on length",),
    defensible=(
        "crosstalk on length",
        "scale on length",
        "resolution on length",
        "radiative_tail on length",
        "offset on length",
    ),
)
def parcels_that_slip(rng: Rng) -> NDArray:
    """Heavy parcels slip on the belt, stay longer in the beam of light, and are taken for longer than they are.

    From about 4 kg on a parcel slips for some part of its way: it gains nothing or up to a third of its length.
    """
    n = 6460
    x = draw(PARCELS, rng, n, 36.0, 0.2, 0.23)
    slips = 1 / (1 + np.exp(-(x[:, 3] - 4.5) / 0.8))
    x[:, 0] *= 1 + 0.33 * slips * rng.beta(1.5, 1.5, n)
    return x


@case(
    PARCELS,
    "pair",
    right=("crosstalk on width", "quantisation on height"),
    defensible=(
        "crosstalk on length",
        "conditional_response on width",
        "offset on width",
        "scale on width",
        "heaping on height",
    ),
)
def parcels_askew(rng: Rng) -> NDArray:
    """Parcels lie askew, by 8 degrees as a rule, and the box about them is measured: length is added to the width.

    The height is told by a curtain of beams of light 2 cm apart, of which every second one is off half of the time.
    """
    n = 16200
    x = draw(PARCELS, rng, n, 31.0, 0.16, 0.31)
    turn = np.minimum(np.abs(rng.normal(0.0, 0.18, n)), 0.6)
    length, width = x[:, 0].copy(), x[:, 1].copy()
    x[:, 0] = length * np.cos(turn) + 0.25 * width * np.sin(turn)
    x[:, 1] = width * np.cos(turn) + length * np.sin(turn)
    apart = np.where(some(rng, n, 0.5), 4.0, 2.0)
    x[:, 2] = apart * np.ceil(x[:, 2] / apart)
    return x


@case(PARCELS, "outside")
def parcels_as_they_are_charged(rng: Rng) -> NDArray:
    """The table has the weight that is charged: at least 1 kg for each five litres, however light the parcel is.

    For parcels of less the weight is one fifth of the product of the sides: a floor that all three sides make together.
    """
    x = draw(PARCELS, rng, 750, 33.0, 0.24, 0.2)
    x[:, 3] = np.maximum(x[:, 3], x[:, :3].prod(axis=1) / 5000)
    return x


CASES: list[Case] = [
    plain("lungs_alone", LUNGS, 22100, 3.3, 0.72, 400.0),
    plain("pedals_alone", PEDALS, 300, 215.0, 0.53, 200.0),
    plain("bats_alone", BATS, 410, 4.6, 50.0, 12.0),
    plain("parcels_alone", PARCELS, 30000, 27.0, 0.3, 0.16),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
