"""Simulated cases of several features: a probe in the sea, obsidian, a power grid, must of grapes."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator


def scan(theta: NDArray, rng: Rng) -> NDArray:
    """Return the depth of a probe in the sea, the temperature, which falls at a thermocline, and the salinity."""
    n = len(theta)
    depth = rng.uniform(5.0, 200.0, n)
    warm = (theta[:, 0] - 8.0) / (1 + np.exp((depth - theta[:, 1]) / 14.0))
    temperature = 8.0 + warm + 0.2 * rng.standard_normal(n)
    return np.stack([depth, temperature, 35.2 - theta[:, 2] * warm + 0.08 * rng.standard_normal(n)], axis=1)


def artefact(theta: NDArray, rng: Rng) -> NDArray:
    """Return five elements in an artefact of obsidian, in ppm: each scatters by itself, and a little all together."""
    n = len(theta)
    size = 1 + 0.03 * rng.standard_normal(n)
    part = 1 + theta[:, 3:4] * rng.standard_normal((n, 5))
    mean = np.stack([theta[:, 0], theta[:, 1], 0.12 * theta[:, 0] + 8, theta[:, 2], 0.05 * theta[:, 2] + 6], axis=1)
    return mean * size[:, None] * part


def second(theta: NDArray, rng: Rng) -> NDArray:
    """Return the load of a grid in MW over the day, the voltage in kV, which falls with it, and the frequency in mHz.

    The frequency is what it is above 50 Hz.
    """
    n = len(theta)
    day = theta[:, 0] * (1 + theta[:, 1] * np.sin(2 * np.pi * rng.random(n)))
    load = day * (1 + 0.04 * rng.standard_normal(n))
    voltage = 112.0 - theta[:, 2] * load / 100 + 0.35 * rng.standard_normal(n)
    return np.stack([load, voltage, theta[:, 3] * rng.standard_normal(n)], axis=1)


def lot(theta: NDArray, rng: Rng) -> NDArray:
    """Return the sugar of a lot of grapes in degrees Brix, the acid in g/l, which falls as it ripens, and the pH."""
    n = len(theta)
    ripe = theta[:, 1] * rng.standard_normal(n)
    acid = theta[:, 2] * np.exp(-0.06 * ripe + 0.14 * rng.standard_normal(n))
    return np.stack([theta[:, 0] + ripe, acid, 4.55 - 0.55 * np.log(acid) + 0.05 * rng.standard_normal(n)], axis=1)


SEA = task(
    scan,
    prior={"surface": (12, 26), "thermocline": (40, 120), "fresher": (-0.1, 0.2)},
    features=["depth", "temperature", "salinity"],
    name="probe-in-the-sea",
)
OBSIDIAN = task(
    artefact,
    prior={"rubidium": (80, 260), "strontium": (30, 220), "zirconium": (70, 350), "scatter": (0.03, 0.2)},
    features=["rubidium", "strontium", "yttrium", "zirconium", "niobium"],
    name="obsidian",
)
GRID = task(
    second,
    prior={"load": (200, 900), "swing": (0.05, 0.5), "droop": (0.1, 1), "wander": (8, 60)},
    features=["load", "voltage", "frequency"],
    name="power-grid",
)
MUST = task(
    lot,
    prior={"brix": (17, 26), "ripeness": (0.6, 3), "acid": (4, 12)},
    features=["sugar", "acid", "ph"],
    name="must-of-grapes",
)


@case(
    SEA,
    "single",
    right=("correlation",),
    defensible=("resolution on temperature", "resolution on salinity", "crosstalk on salinity", "spread"),
)
def sea_with_a_slow_thermometer(rng: Rng) -> NDArray:
    """Salinity is computed from the conductivity and the temperature: what the thermometer misses enters both.

    The ship heaves, and the thermometer lags by 0.3 degrees up or down: salinity then errs by 0.9 times that, the
    other way. In calm weather, a third of the time, the lag is a third.
    """
    n = 1400
    x = draw(SEA, rng, n, 18.0, 70.0, 0.05)
    lag = np.where(some(rng, n, 1 / 3), 0.1, 0.3) * rng.standard_normal(n)
    x[:, 1] += lag
    x[:, 2] -= 0.9 * lag
    return x


@case(
    SEA,
    "single",
    right=("mixture",),
    defensible=("conditional_response on temperature", "conditional_response on salinity", "spread", "correlation"),
)
def sea_of_two_waters(rng: Rng) -> NDArray:
    """One cast in eight was made beyond a front: the water there is 5 degrees colder, and fresher, to a greater depth.

    It is as the simulator says, at another point of its parameters. The front itself is narrow.
    """
    n = 560
    here, there = draw(SEA, rng, n, 22.0, 62.0, 0.02), draw(SEA, rng, n, 17.0, 98.0, 0.13)
    return either(some(rng, n, 0.125), there, here)


@case(
    SEA,
    "pair",
    right=("scale on depth", "radiative_tail on salinity"),
    defensible=("outliers on salinity", "conditional_response on temperature", "offset on depth", "second_exponential"),
)
def sea_with_a_slanting_wire(rng: Rng) -> NDArray:
    """Depth is the length of the wire, which slants in the current: it is too large by 6 to 12 %.

    Bubbles in the cell of the conductivity make 7 % of the salinities too low, by an exponential 0.7.
    """
    n = 6500
    x = draw(SEA, rng, n, 20.0, 85.0, 0.07)
    x[:, 0] *= rng.uniform(1.06, 1.12, n)
    x[:, 2] -= some(rng, n, 0.07) * rng.exponential(0.7, n)
    return x


@case(
    OBSIDIAN,
    "single",
    right=("crosstalk on zirconium",),
    defensible=("correlation", "scale on zirconium", "offset on zirconium", "conditional_response on zirconium"),
)
def obsidian_with_lines_that_overlap(rng: Rng) -> NDArray:
    """A weaker line of strontium lies under the line of zirconium, and was not taken off: 17 to 23 % of it is added.

    How much depends on how sharp the spectrum is, which the temperature of the detector says.
    """
    n = 2600
    x = draw(OBSIDIAN, rng, n, 130.0, 185.0, 105.0, 0.11)
    x[:, 3] += rng.uniform(0.17, 0.23, n) * x[:, 1]
    return x


@case(
    OBSIDIAN,
    "pair",
    right=("mixture", "quantisation on strontium"),
    defensible=("heaping on strontium", "peak_background", "flat_background", "spread", "correlation"),
)
def obsidian_of_another_island(rng: Rng) -> NDArray:
    """One artefact in nine is of obsidian from another island, with half the strontium and more zirconium.

    The older of two laboratories, which measured six in ten, gives strontium in steps of 10 ppm, and of 20 above 120.
    """
    n = 4800
    here, there = draw(OBSIDIAN, rng, n, 150.0, 115.0, 140.0, 0.06), draw(OBSIDIAN, rng, n, 175.0, 62.0, 200.0, 0.06)
    x = either(some(rng, n, 1 / 9), there, here)
    step = np.where(x[:, 1] > 120, 20.0, 10.0)
    x[:, 1] = np.where(some(rng, n, 0.6), step * np.round(x[:, 1] / step), x[:, 1])
    return x


@case(OBSIDIAN, "outside")
def obsidian_brought_to_one_sum(rng: Rng) -> NDArray:
    """To take out the thickness of a flake, the five elements were scaled until their sum was 520 ppm in each.

    So none is free of the others: what one has more, the others have less, and all events lie on one plane.
    No error is added or shared: one is taken away, and with it a part of what was true.
    """
    x = draw(OBSIDIAN, rng, 1900, 165.0, 90.0, 210.0, 0.12)
    return 520.0 * x / x.sum(axis=1, keepdims=True)


@case(GRID, "single", right=("dead_region on frequency",), defensible=("mixture", "spread", "saturation on frequency"))
def grid_logged_when_off(rng: Rng) -> NDArray:
    """To save room the logger writes a line only if the frequency is off: by 10 mHz, or 14 in the newer stations.

    Within that band a line is written now and then, one in twelve, as a sign of life.
    """
    n = 13500
    x = draw(GRID, rng, n, 540.0, 0.25, 0.4, 24.0)
    band = np.where(some(rng, n, 0.4), 14.0, 10.0)
    inside = 1 / (1 + np.exp((np.abs(x[:, 2]) - band) / 0.8))
    return x[rng.random(n) > inside * 11 / 12]


@case(
    GRID,
    "single",
    right=("forward_backward_acceptance on frequency",),
    defensible=("edge_acceptance on frequency", "offset on frequency"),
)
def grid_with_alarms_for_low(rng: Rng) -> NDArray:
    """Low frequency raises an alarm, and its lines are all kept; of those above 50 Hz almost half were deleted.

    About 50 Hz the choice goes over from one to the other within some mHz, as the relays differ by that.
    """
    n = 960
    x = draw(GRID, rng, n, 330.0, 0.4, 0.7, 19.0)
    return x[rng.random(n) > 0.45 / (1 + np.exp(-x[:, 2] / 2.5))]


@case(GRID, "outside")
def grid_with_a_tap_changer(rng: Rng) -> NDArray:
    """The transformer changes its tap by 1.6 kV, once or more, until the voltage is between 109.2 and 110.8 kV.

    The voltage so comes back at the other end of the band. It still falls with the load between two changes, as a saw.
    Neither is a voltage kept at a limit, nor lost.
    """
    x = draw(GRID, rng, 10000, 620.0, 0.35, 0.6, 33.0)
    x[:, 1] = 109.2 + (x[:, 1] - 109.2) % 1.6
    return x


@case(
    MUST,
    "single",
    right=("conditional_response on acid",),
    defensible=("scale on acid", "crosstalk on acid", "conditional_response on ph", "offset on acid"),
)
def must_titrated_too_far(rng: Rng) -> NDArray:
    """In ripe must, which is dark, the change of colour is seen late: the acid is read 10 to 30 % too high.

    That sets in about 22.5 degrees Brix, with the variety a little earlier or later. The pH is read by an electrode.
    """
    n = 700
    x = draw(MUST, rng, n, 21.5, 1.7, 7.2)
    ripe = 1 / (1 + np.exp(-(x[:, 0] - rng.normal(22.5, 0.4, n)) / 0.3))
    x[:, 1] *= 1 + rng.uniform(0.1, 0.3, n) * ripe
    return x


@case(
    MUST,
    "pair",
    right=("edge_acceptance on sugar", "outliers on ph"),
    defensible=("turn_on on sugar", "truncation on sugar", "radiative_tail on ph", "mixture", "resolution on ph"),
)
def must_of_ripe_lots_and_old_buffers(rng: Rng) -> NDArray:
    """The cooperative pays little below 19.5 degrees Brix, and growers wait: nine in ten such lots do not come in.

    On 3 % of the days the electrode was set with old buffers, and the pH is off by some tenths, up or down.
    """
    n = 19000
    x = draw(MUST, rng, n, 20.6, 1.5, 8.4)
    x = x[rng.random(n) < 0.1 + 0.9 / (1 + np.exp(-(x[:, 0] - 19.5) / 0.12))]
    x[:, 2] += some(rng, len(x), 0.03) * 0.35 * rng.standard_t(5, len(x))
    return x


@case(MUST, "outside")
def must_from_tanks_of_four_lots(rng: Rng) -> NDArray:
    """The sample is taken from the tank after four lots of grapes have run together: it is the mean of them.

    Sugar and acid mix in proportion, the pH nearly so. All scatter is halved, that of the laboratory too.
    """
    n = 3500
    return draw(MUST, rng, 4 * n, 22.8, 2.4, 6.1).reshape(n, 4, 3).mean(axis=1)


CASES: list[Case] = [
    plain("sea_alone", SEA, 300, 15.0, 95.0, 0.1),
    plain("obsidian_alone", OBSIDIAN, 410, 210.0, 55.0, 160.0, 0.08),
    plain("grid_alone", GRID, 28000, 710.0, 0.15, 0.8, 41.0),
    plain("must_alone", MUST, 21000, 24.0, 1.1, 5.2),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
