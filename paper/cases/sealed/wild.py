"""Simulated cases from outdoors: moths at a lamp, waves at a buoy, fish in a trawl, and trees of a forest."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import case, draw, plain, some

Rng = np.random.Generator


def moths(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many moths a lamp catches in a night: warm nights bring many, and cold ones few."""
    warmth = rng.gamma(theta[:, 1]) / theta[:, 1]
    return rng.poisson(theta[:, 0] * warmth).astype(float)


MOTHS = task(moths, name="moths-at-a-lamp", features=["moths"], prior={"mean": (5, 60), "evenness": (0.8, 15)})


@case(
    MOTHS,
    "single",
    right=("threshold_loss", "zero_inflation"),
    defensible=("dead_region", "edge_acceptance", "mixture", "outliers"),
)
def moths_not_worth_writing_down(rng: Rng) -> NDArray:
    """Nights with a handful of moths were often entered as none, the rather the fewer there were.

    One moth was written down by one in three of the volunteers, six by nearly all. Less even nights give more zeros in
    the simulation, but as many ones and twos.
    """
    x = draw(MOTHS, rng, 1500, 17.0, 1.9)
    return x * (rng.random((1500, 1)) > 0.9 * np.exp(-((x / 4.2) ** 2)))


@case(
    MOTHS,
    "single",
    right=("pile_up",),
    defensible=("mixture", "double_counting", "spread", "overdispersion", "second_exponential", "scale"),
)
def moths_of_two_nights(rng: Rng) -> NDArray:
    """After one night of eight nobody came to empty the trap, and the next morning it held the moths of both.

    Such nights count as one. Less even nights take up a part of it, but have more small catches as well.
    """
    n = 4000
    x, before = draw(MOTHS, rng, n, 24.0, 11.0), draw(MOTHS, rng, n, 24.0, 11.0)
    return x + some(rng, n, 0.125)[:, None] * before


@case(MOTHS, "single", right=("quantisation",), defensible=("readout_noise", "peak_background", "resolution"))
def moths_that_were_estimated(rng: Rng) -> NDArray:
    """Who has many moths on the sheet does not count them out, but gives about how many: in fives, and then in tens.

    Of twenty moths nearly all are still counted, of sixty one in two. Between the round numbers there are then too
    few, which no mean or evenness brings about.
    """
    n = 2500
    x = draw(MOTHS, rng, n, 30.0, 2.2)[:, 0]
    guessed = rng.random(n) < 1 / (1 + (60 / np.maximum(x, 1)) ** 3)
    step = np.where(rng.random(n) < 30 / np.maximum(x, 30), 5, 10)
    return np.where(guessed, step * np.round(x / step), x)[:, None]


