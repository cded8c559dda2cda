"""Sealed cases whose events are several values: formants of vowels, milk of cows, whales at sea, jumps of the eye."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, plain, some


def vowels(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Pitch and first two formants of a vowel in hertz: a short vocal tract raises all three, the pitch most."""
    short, own = theta[:, 2] * rng.normal(size=len(theta)), rng.normal(size=(3, len(theta)))
    pitch = 150 * np.exp(2.5 * short + 0.1 * own[0])
    formants = theta[:, :2].T * np.exp(short + np.array([[0.07], [0.05]]) * own[1:])
    return np.column_stack([pitch, *formants])


def milk(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A cow's milk: fat and protein in per cent, which go together, and somatic cells in thousands per millilitre."""
    n = len(theta)
    cow = rng.normal(size=n)
    fat = theta[:, 0] + 0.3 * cow + 0.4 * rng.normal(size=n)
    protein = theta[:, 1] + 0.15 * cow + 0.2 * rng.normal(size=n)
    return np.column_stack([fat, protein, rng.poisson(theta[:, 2] * np.exp(0.8 * rng.normal(size=n)))])


def whales(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Sightings from a ship: kilometres abeam, more to starboard, and whales in a group; large groups show far."""
    size = 1 + rng.poisson(theta[:, 1])
    side = np.where(rng.random(len(theta)) < 0.66, 1.2, -0.9)
    return np.column_stack([side * theta[:, 0] * size**0.5 * np.abs(rng.normal(size=len(theta))), size])


def saccades(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Jumps of the eye: degrees, peak speed in degrees a second that levels off, and milliseconds (main sequence)."""
    degrees = rng.gamma(2, 4, len(theta))
    speed = theta[:, 0] * (1 - np.exp(-degrees / theta[:, 1])) * np.exp(0.1 * rng.normal(size=len(theta)))
    return np.column_stack([degrees, speed, 21 + theta[:, 2] * degrees + rng.normal(0, 4, len(theta))])


VOWELS = task(
    vowels,
    prior={"first": (350, 850), "second": (1000, 2300), "tract": (0.03, 0.15)},
    features=["F0", "F1", "F2"],
    name="vowels",
)
MILK = task(
    milk,
    prior={"fat": (3, 5.5), "protein": (2.8, 4), "cells": (40, 400)},
    features=["fat", "protein", "cells"],
    kinds={"fat": "continuous", "protein": "continuous", "cells": "count"},
    name="milk",
)
WHALES = task(
    whales,
    prior={"sight": (0.2, 2), "group": (0.5, 6)},
    features=["abeam", "whales"],
    kinds={"abeam": "continuous", "whales": "count"},
    name="whales",
)
SACCADES = task(
    saccades,
    prior={"limit": (350, 750), "bend": (3, 14), "slope": (1.5, 3.2)},
    features=["degrees", "speed", "duration"],
    name="saccades",
)


@case(VOWELS, "single", right=("scale on F0",), defensible=("offset on F0",))
def vowels_of_a_fast_tape(rng: np.random.Generator) -> NDArray:
    """The tapes ran fast, by 4 to 10 per cent as the batteries were: all frequencies are stretched. The formants' means
    are parameters and take it in; the pitch has none."""
    x = draw(VOWELS, rng, 1250, 560, 1500, 0.07)
    return x * (1 + rng.triangular(0.04, 0.08, 0.1, (len(x), 1)))


@case(
    VOWELS,
    "single",
    right=("conditional_response on F1",),
    defensible=("crosstalk on F1", "correlation on F1", "correlation", "resolution on F1", "spread"),
)
def vowels_between_harmonics(rng: np.random.Generator) -> NDArray:
    """A high voice has its harmonics wide apart, and linear prediction draws the first formant towards the next one
    above: hardly at all at 120 Hz, by most of the way beyond 220 Hz."""
    x = draw(VOWELS, rng, 6800, 480, 1750, 0.09)
    above = x[:, 0] * np.ceil(x[:, 1] / x[:, 0])
    x[:, 1] += 0.8 / (1 + np.exp((175 - x[:, 0]) / 18)) * (above - x[:, 1])
    return x


@case(
    VOWELS,
    "pair",
    right=("correlation on F1", "correlation on F2", "correlation", "edge_acceptance on F0"),
    defensible=("forward_backward_acceptance on F0", "conditional_response on F2"),
)
def vowels_of_open_mouths(rng: np.random.Generator) -> NDArray:
    """The speakers open their mouths more or less, which raises the first formant and lowers the second; and the pitch
    tracker loses voices below about 115 Hz, gradually."""
    x = draw(VOWELS, rng, 10500, 640, 1350, 0.06)
    opened = rng.normal(size=len(x)) * rng.choice([0.03, 0.09], len(x))
    x[:, 1:] *= np.exp(np.column_stack([opened, -0.8 * opened]))
    return x[rng.random(len(x)) < 1 / (1 + np.exp((116 - x[:, 0]) / 4))]


@case(MILK, "single", right=("readout_noise on cells",), defensible=("flat_background on cells",))
def milk_with_a_dirty_cuvette(rng: np.random.Generator) -> NDArray:
    """The cell counter has a noise of its own, mostly of 20 thousand and at times of 50, which shows in the milk of
    healthy cows; less than nothing is written as nothing."""
    x = draw(MILK, rng, 2300, 4.1, 3.4, 75)
    x[:, 2] = (x[:, 2] + rng.normal(0, rng.choice([20, 50], len(x), p=[0.8, 0.2]))).round().clip(0)
    return x


@case(
    MILK,
    "pair",
    right=("crosstalk on protein", "censoring on cells"),
    defensible=("correlation", "correlation on protein", "conditional_response on protein", "truncation on cells"),
)
def milk_in_the_infrared(rng: np.random.Generator) -> NDArray:
    """The infrared band of fat reaches into that of protein: above 3.6 per cent a quarter of the fat, and below it a
    tenth, is read as protein too; and the form has room for cells up to 499 only."""
    x = draw(MILK, rng, 5800, 4.2, 3.2, 170)
    x[:, 1] += np.where(x[:, 0] > 3.6, 0.25, 0.1) * (x[:, 0] - 3.6)
    x[:, 2] = np.minimum(x[:, 2], 499)
    return x


@case(MILK, "outside")
def milk_carried_over(rng: np.random.Generator) -> NDArray:
    """The analyser is not flushed: what it reads of fat is two thirds of this cow's milk and one third of that of the
    cow before, an average of two events that narrows the scatter and loosens the tie to protein."""
    x = draw(MILK, rng, 4000, 3.9, 3.3, 120)
    share = rng.uniform(0.25, 0.45, len(x))
    x[:, 0] += share * (np.roll(x[:, 0], 1) - x[:, 0])
    return x


@case(WHALES, "single", right=("charge_misid on abeam",), defensible=("forward_backward_acceptance on abeam",))
def whales_on_the_wrong_side(rng: np.random.Generator) -> NDArray:
    """Port and starboard are mixed up on the sheet: rarely near the ship, and for one far sighting in four, which were
    passed on by voice."""
    x = draw(WHALES, rng, 3000, 0.7, 2.2)
    wrong = rng.random(len(x)) < 0.25 * (1 - np.exp(-np.abs(x[:, 0]) / 0.4))
    x[:, 0] *= np.where(wrong, -1, 1)
    return x


@case(WHALES, "single", right=("forward_backward_acceptance on abeam",), defensible=("charge_misid on abeam",))
def whales_in_the_glare(rng: np.random.Generator) -> NDArray:
    """The sun stood to starboard: there the glitter hid four sightings of ten, a little fewer far away, where the water
    is seen at a flat angle."""
    x = draw(WHALES, rng, 1500, 0.9, 1.4)
    seen = np.where(x[:, 0] > 0, 0.68 - 0.16 * np.exp(-x[:, 0] / 0.8), 1)
    return x[rng.random(len(x)) < seen]


@case(WHALES, "outside")
def whales_of_another_line(rng: np.random.Generator) -> NDArray:
    """On half of the sheets the column of group sizes slipped by a line: the sizes belong to other sightings, so that
    large groups are no longer farther off there. Each column is as it was."""
    x = draw(WHALES, rng, 9500, 0.5, 2.6)
    slipped = np.repeat(some(rng, 190, 0.5), 50)
    x[:, 1] = np.where(slipped, np.roll(x[:, 1], 1), x[:, 1])
    return x


@case(SACCADES, "single", right=("resolution on degrees",), defensible=("outliers on degrees", "spread"))
def saccades_by_a_webcam(rng: np.random.Generator) -> NDArray:
    """The webcam tells the angle to half a degree or so, and to one and a half for those who wear glasses (a third)."""
    x = draw(SACCADES, rng, 800, 520, 6, 2.3)
    x[:, 0] += rng.normal(0, rng.choice([0.5, 1.5], len(x), p=[0.67, 0.33]))
    return x


@case(
    SACCADES,
    "pair",
    right=("offset on duration", "flat_background", "flat_background on speed", "flat_background on degrees"),
    defensible=("outliers on speed", "outliers on degrees", "mixture", "scale on duration", "outliers on duration"),
)
def saccades_and_blinks(rng: np.random.Generator) -> NDArray:
    """The filter of the tracker lengthens each jump by 9 to 13 ms; and one jump in twenty-five is a blink, whose angle,
    speed and duration are anything, small speeds a little more often."""
    x = draw(SACCADES, rng, 35000, 560, 7, 2.2)
    x[:, 2] += rng.uniform(9, 13, len(x))
    blink = np.column_stack([rng.uniform(0, 35, len(x)), 900 * rng.beta(1, 1.4, len(x)), rng.uniform(20, 130, len(x))])
    return np.where(some(rng, len(x), 0.04)[:, None], blink, x)


@case(SACCADES, "outside")
def saccades_in_two_steps(rng: np.random.Generator) -> NDArray:
    """A jump and its correction are taken for one in every sixth event: the angles add, the durations add with a pause
    of 30 to 80 ms between, and the speed is that of the faster. No family joins two events of real values."""
    x, more = draw(SACCADES, rng, 2800, 480, 5, 2.5), draw(SACCADES, rng, 2800, 480, 5, 2.5)
    both = np.column_stack(
        [x[:, 0] + more[:, 0], np.maximum(x[:, 1], more[:, 1]), x[:, 2] + more[:, 2] + rng.uniform(30, 80, len(x))]
    )
    return np.where(some(rng, len(x), 1 / 6)[:, None], both, x)


CASES: list[Case] = [
    plain("vowels_of_a_village", VOWELS, 2600, 600, 1450, 0.08),
    plain("milk_of_a_herd", MILK, 13000, 4.3, 3.5, 140),
    plain("whales_of_a_cruise", WHALES, 500, 0.8, 1.9),
    plain("saccades_of_a_reader", SACCADES, 6300, 500, 6, 2.4),
    *(c for c in tuple(globals().values()) if isinstance(c, Case)),
]
