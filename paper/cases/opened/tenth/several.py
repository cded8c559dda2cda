"""Cases of events of several features: earthquakes, tracks, cells, stars, claims, molecules and arrows.

Written without sight of the code.
"""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, some


def _quake(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """An earthquake with a magnitude above 2, a depth, a distance from the network and an azimuth in degrees."""
    n = len(theta)
    magnitude = 2 + rng.exponential(1 / (theta[:, 0] * np.log(10)))
    depth = rng.gamma(2.5, theta[:, 1] / 2.5)
    return np.stack([magnitude, depth, 200 * np.sqrt(rng.random(n)), rng.uniform(0, 360, n)], axis=1)


def _step(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The length in m and the turning angle of a step between two fixes (Kareiva, Shigesada 1983)."""
    return np.stack([theta[:, 0] * rng.weibull(1.5, len(theta)), rng.vonmises(0, theta[:, 1])], axis=1)


def _cell(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The light of a T cell in the channels of CD3, CD4 and CD8: a share are helpers, and the others are killers."""
    n = len(theta)
    helper = rng.random(n) < theta[:, 0]
    cd4, cd8 = np.where(helper, [[8.0], [1.0]], [[1.0], [10.0]])
    means = np.stack([theta[:, 1], cd4, cd8], axis=1)
    return means * np.exp(rng.normal(0, [0.35, 0.3, 0.35], (n, 3))) + rng.normal(0, 0.15, (n, 3))


def _star(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """The magnitudes g, r, i, z and y of a star: a locus of colours with a mean and a width (Covey 2007)."""
    n = len(theta)
    colour = rng.normal(theta[:, 0], theta[:, 1])
    r = 20.5 - np.minimum(rng.exponential(1.2, n), 5)
    bands = r[:, None] + colour[:, None] * [1, 0, -0.45, -0.7, -0.85]
    return bands + rng.normal(0, 0.03, (n, 5))


def _claim(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A claim with an amount in thousands, a delay until it is reported in days, and a number of persons hurt."""
    n = len(theta)
    return np.stack(
        [np.exp(rng.normal(theta[:, 0], 0.8)), rng.gamma(1.2, theta[:, 1] / 1.2, n), rng.poisson(theta[:, 2], n)],
        axis=1,
    )


def _burst(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A burst of one molecule: photons of the donor and the acceptor, and a length in ms (Deniz 1999)."""
    length = 0.5 + rng.gamma(3, 0.4, len(theta))
    photons = theta[:, 1] * length
    return np.stack([rng.poisson(photons * (1 - theta[:, 0])), rng.poisson(photons * theta[:, 0]), length], axis=1)


def _arrow(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Where an arrow hits in cm right of and above the middle, and its speed in m/s, which lifts it."""
    n = len(theta)
    speed = rng.normal(58, 0.8, n)
    side = rng.normal(theta[:, 0], theta[:, 1])
    return np.stack([side, rng.normal(1.5 * (speed - 58), theta[:, 1]), speed], axis=1)


QUAKE = task(
    _quake,
    prior={"b": (0.6, 1.4), "depth": (6, 25)},
    features=["magnitude", "depth", "distance", "azimuth"],
    kinds={"azimuth": "angle"},
    feature_units={"depth": "km", "distance": "km", "azimuth": "deg"},
    name="quake",
)
STEP = task(
    _step,
    prior={"length": (30, 500), "straightness": (0.2, 4)},
    features=["step", "turn"],
    kinds={"turn": "angle"},
    feature_units={"step": "m"},
    name="step",
)
CELL = task(_cell, prior={"helpers": (0.1, 0.9), "cd3": (2, 9)}, features=["cd3", "cd4", "cd8"], name="cell")
STAR = task(_star, prior={"colour": (0.2, 1.2), "width": (0.08, 0.45)}, features=["g", "r", "i", "z", "y"], name="star")
CLAIM = task(
    _claim,
    prior={"amount": (0.3, 2.2), "delay": (15, 120), "hurt": (0.2, 3)},
    features=["amount", "delay", "hurt"],
    kinds={"hurt": "count"},
    feature_units={"delay": "d"},
    name="claim",
)
BURST = task(
    _burst,
    prior={"efficiency": (0.15, 0.85), "brightness": (15, 70)},
    features=["donor", "acceptor", "length"],
    kinds={"donor": "count", "acceptor": "count"},
    feature_units={"length": "ms"},
    name="burst",
)
ARROW = task(_arrow, prior={"side": (-6, 6), "scatter": (2, 10)}, features=["x", "y", "speed"], name="arrow")


@case(QUAKE)
def quake_plain(rng):
    """A complete catalogue of shallow earthquakes."""
    return draw(QUAKE, rng, 5000, 0.92, 8.5)


@case(QUAKE, "single", ("peak_background on depth",))
def quake_fixed_depth(rng):
    """Where the depth cannot be resolved the analyst fixes it at 10 km, in an eighth of the events."""
    x = draw(QUAKE, rng, 4000, 1.0, 14.0)
    x[some(rng, 4000, 0.12), 1] = 10
    return x


@case(QUAKE, "single", ("edge_acceptance on magnitude",), ("conditional_response on magnitude",))
def quake_detection(rng):
    """An earthquake is found if its magnitude passes a noisy threshold that is a little higher at a distance."""
    x = draw(QUAKE, rng, 3000, 0.9, 12.0)
    return x[rng.normal(2.0 + 0.001 * x[:, 2], 0.15) < x[:, 0]]


@case(QUAKE, "pair", ("quantisation on magnitude", "dead_region on azimuth"))
def quake_sea_side(rng):
    """Magnitudes are given in steps of 0.2, and no earthquake is located in a gap of 40 degrees toward the sea."""
    x = draw(QUAKE, rng, 6000, 1.1, 10.0)
    x[:, 0] = 0.2 * np.rint(x[:, 0] / 0.2)
    return x[(x[:, 3] < 205) | (x[:, 3] > 245)]


@case(QUAKE, "outside")
def quake_swapped_columns(rng):
    """One of the agencies sends depth and distance in the wrong order, in seven events of a hundred."""
    x = draw(QUAKE, rng, 3000, 0.95, 16.0)
    return either(some(rng, 3000, 0.07), x[:, [0, 2, 1, 3]], x)


@case(STEP)
def step_plain(rng):
    """A caribou that walks as the simulator has it."""
    return draw(STEP, rng, 1500, 260.0, 1.1)


@case(STEP, "single", ("mixture",), ("spread",))
def step_two_states(rng):
    """For a third of the time the elk is encamped, with short steps and hardly a direction (Morales 2004)."""
    return either(some(rng, 1000, 0.35), draw(STEP, rng, 1000, 90.0, 0.4), draw(STEP, rng, 1000, 320.0, 1.8))


@case(STEP, "single", ("conditional_response on turn",), ("correlation", "conditional_response on step"))
def step_slope(rng):
    """Along a shore to its left the animal turns further to the right the longer its step is."""
    x = draw(STEP, rng, 2500, 200.0, 2.0)
    x[:, 1] = (x[:, 1] - 0.2 * (x[:, 0] / 180 - 1) + np.pi) % (2 * np.pi) - np.pi
    return x


@case(STEP, "pair", ("mixture", "quantisation on turn"), ("spread",))
def step_by_map(rng):
    """Turns are read from a map in steps of 20 degrees, and a quarter of the steps belong to a state of rest."""
    x = either(some(rng, 5000, 0.25), draw(STEP, rng, 5000, 45.0, 0.4), draw(STEP, rng, 5000, 300.0, 1.8))
    x[:, 1] = np.radians((20 * np.rint(np.degrees(x[:, 1]) / 20) + 180) % 360 - 180)
    return x


@case(STEP, "outside")
def step_longest(rng):
    """Of the three steps of an hour only the longest is kept."""
    x = draw(STEP, rng, 4500, 180.0, 1.4).reshape(-1, 3, 2)
    return x[np.arange(1500), x[:, :, 0].argmax(axis=1)]


@case(CELL)
def cell_plain(rng):
    """Cells with the channels well apart."""
    return draw(CELL, rng, 20_000, 0.62, 4.2)


@case(CELL, "single", ("crosstalk on cd4",), ("offset on cd4", "correlation", "conditional_response on cd4"))
def cell_spillover(rng):
    """Two parts of a hundred of the light of each other dye fall into the channel of CD4 (Bagwell, Adams 1993)."""
    x = draw(CELL, rng, 3000, 0.5, 5.0)
    x[:, 1] += 0.02 * (x[:, 0] + x[:, 2])
    return x


@case(CELL, "single", ("saturation on cd8",))
def cell_last_channel(rng):
    """The converter of the channel of CD8 ends at 14."""
    x = draw(CELL, rng, 6000, 0.6, 5.5)
    x[:, 2] = np.minimum(x[:, 2], 14)
    return x


@case(CELL, "pair", ("crosstalk on cd8", "saturation on cd3"), ("offset on cd8", "correlation"))
def cell_compensation(rng):
    """Six parts of a hundred of the other dyes spill into the channel of CD8, and that of CD3 ends at 9."""
    x = draw(CELL, rng, 8000, 0.55, 6.0)
    x[:, 2] += 0.06 * (x[:, 0] + x[:, 1])
    x[:, 0] = np.minimum(x[:, 0], 9)
    return x


@case(CELL, "outside")
def cell_doublets(rng):
    """One event of sixteen is two cells that stick together, and their light adds up (Wersto 2001)."""
    x = draw(CELL, rng, 5000, 0.5, 4.5)
    return x + some(rng, 5000, 0.06)[:, None] * draw(CELL, rng, 5000, 0.5, 4.5)


@case(STAR)
def star_plain(rng):
    """A field without dust."""
    return draw(STAR, rng, 3000, 0.75, 0.3)


@case(STAR, "single", ("correlation",), ("resolution on z", "resolution on y"))
def star_two_arms(rng):
    """The bands z and y are taken by one arm, whose zero point shakes by 0.05 from exposure to exposure."""
    x = draw(STAR, rng, 2500, 0.6, 0.22)
    x[:, 3:] += rng.normal(0, 0.05, (2500, 1))
    return x


@case(STAR, "single", ("offset on i", "scale on i"))
def star_zero_point(rng):
    """The standard star of the band i was wrong by 0.015."""
    return draw(STAR, rng, 1500, 0.7, 0.25) + np.array([0, 0, 0.015, 0, 0])


@case(STAR, "pair", ("outliers on g", "saturation on z"))
def star_limit(rng):
    """Two stars of a hundred are spoilt in g, and who is fainter than 19.95 in z is given that limit."""
    x = draw(STAR, rng, 4000, 0.6, 0.3)
    x[:, 0] += some(rng, 4000, 0.02) * rng.normal(0, 2.0, 4000)
    x[:, 3] = np.minimum(x[:, 3], 19.95)
    return x


@case(STAR, "outside")
def star_pairs(rng):
    """A fifth of the stars are two in one image, whose fluxes add up in each band."""
    x, y = draw(STAR, rng, 4000, 0.65, 0.3), draw(STAR, rng, 4000, 0.65, 0.3)
    return either(some(rng, 4000, 0.2), -2.5 * np.log10(10 ** (-0.4 * x) + 10 ** (-0.4 * y)), x)


@case(CLAIM)
def claim_plain(rng):
    """Claims as the simulator has them."""
    return draw(CLAIM, rng, 8000, 1.1, 40.0, 0.9)


@case(CLAIM, "single", ("edge_acceptance on amount",), ("dead_region on amount",))
def claim_deductible(rng):
    """Who has a deductible of one thousand mostly does not report a smaller loss (Klugman 2012)."""
    x = draw(CLAIM, rng, 5000, 1.0, 50.0, 1.2)
    return x[(x[:, 0] > rng.normal(1.0, 0.25, 5000))]


@case(CLAIM, "single", ("conditional_response on amount",), ("correlation", "conditional_response on delay"))
def claim_late_ones(rng):
    """A claim that comes later is larger, by a thousand for two months of delay."""
    x = draw(CLAIM, rng, 3000, 1.3, 60.0, 0.8)
    x[:, 0] += x[:, 1] / 60
    return x


@case(CLAIM, "pair", ("saturation on amount", "quantisation on delay"))
def claim_limit(rng):
    """The policy pays ten thousand at most, and delays are known in whole weeks."""
    x = draw(CLAIM, rng, 4000, 1.4, 45.0, 1.0)
    return np.stack([np.minimum(x[:, 0], 10), 7 * np.ceil(x[:, 1] / 7), x[:, 2]], axis=1)


@case(BURST)
def burst_plain(rng):
    """One conformation of a molecule."""
    return draw(BURST, rng, 2500, 0.35, 40.0)


@case(BURST, "single", ("spread",), ("correlation", "mixture"))
def burst_dynamics(rng):
    """The efficiency is not the same in each molecule but has a spread of 0.05, as of a soft linker (Kalinin 2010)."""
    return _burst(np.stack([rng.beta(52, 48, 2500), np.full(2500, 35.0)], axis=1), rng)


@case(BURST, "single", ("mixture",), ("spread", "correlation"))
def burst_two_shapes(rng):
    """One molecule of four is folded and has an efficiency of 0.6, and the others have one of 0.3."""
    return either(some(rng, 1200, 0.25), draw(BURST, rng, 1200, 0.6, 45.0), draw(BURST, rng, 1200, 0.3, 45.0))


@case(BURST, "pair", ("spread", "quantisation on length"), ("mixture", "correlation"))
def burst_slow_clock(rng):
    """The clock has ticks of 0.25 ms, and the brightness differs with the place of a molecule in the focus."""
    n = 6000
    x = _burst(np.stack([np.full(n, 0.5), 32 * np.exp(rng.normal(-0.04, 0.28, n))], axis=1), rng)
    x[:, 2] = 0.25 * np.rint(x[:, 2] / 0.25)
    return x


@case(BURST, "outside")
def burst_bleaching(rng):
    """In an eighth of the bursts the acceptor bleaches at some moment, and from then on the donor alone shines."""
    x, lit = draw(BURST, rng, 1500, 0.6, 45.0), np.where(some(rng, 1500, 0.125), rng.random(1500), 1)
    acceptor = rng.binomial(x[:, 1].astype(int), lit)
    return np.stack([x[:, 0] + x[:, 1] - acceptor, acceptor, x[:, 2]], axis=1)


@case(ARROW)
def arrow_plain(rng):
    """An archer whose sight is off to the left."""
    return draw(ARROW, rng, 600, -2.5, 5.0)


@case(ARROW, "single", ("spread",), ("outliers on x", "outliers on y", "mixture"))
def arrow_fatigue(rng):
    """The scatter of an archer is not the same in each round, with a variation of 0.4."""
    return _arrow(np.stack([np.full(3000, 1.0), 5 * np.exp(rng.normal(-0.08, 0.4, 3000))], axis=1), rng)


@case(ARROW, "single", ("charge_misid on x", "mixture"))
def arrow_from_behind(rng):
    """One arrow of eight is measured from behind the target, where left is right."""
    x = draw(ARROW, rng, 2500, 4.5, 3.0)
    x[:, 0] *= np.where(some(rng, 2500, 0.12), -1, 1)
    return x


@case(ARROW, "pair", ("offset on y", "dead_region on x"))
def arrow_sight(rng):
    """The sight is 1.2 cm too low, so that arrows hit high, and arrows that hit the stand at 5 to 8 cm bounce off."""
    x = draw(ARROW, rng, 4000, 1.0, 5.5) + np.array([0, 1.2, 0])
    return x[(x[:, 0] < 5) | (x[:, 0] > 8)]


@case(ARROW, "outside")
def arrow_worse_of_two(rng):
    """Of two arrows only that which hits further from the middle is scored."""
    x, y = draw(ARROW, rng, 1500, 0.5, 5.0), draw(ARROW, rng, 1500, 0.5, 5.0)
    return either(np.hypot(x[:, 0], x[:, 1]) > np.hypot(y[:, 0], y[:, 1]), x, y)


CASES: list[Case] = [c for c in list(globals().values()) if isinstance(c, Case)]
