"""Simulated cases of one real number: depths of snow, drops that freeze, prices in shops, wind seen by radar."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def snow(theta: NDArray, rng: Rng) -> NDArray:
    """Return the depth in cm of the snow where a probe is pushed down to the ground."""
    return rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1])


def freezing(theta: NDArray, rng: Rng) -> NDArray:
    """Return by how many kelvin a drop is supercooled when it freezes: nuclei act exponentially more with the cold."""
    return theta[:, 0] + theta[:, 1] * np.log(rng.standard_exponential(len(theta)))


def repricing(theta: NDArray, rng: Rng) -> NDArray:
    """Return by how many log points (about per cent) a shop changes a price: rises and cuts are exponential."""
    up = rng.random(len(theta)) < theta[:, 0]
    return np.where(up, theta[:, 1], -theta[:, 2]) * rng.standard_exponential(len(theta))


def doppler(theta: NDArray, rng: Rng) -> NDArray:
    """Return the speed in m/s away from a radar that turns: the wind along the beam, and turbulence."""
    azimuth = rng.uniform(0, 2 * np.pi, len(theta))
    return theta[:, 0] * np.cos(azimuth) + theta[:, 1] * rng.standard_normal(len(theta))


SNOW = task(snow, prior={"mean": (30, 250), "shape": (1.5, 12)}, features=["depth"], name="snow-depths")
DROPS = task(freezing, prior={"level": (12, 32), "width": (0.5, 3.5)}, features=["supercooling"], name="freezing-drops")
PRICES = task(
    repricing,
    prior={"rising": (0.2, 0.9), "rise": (2, 20), "cut": (2, 20)},
    features=["change"],
    name="price-changes",
)
RADAR = task(doppler, prior={"speed": (4, 30), "turbulence": (0.4, 4)}, features=["velocity"], name="radar-winds")


@case(SNOW, "single", right=("saturation", "censoring"), defensible=("peak_background",))
def snow_deeper_than_the_probe(rng: Rng) -> NDArray:
    """The probe is 2 m long. Where it does not reach the ground, the crew writes 200 cm, its length.

    One crew in eight has a probe of 280 cm. One in ten of the places where the probe is too short is left out.
    """
    n = 1930
    x = one(SNOW, rng, n, 130.0, 3.2)
    length = np.where(some(rng, n, 1 / 8), 280.0, 200.0)
    return np.minimum(x, length)[(x < length) | some(rng, n, 0.9)]


@case(SNOW, "single", right=("peak_background",), defensible=("mixture", "flat_background"))
def snow_stopped_by_a_crust(rng: Rng) -> NDArray:
    """Rain in January left a crust of ice, which now lies 48 to 62 cm deep. It stops the probe in one push of four.

    It is then taken for the ground. So a share of the depths forms a peak where the crust is. A thick crust stops
    more pushes than a thin one.
    """
    n = 550
    x = one(SNOW, rng, n, 125.0, 5.0)
    crust = rng.normal(55.0, 5.0, n)
    return np.where((x > crust) & (rng.random(n) < rng.beta(1.5, 4.5, n)), crust, x)


@case(SNOW, "outside")
def snow_beside_the_joints(rng: Rng) -> NDArray:
    """The probe is screwed together from pieces of 40 cm, and each joint covers 8 to 12 cm of the scale.

    Where the surface is at a joint, the nearest mark that can be seen is read, give or take 2 cm further off. So there
    is a gap at each joint, a crowd on both sides of it, and truth between: there are many gaps, and no steps.
    """
    n = 12000
    x = one(SNOW, rng, n, 115.0, 4.0)
    joint = 40.0 * np.round(x / 40.0)
    off, half = x - joint, rng.uniform(4.0, 6.0, n)
    hidden = (joint > 0) & (np.abs(off) < half)
    return np.where(hidden, joint + np.sign(off) * (half + 2.0 * rng.random(n)), x)


@case(DROPS, "single", right=("resolution",), defensible=("spread", "mixture", "offset"))
def drops_on_an_uneven_plate(rng: Rng) -> NDArray:
    """The sensor is in the middle of the cold plate, whose rim is warmer, by 4 to 5 K. Drops lie all over the plate.

    A drop at the rim seems to be colder than it is when it freezes. The error differs from drop to drop, as does that
    of the contact with the plate, 0.7 K: a smearing, though not about zero.
    """
    n = 2600
    x = one(DROPS, rng, n, 20.0, 0.9)
    return x + rng.uniform(4.0, 5.0, n) * rng.random(n) + rng.normal(0, 0.7, n)


@case(DROPS, "single", right=("dead_region",), defensible=())
def drops_behind_a_fogged_window(rng: Rng) -> NDArray:
    """Between about 21 and 23 K the window of the chamber fogs, until dry air has cleared it.

    Meanwhile the camera sees only drops near the middle. The others that freeze then are not counted. Fog comes and
    goes earlier in some runs than in others.
    """
    n = 1190
    x = one(DROPS, rng, n, 24.0, 2.1)
    fogged = (x > rng.normal(21.1, 0.25, n)) & (x < rng.normal(23.2, 0.35, n))
    return x[~fogged | some(rng, n, 0.2)]


@case(
    DROPS,
    "pair",
    right=("mixture", "quantisation"),
    defensible=("heaping", "flat_background", "peak_background", "second_exponential", "radiative_tail"),
)
def drops_with_dust_photographed_each_kelvin(rng: Rng) -> NDArray:
    """Dust fell into one drop of five, and lets it freeze some 9 K earlier: a second population, and a wider one.

    In five plates of six there is a picture for each kelvin of cooling, and a drop has the value of the first picture
    on which it is white. The last plate was filmed.
    """
    n = 4750
    dusty = one(DROPS, rng, n, 18.5, 2.6)
    x = np.where(some(rng, n, 0.2), dusty, one(DROPS, rng, n, 27.5, 1.5))
    return np.where(some(rng, n, 5 / 6), np.ceil(x), x)


@case(PRICES, "single", right=("outliers",), defensible=("flat_background", "mixture", "spread", "resolution"))
def prices_of_goods_replaced(rng: Rng) -> NDArray:
    """When a product is no longer sold, its number on the list goes to another one: one change in ten.

    The change is then mostly the ratio of the prices of two products, which may differ by a factor of two either way.
    """
    n = 750
    x = one(PRICES, rng, n, 0.62, 5.0, 6.5)
    return x + some(rng, n, 0.1) * rng.logistic(3.0, 28.0, n)


@case(
    PRICES,
    "pair",
    right=("dead_region", "edge_acceptance"),
    defensible=("analysis_window", "truncation", "turn_on"),
)
def prices_not_worth_it_or_not_believed(rng: Rng) -> NDArray:
    """New labels cost money, so that hardly a change below 1 to 3 per cent is made: a hole about zero.

    The office takes a change of more than about 25 per cent for an error and deletes it, by hand in the end, so that
    one in fifteen of them is kept: both ends are lost.
    """
    n = 8900
    x = one(PRICES, rng, n, 0.57, 11.0, 9.0)
    made = np.abs(x) > 1.8 * np.exp(rng.normal(0, 0.4, n))
    return x[made & ((np.abs(x) < rng.normal(25.0, 0.8, n)) | some(rng, n, 1 / 15))]


@case(PRICES, "outside")
def prices_set_by_the_head_office(rng: Rng) -> NDArray:
    """A chain sets one price for all of its shops, so that each change is in the list once for each shop that sells it.

    These are some 1200 decisions, copied 1 to 100 times or more to the last digit. Each is like those of the
    simulator, and none is in steps; but they are not independent, and clump at hundreds of places.
    """
    decisions = one(PRICES, rng, 1200, 0.66, 6.0, 9.5)
    return rng.permutation(np.repeat(decisions, rng.geometric(1 / rng.gamma(2.0, 11.0, 1200).clip(1.0))))


@case(RADAR, "single", right=("spread",), defensible=("mixture", "resolution", "peak_background", "scale"))
def radar_in_a_gusty_afternoon(rng: Rng) -> NDArray:
    """The wind freshens, gusts and calms while the radar turns: its speed is another one at each pulse.

    The simulator has the same wind for all. The speeds follow a Weibull law with a mean of 14 m/s.
    """
    n = 410
    speed = 15.8 * rng.weibull(2.3, n)
    return doppler(np.column_stack([speed, np.full(n, 0.9)]), rng)


@case(
    RADAR,
    "pair",
    right=("peak_background", "forward_backward_acceptance"),
    defensible=("edge_acceptance", "flat_background", "mixture"),
)
def radar_with_hills_and_a_shower(rng: Rng) -> NDArray:
    """One echo in fourteen is of hills, which do not move, or of the trees on them, which do a little: a peak at zero.

    A shower stands on the lee side and weakens the echoes behind it: where the wind blows away from the radar, some
    four in ten are too faint. The shower has no sharp rim.
    """
    n = 20000
    x = one(RADAR, rng, n, 15.0, 2.0)
    x = x[rng.random(n) > rng.uniform(0.3, 0.5, n) / (1 + np.exp(-(x - 1.0) / 1.5))]
    trees = some(rng, len(x), 0.4)
    return np.where(some(rng, len(x), 1 / 14), rng.normal(0, np.where(trees, 0.9, 0.25)), x)


@case(RADAR, "outside")
def radar_folded_at_nyquist(rng: Rng) -> NDArray:
    """With few pulses a second a speed is known up to multiples of 32 m/s: 18 m/s away reads as 14 m/s back.

    The program unfolds one such value in four, where its neighbours are right. One scan in six has more pulses.
    What is beyond an end comes in again at the other one, by which no limit, loss or exchange of signs is told.
    """
    n = 3500
    x = one(RADAR, rng, n, 21.0, 1.6)
    folded = (x + 16.0) % 32.0 - 16.0
    return np.where(some(rng, n, 0.75 * 5 / 6), folded, x)


CASES: list[Case] = [
    plain("snow_by_itself", SNOW, 310, 90.0, 2.6),
    plain("drops_of_pure_water", DROPS, 1400, 25.0, 1.3),
    plain("prices_changed_freely", PRICES, 22000, 0.55, 7.5, 10.0),
    plain("radar_on_a_clear_day", RADAR, 8800, 11.0, 1.4),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
