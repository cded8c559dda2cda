"""Simulated cases of one real number: lives of batteries, grades of ore, delays of buses, anomalies of gravity."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, one, plain, some

Rng = np.random.Generator


def life(theta: NDArray, rng: Rng) -> NDArray:
    """Return the hours that a battery lasts."""
    return theta[:, 0] * rng.weibull(theta[:, 1])


def grade(theta: NDArray, rng: Rng) -> NDArray:
    """Return the gold in a sample of ore."""
    return theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta)))


def delay(theta: NDArray, rng: Rng) -> NDArray:
    """Return by how much a bus is late: a normal part, and an exponential one of what happens on its way."""
    return rng.normal(theta[:, 0], theta[:, 1]) + rng.exponential(theta[:, 2])


def anomaly(theta: NDArray, rng: Rng) -> NDArray:
    """Return the gravity at a station, less that of the model of the Earth."""
    return rng.normal(theta[:, 0], theta[:, 1])


BATTERY = task(life, prior={"scale": (20, 80), "shape": (1.2, 7)}, features=["life"], name="battery-life")
ORE = task(grade, prior={"median": (0.4, 8), "log_width": (0.3, 1.5)}, features=["gold"], name="ore-grades")
BUS = task(delay, prior={"mean": (-2, 4), "width": (0.4, 3), "tail": (0.5, 8)}, features=["delay"], name="bus-delays")
GRAVITY = task(anomaly, prior={"mean": (-50, 50), "width": (4, 40)}, features=["anomaly"], name="gravity-survey")


@case(
    BATTERY,
    "single",
    right=("second_exponential",),
    defensible=("mixture", "radiative_tail", "flat_background", "spread", "outliers"),
)
def batteries_that_die_early(rng: Rng) -> NDArray:
    """Seven batteries in a hundred have a flaw of the seal and die early, at a rate that is constant.

    The first half hour, in which they are formed in the factory, is not part of the test.
    """
    n = 1050
    early = 0.5 + rng.exponential(7.0, n)
    x = one(BATTERY, rng, n, 52.0, 5.2)
    return np.where(some(rng, n, 0.07), np.minimum(early, x), x)


@case(BATTERY, "single", right=("quantisation",))
def batteries_looked_at_by_day(rng: Rng) -> NDArray:
    """The batteries are looked at by day: at 8, 12, 16 and 20 o'clock, so that a life is known in uneven steps.

    The test starts at 8 o'clock; one in five runs on a logger that knows the time to a minute.
    """
    n = 1300
    x = one(BATTERY, rng, n, 61.0, 2.4)
    looks = (np.arange(0, 400, 24.0)[:, None] + np.array([0, 4, 8, 12])).ravel()
    return np.where(some(rng, n, 0.2), x, looks[np.searchsorted(looks, x)])


@case(BATTERY, "outside")
def batteries_with_two_wires_exchanged(rng: Rng) -> NDArray:
    """Two data lines of the counter of hours are exchanged, those of 8 and of 16 hours.

    Lives between 8 and 16 h read 16 to 24 h and the other way round, and the same 32, 64, ... hours later: values are
    permuted in blocks, none is lost, added, smeared or rounded.
    """
    x = one(BATTERY, rng, 5600, 38.0, 3.0)
    block = np.floor(x / 8) % 4
    return x + 8.0 * (block == 1) - 8.0 * (block == 2)


@case(
    ORE,
    "single",
    right=("outliers",),
    defensible=("mixture", "radiative_tail", "spread", "second_exponential", "flat_background"),
)
def ore_with_smeared_nuggets(rng: Rng) -> NDArray:
    """The crusher was not cleaned after rich samples: 3 % of the values are wrong by a factor of about ten or more.

    A third of these are too low instead, where the nugget stayed in the mill.
    """
    n = 1700
    x = one(ORE, rng, n, 1.9, 0.5)
    wrong = np.exp(rng.choice([1.0, -1.0], n, p=[0.67, 0.33]) * rng.gamma(6.0, 0.4, n))
    return x * np.where(some(rng, n, 0.03), wrong, 1.0)


@case(ORE, "single", right=("saturation",), defensible=("peak_background", "edge_acceptance"))
def ore_over_the_range(rng: Rng) -> NDArray:
    """The instrument ends at 10 g/t, and what is beyond is reported as that; its answer bends from 7 g/t on.

    One rich sample in six is assayed again by fire, without a limit.
    """
    n = 31000
    x = one(ORE, rng, n, 3.1, 0.8)
    bent = np.where(x > 7, 7 + 3 * (1 - np.exp(-(x - 7) / 3)), x)
    return np.where(some(rng, n, 1 / 6), x, np.where(x > 10, 10.0, bent))


@case(ORE, "pair", right=("edge_acceptance", "quantisation"), defensible=("saturation",))
def ore_poor_not_sent_and_digits(rng: Rng) -> NDArray:
    """Samples that look poor are not sent to the laboratory: of those below 1 g/t only one in ten is.

    The laboratory gives two significant digits, in steps of 0.05, 0.2 or 1 g/t as it is below 2, below 8, or above.
    """
    x = one(ORE, rng, 6000, 1.9, 0.75)
    x = x[rng.random(len(x)) < 0.1 + 0.9 / (1 + np.exp(-(x - 1.0) / 0.06))]
    step = np.select([x < 2, x < 8], [0.05, 0.2], 1.0)
    return np.round(x / step) * step


@case(BUS, "single", right=("peak_background",), defensible=("mixture",))
def buses_that_wait(rng: Rng) -> NDArray:
    """A bus that is early waits at the stop for its time: four in five of those leave within seconds after it.

    Some drivers leave half a minute before it, so that the peak has a foot towards early.
    """
    n = 4700
    x = one(BUS, rng, n, 0.6, 1.5, 2.6)
    waits = (x < 0) & some(rng, n, 0.8)
    return np.where(waits, np.where(some(rng, n, 0.2), rng.normal(-0.5, 0.2, n), rng.gamma(2.0, 0.08, n)), x)


@case(
    BUS,
    "pair",
    right=("radiative_tail", "forward_backward_acceptance"),
    defensible=("outliers", "mixture", "edge_acceptance", "second_exponential", "spread"),
)
def buses_broken_down_or_early(rng: Rng) -> NDArray:
    """Breakdowns add a time with a tail of a power to 6 % of the delays: some exceed an hour.

    Of buses that are early only two in five are recorded, since the beacon is switched on when it is time.
    """
    n = 15000
    x = one(BUS, rng, n, -0.4, 1.8, 2.2)
    x = x + some(rng, n, 0.06) * 8.0 * (rng.pareto(1.7, n) + 0.3)
    return x[(x > 0) | some(rng, n, 0.4)]


@case(BUS, "outside")
def buses_given_to_the_next_trip(rng: Rng) -> NDArray:
    """A bus comes each 8 minutes, and the program takes the trip that is next in time to be the one that came.

    A bus that is 5 minutes late is so said to be 3 minutes early: delays come round, between -4 and 4 minutes.
    """
    x = one(BUS, rng, 8800, 0.3, 1.2, 3.0)
    return (x + 4) % 8 - 4


@case(GRAVITY, "single", right=("charge_misid",), defensible=("mixture", "peak_background", "flat_background"))
def gravity_without_the_minus(rng: Rng) -> NDArray:
    """Typists left out a minus that was faint: 6 % of the signs are wrong, but 16 % in one of four field books."""
    n = 560
    x = one(GRAVITY, rng, n, -31.0, 12.5)
    return np.where(some(rng, n, np.where(some(rng, n, 0.25), 0.16, 0.06)), -x, x)


@case(GRAVITY, "pair", right=("flat_background", "edge_acceptance"), defensible=("outliers", "mixture", "saturation"))
def gravity_of_two_instruments(rng: Rng) -> NDArray:
    """The dial ends: above 20 mGal stations are left out more and more, and from 26 mGal on almost all of them.

    An old map, from which 5 % were taken, holds anything between -110 and 110 mGal, falling slightly with the value.
    """
    n = 12000
    x = one(GRAVITY, rng, n, 8.0, 16.0)
    x = x[rng.random(n) < 1 / (1 + np.exp((x - 23.0) / 1.1))]
    flat = 220 * rng.beta(1.0, 1.25, len(x)) - 110
    return np.where(some(rng, len(x), 0.05), flat, x)


@case(GRAVITY, "outside")
def gravity_with_a_bent_screw(rng: Rng) -> NDArray:
    """The screw of the gravimeter is bent: its reading swings by 3.3 mGal about the truth in each turn of 11 mGal.

    Where it swings back, readings fall while gravity rises: a warp of the scale that is not monotone, and goes on
    over the whole range. No value is rounded, lost or added.
    """
    x = one(GRAVITY, rng, 5100, 12.0, 19.0)
    return x + 3.3 * np.sin(2 * np.pi * x / 11.0 + 0.7) + 0.5 * np.sin(4 * np.pi * x / 11.0)


CASES: list[Case] = [
    plain("batteries_alone", BATTERY, 380, 44.0, 1.9),
    plain("ore_alone", ORE, 17000, 1.2, 1.1),
    plain("buses_alone", BUS, 3600, 1.1, 0.9, 4.2),
    plain("gravity_alone", GRAVITY, 1150, -6.0, 21.0),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