@case(MOTHS, "outside", defensible=("quantisation", "dead_region", "peak_background"))
def moths_with_a_seven_read_as_a_one(rng: Rng) -> NDArray:
    """The sheets were read by a machine, which takes two sevens of five, those written without a bar, for a one.

    So 17 becomes 11, and 72 becomes 12. The simulation has no use for digits.
    """
    n = 3500
    x = draw(MOTHS, rng, n, 26.0, 2.6)[:, 0]
    barless = some(rng, n, 0.4)
    ones, tens = x % 10, (x // 10) % 10
    return (x - barless * (6 * (ones == 7) + 60 * (tens == 7)))[:, None]


def waves(theta: NDArray, rng: Rng) -> NDArray:
    """Return the height of a wave in m, from trough to crest, as a buoy measures it in a steady sea."""
    return theta[:, 0] * (rng.exponential(size=len(theta)) / 2) ** (1 / theta[:, 1])


WAVES = task(waves, name="waves-at-a-buoy", features=["height"], prior={"sea": (0.8, 6), "shape": (1.6, 2.6)})


@case(
    WAVES,
    "single",
    right=("saturation",),
    defensible=("edge_acceptance", "truncation", "scale", "forward_backward_acceptance", "peak_background"),
)
def waves_that_break_over_the_bar(rng: Rng) -> NDArray:
    """The buoy lies over a bar, 5 m deep and with a tide of 0.8 m either way, where waves above 0.7 of the depth break.

    A wave that breaks keeps that height, or somewhat less. A steeper shape in the simulation takes up some of it, but
    still has a few waves beyond, and too few that are nearly as high.
    """
    n = 3000
    x = draw(WAVES, rng, n, 3.0, 2.05)[:, 0]
    depth = 5 + 0.8 * np.sin(2 * np.pi * rng.random(n))
    limit = 0.7 * depth * np.exp(0.07 * rng.standard_normal(n))
    return np.where(x > limit, limit * (1 - 0.1 * rng.random(n)), x)[:, None]


@case(
    WAVES,
    "single",
    right=("mixture",),
    defensible=("spread", "second_exponential", "radiative_tail", "outliers", "flat_background", "scale"),
)
def waves_of_a_night_of_storm(rng: Rng) -> NDArray:
    """The record of a week has the night of a gale in it, a twentieth of the waves, when the sea ran 2.1 times as high.

    It rose within an hour and fell as fast. The simulation has one steady sea: a flatter shape makes more high waves,
    but more very low ones as well.
    """
    n = 5000
    gale = some(rng, n, 0.05) * (1.1 + 0.08 * rng.standard_normal(n))
    return draw(WAVES, rng, n, 1.7, 2.1) * (1 + gale)[:, None]


@case(
    WAVES,
    "single",
    right=("edge_acceptance",),
    defensible=("forward_backward_acceptance", "dead_region", "truncation", "offset"),
)
def waves_lost_in_the_ripple(rng: Rng) -> NDArray:
    """The program that parts the waves asks for the sea to cross its mean level clearly, and misses many low waves.

    Half are missed at 0.33 m. A steeper shape in the simulation stands for it, but then lacks the highest waves.
    """
    n = 3000
    x = draw(WAVES, rng, n, 2.2, 1.9)
    return x[x[:, 0] > 0.33 * np.exp(0.35 * rng.standard_normal(n))]


@case(WAVES, "outside", defensible=("mixture", "peak_background", "resolution"))
def waves_filled_in_between(rng: Rng) -> NDArray:
    """The radio link fails for single waves, two of five, and the file has the mean of the two neighbours there.

    Such means are neither as low nor as high as waves are. The simulation takes it up as a steeper shape,
    which has too few of the highest.
    """
    x = draw(WAVES, rng, 8002, 2.6, 2.0)
    return np.where(some(rng, 8000, 0.4)[:, None], (x[:-2] + x[2:]) / 2, x[1:-1])


def fish(theta: NDArray, rng: Rng) -> NDArray:
    """Return the length of a fish in cm, its weight in g, and the radius of its ear stone in mm.

    Fish from one year on die at a fixed rate, and grow towards a final length. The stone grows with age too.
    """
    n = len(theta)
    age = 1 + rng.exponential(1 / theta[:, 2])
    grown, fed, stone = rng.standard_normal((3, n))
    length = theta[:, 0] * -np.expm1(-theta[:, 1] * (age + 0.5)) * np.exp(0.08 * grown)
    weight = theta[:, 3] * length**3 / 100 * np.exp(0.09 * fed)
    radius = 0.62 * (length / 10) ** 0.75 * (1 + age) ** 0.15 * np.exp(0.05 * stone)
    return np.stack([length, weight, radius], axis=1)


FISH = task(
    fish,
    name="fish-in-a-trawl",
    features=["length", "weight", "radius"],
    prior={"final": (50, 95), "growth": (0.15, 0.5), "mortality": (0.2, 1.0), "condition": (0.8, 1.3)},
)


@case(
    FISH,
    "single",
    right=("mixture", "second_exponential"),
    defensible=("spread", "flat_background", "outliers", "peak_background", "scale on length"),
)
def fish_from_the_reserve(rng: Rng) -> NDArray:
    """One fish of seven comes from a reserve close by, where only a quarter as many die each year as on the open bank.

    These are older, and so longer. The simulation has one rate of death for all, and the final length can grow for it.
    """
    n = 6000
    old = some(rng, n, 1 / 7)[:, None]
    return np.where(old, draw(FISH, rng, n, 82.0, 0.18, 0.22, 1.0), draw(FISH, rng, n, 82.0, 0.18, 0.88, 1.0))


@case(
    FISH,
    "single",
    right=("edge_acceptance on length", "forward_backward_acceptance on length"),
    defensible=(
        "edge_acceptance on weight",
        "forward_backward_acceptance on weight",
        "edge_acceptance on radius",
        "forward_backward_acceptance on radius",
        "truncation",
    ),
)
def fish_that_slip_through_the_mesh(rng: Rng) -> NDArray:
    """Small fish escape through the mesh of the net: half of those of 27 cm, and one in ten of 33 cm.

    For many of the small ones to be missing the fish must grow faster in the simulation, and then have other stones.
    """
    n = 3000
    x = draw(FISH, rng, n, 70.0, 0.28, 0.5, 1.05)
    return x[rng.random(n) < 1 / (1 + np.exp(-(x[:, 0] - 27) / 2.7))]


@case(
    FISH,
    "single",
    right=("conditional_response on weight", "scale on weight"),
    defensible=("radiative_tail on weight", "mixture", "spread", "resolution on weight", "crosstalk on weight"),
)
def fish_before_spawning(rng: Rng) -> NDArray:
    """The trawl went out just before spawning, when the ovaries of grown females weigh about a sixth of the fish.

    Half of the fish are females, and half of these are grown at 41 cm. The condition takes up the mean of it, but small
    fish are then too heavy for it.
    """
    n = 2000
    x = draw(FISH, rng, n, 75.0, 0.25, 0.42, 0.92)
    grown = some(rng, n, 0.5) & (rng.random(n) < 1 / (1 + np.exp(-(x[:, 0] - 41) / 2.5)))
    x[:, 1] *= 1 + grown * 0.17 * np.exp(0.3 * rng.standard_normal(n))
    return x


@case(
    FISH,
    "pair",
    right=("quantisation on length", "resolution on weight"),
    defensible=("offset on length", "outliers on weight", "spread", "resolution on length"),
)
def fish_measured_on_a_rolling_deck(rng: Rng) -> NDArray:
    """The board gives lengths to the whole centimetre below, and the scales roll with the ship, by 25 g and more.

    So a fish is shorter by half a centimetre on average. The scatter of the weights is a fixed part in the simulation,
    which for small fish is much less.
    """
    n = 1800
    x = draw(FISH, rng, n, 64.0, 0.33, 0.6, 1.1)
    x[:, 0] = np.floor(x[:, 0])
    x[:, 1] = np.maximum(x[:, 1] + 25 * rng.standard_normal(n) * np.exp(0.3 * rng.standard_normal(n)), 1)
    return x


@case(
    FISH,
    "outside",
    defensible=("forward_backward_acceptance on length", "edge_acceptance on length", "dead_region on length"),
)
def fish_so_many_of_each_length(rng: Rng) -> NDArray:
    """As is usual for ear stones, not all fish were taken, but at most 160 of each class of 5 cm, the first to come.

    So the common lengths are cut down to about the same number, with steps between classes. For a fish of a given
    length all is as it should be. The simulation has only fish as the net brings them up.
    """
    x = draw(FISH, rng, 2500, 72.0, 0.24, 0.55, 0.95)
    classes = (x[:, 0] // 5).astype(int)
    keep = [np.flatnonzero(classes == k)[:160] for k in np.unique(classes)]
    return x[np.sort(np.concatenate(keep))]


def trees(theta: NDArray, rng: Rng) -> NDArray:
    """Return the diameter of a tree in cm at breast height, its height in m, and the width of its crown in m.

    Thick trees are taller, up to a height that the site allows, and one that stands free has a wide crown and is low.
    """
    n = len(theta)
    free, tall, wide = rng.standard_normal((3, n))
    diameter = theta[:, 0] * (rng.exponential(size=n) / 0.7) ** (1 / theta[:, 1])
    height = 1.3 + (theta[:, 2] - 1.3) * (-np.expm1(-0.065 * diameter)) ** 1.2 * np.exp(0.05 * tall - 0.03 * free)
    crown = (0.7 + theta[:, 3] * diameter) * np.exp(0.09 * free + 0.06 * wide)
    return np.stack([diameter, height, crown], axis=1)


TREES = task(
    trees,
    name="trees-of-a-forest",
    features=["diameter", "height", "crown"],
    prior={"diameter": (15, 45), "shape": (1.8, 5), "tallest": (18, 40), "crown": (0.1, 0.25)},
)


@case(
    TREES,
    "single",
    right=("radiative_tail on height",),
    defensible=(
        "outliers on height",
        "mixture",
        "scale on height",
        "spread",
        "resolution on height",
        "conditional_response on height",
    ),
)
def trees_with_broken_tops(rng: Rng) -> NDArray:
    """Wet snow has broken the tops of one tree in ten, mostly of the last metres, seldom of a third of the tree.

    The stem and the crown below are as before. The simulation scatters heights to both sides alike, and always as much.
    """
    n = 1600
    x = draw(TREES, rng, n, 29.0, 3.2, 30.0, 0.17)
    x[:, 1] *= 1 - some(rng, n, 0.1) * 0.45 * rng.beta(1.3, 3.2, n)
    return x


@case(
    TREES,
    "single",
    right=("peak_background", "peak_background on diameter", "peak_background on height", "mixture"),
    defensible=("outliers", "second_exponential", "flat_background", "peak_background on crown"),
)
def trees_with_hazel_below(rng: Rng) -> NDArray:
    """Below the trees stand hazels, and one crew took the thickest stems of them along, which are one in thirty.

    They are about 9 cm thick, 6 m high, and wide for it. The simulation has one kind of tree, and these are not its
    small ones.
    """
    n, m = 2500, 80
    x = draw(TREES, rng, n - m, 27.0, 2.6, 28.0, 0.16)
    hazel = np.array([9.0, 6.2, 3.1]) * np.exp(rng.standard_normal((m, 3)) * np.array([0.14, 0.11, 0.2]))
    return rng.permutation(np.concatenate([x, hazel]))


@case(
    TREES,
    "single",
    right=("crosstalk on height", "conditional_response on height"),
    defensible=("correlation", "scale on height", "resolution on height", "offset on height"),
)
def trees_whose_tops_are_hidden(rng: Rng) -> NDArray:
    """From below one sees the near edge of a wide crown instead of the top, and takes the tree for taller than it is.

    The excess is a third of what the crown is wide beyond 3.5 m. Taller trees in the simulation take up some of it, but
    of equally thick ones those with the wider crowns would still be the lower ones.
    """
    x = draw(TREES, rng, 1500, 31.0, 3.0, 27.0, 0.19)
    x[:, 1] += 0.33 * np.maximum(x[:, 2] - 3.5, 0) * np.exp(0.2 * rng.standard_normal(1500))
    return x


@case(
    TREES,
    "single",
    right=("forward_backward_acceptance on diameter",),
    defensible=(
        "edge_acceptance on diameter",
        "forward_backward_acceptance on height",
        "forward_backward_acceptance on crown",
        "forward_backward_acceptance",
    ),
)
def trees_after_the_thick_were_felled(rng: Rng) -> NDArray:
    """The forest is used tree by tree: thick ones are felled, the likelier the thicker, but not those that are crooked.

    Of those of 36 cm a third is gone, and at last seven of ten. A smaller diameter and a steeper shape take up much of
    it, but then there are not enough of the thickest.
    """
    n = 4500
    x = draw(TREES, rng, n, 29.0, 2.3, 26.0, 0.15)
    return x[rng.random(n) > 0.7 / (1 + np.exp(-(x[:, 0] - 36) / 4))]


@case(
    TREES,
    "pair",
    right=("edge_acceptance on diameter", "quantisation on crown"),
    defensible=(
        "truncation on diameter",
        "truncation",
        "forward_backward_acceptance on diameter",
        "edge_acceptance on height",
        "edge_acceptance on crown",
        "resolution on crown",
    ),
)
def trees_that_are_worth_a_mark(rng: Rng) -> NDArray:
    """Trees below about 13 cm were passed over, judged by eye, and crowns were paced out, in whole steps of 0.8 m.

    The simulation has thin trees wherever the shape makes it have thick ones, and no steps.
    """
    n = 1600
    x = draw(TREES, rng, n, 25.0, 2.4, 33.0, 0.18)
    x[:, 2] = 0.8 * np.maximum(np.round(x[:, 2] / 0.8 + 0.15 * rng.standard_normal(n)), 1)
    return x[x[:, 0] > 13 + 2.0 * rng.standard_normal(n)]


CASES = [
    plain("moths_plain", MOTHS, 1800, 38.0, 1.4),
    moths_not_worth_writing_down,
    moths_of_two_nights,
    moths_that_were_estimated,
    moths_with_a_seven_read_as_a_one,
    plain("waves_plain", WAVES, 5000, 3.7, 2.2),
    waves_that_break_over_the_bar,
    waves_of_a_night_of_storm,
    waves_lost_in_the_ripple,
    waves_filled_in_between,
    plain("fish_of_a_trawl_plain", FISH, 2500, 58.0, 0.4, 0.35, 1.15),
    fish_from_the_reserve,
    fish_that_slip_through_the_mesh,
    fish_before_spawning,
    fish_measured_on_a_rolling_deck,
    fish_so_many_of_each_length,
    plain("trees_plain", TREES, 2000, 36.0, 4.0, 35.0, 0.14),
    trees_with_broken_tops,
    trees_with_hazel_below,
    trees_whose_tops_are_hidden,
    trees_after_the_thick_were_felled,
    trees_that_are_worth_a_mark,
]
"""The cases of this file."""
