"""Simulated cases of several features: wind turbines, mud in a river, orbits of asteroids, traffic."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator


def wind_and_power(theta: NDArray, rng: Rng) -> NDArray:
    """Return the wind at a turbine and its power, which starts at 3 m/s and is full from 12 m/s on."""
    wind = theta[:, 0] * rng.weibull(theta[:, 1])
    share = np.clip((wind**3 - 27) / (12**3 - 27), 0, 1)
    return np.stack([wind, theta[:, 2] * share + theta[:, 3] * rng.standard_normal(len(theta))], axis=1)


def banks(theta: NDArray, rng: Rng) -> NDArray:
    """Return the mud in the water at the left bank, in the middle, and at the right bank of a river."""
    common = rng.normal(np.log(theta[:, 0]), theta[:, 1])
    return np.exp(common[:, None] + theta[:, 2:3] * rng.standard_normal((len(theta), 3)))


def orbit(theta: NDArray, rng: Rng) -> NDArray:
    """Return half the long axis of an asteroid of the main belt, its eccentricity and its inclination."""
    axis = 2.1 + 1.2 * rng.beta(theta[:, 0], theta[:, 1])
    return np.stack([axis, rng.rayleigh(theta[:, 2]), rng.rayleigh(theta[:, 3])], axis=1)


def minute(theta: NDArray, rng: Rng) -> NDArray:
    """Return how many vehicles pass in a minute, and their mean speed, which falls with their number."""
    vehicles = rng.poisson(theta[:, 0])
    return np.stack([vehicles, rng.normal(theta[:, 1] - theta[:, 2] * vehicles, theta[:, 3])], axis=1)


TURBINE = task(
    wind_and_power,
    prior={"scale": (5, 12), "shape": (1.4, 3), "rated": (1200, 3200), "noise": (20, 150)},
    features=["wind", "power"],
    name="wind-turbine",
)
RIVER = task(
    banks,
    prior={"median": (20, 400), "common": (0.1, 1), "local": (0.05, 0.6)},
    features=["left", "middle", "right"],
    name="mud-in-a-river",
)
ASTEROIDS = task(
    orbit,
    prior={"inner": (1, 5), "outer": (1, 5), "eccentricity": (0.05, 0.2), "inclination": (3, 14)},
    features=["axis", "eccentricity", "inclination"],
    name="asteroid-orbits",
)
TRAFFIC = task(
    minute,
    prior={"flow": (4, 30), "free": (70, 130), "slowing": (0.2, 2.5), "noise": (2, 12)},
    features=["vehicles", "speed"],
    kinds={"vehicles": "count"},
    name="traffic",
)


@case(
    TURBINE,
    "single",
    right=("scale on wind",),
    defensible=("conditional_response on power", "offset on wind", "crosstalk on wind"),
)
def turbine_with_a_slow_anemometer(rng: Rng) -> NDArray:
    """The anemometer behind the rotor reads 7 % too little, and 2 % less than that in the strongest winds.

    The curve of the power, which is known, ties the wind to the power.
    """
    x = draw(TURBINE, rng, 2300, 8.4, 2.1, 2050.0, 55.0)
    x[:, 0] *= 0.93 - 0.02 / (1 + np.exp(-(x[:, 0] - 15.0)))
    return x


@case(
    TURBINE,
    "single",
    right=("conditional_response on power",),
    defensible=("scale on power", "offset on power", "radiative_tail on power", "crosstalk on power"),
)
def turbine_in_a_wake(rng: Rng) -> NDArray:
    """In winds of 6 to 11 m/s the turbine stands in the wake of another one: it loses 3 to 20 % of its power.

    In stronger winds the wake is blown apart, and at full power nothing is lost.
    """
    n = 1000
    x = draw(TURBINE, rng, n, 9.1, 1.9, 1650.0, 40.0)
    loss = rng.uniform(0.03, 0.2, n) * np.exp(-(((x[:, 0] - 8.5) / 2.2) ** 4))
    x[:, 1] *= np.where(x[:, 1] > 0, 1 - loss, 1.0)
    return x


@case(TURBINE, "outside")
def turbine_with_rows_out_of_step(rng: Rng) -> NDArray:
    """Two tables were joined by a clock of which one was late: in half of the rows the power is that of the row before.

    Powers are exchanged between events. What each feature shows by itself is as it was, down to the last digit.
    """
    n = 3000
    x = draw(TURBINE, rng, n, 7.6, 2.0, 2300.0, 70.0)
    late = np.arange(n) >= n // 2
    x[late, 1] = np.roll(x[late, 1], 1)
    return x


@case(
    RIVER,
    "single",
    right=("crosstalk on middle",),
    defensible=("scale on middle", "offset on middle", "correlation", "conditional_response on middle"),
)
def river_with_an_unwashed_bottle(rng: Rng) -> NDArray:
    """The bottle is not washed between the left bank and the middle: up to a fifth of the mud of the left is added."""
    n = 740
    x = draw(RIVER, rng, n, 120.0, 0.5, 0.3)
    x[:, 1] += 0.2 * rng.beta(4.0, 2.0, n) * x[:, 0]
    return x


@case(
    RIVER,
    "pair",
    right=("correlation", "saturation on middle"),
    defensible=("resolution on left", "resolution on right", "conditional_response on middle"),
)
def river_of_two_samplers(rng: Rng) -> NDArray:
    """Both banks are sampled by one man in a boat, whose error they share; the middle by a probe on the bridge.

    The probe bends above 150 mg/l and ends near 260 mg/l.
    """
    n = 3900
    x = draw(RIVER, rng, n, 95.0, 0.6, 0.15)
    x[:, [0, 2]] *= np.exp(0.22 * rng.standard_t(8, n))[:, None]
    middle = x[:, 1]
    x[:, 1] = np.where(middle > 150, 150 + 110 * np.tanh((middle - 150) / 110), middle)
    return x


@case(RIVER, "outside")
def river_in_rising_order(rng: Rng) -> NDArray:
    """The laboratory sorts the three bottles of a day: the clearest is called left, and the muddiest right.

    The three values of an event are exchanged until they rise; the features are order statistics.
    """
    return np.sort(draw(RIVER, rng, 1400, 210.0, 0.4, 0.35), axis=1)


@case(ASTEROIDS, "single", right=("dead_region on axis",), defensible=("edge_acceptance on axis",))
def asteroids_with_gaps(rng: Rng) -> NDArray:
    """Jupiter has emptied the gap at 2.50 au of Kirkwood, in which the period is a third of its own.

    The gap is about 0.05 au wide, wider at its outer side, and one in twelve asteroids stays in it.
    """
    x = draw(ASTEROIDS, rng, 10500, 2.1, 2.4, 0.13, 7.5)
    inside = 1 / (1 + np.exp(-(x[:, 0] - 2.475) / 0.004)) / (1 + np.exp((x[:, 0] - 2.53) / 0.009))
    return x[rng.random(len(x)) > 0.92 * inside]


@case(
    ASTEROIDS,
    "single",
    right=("resolution on eccentricity",),
    defensible=("outliers on eccentricity", "conditional_response on eccentricity", "spread"),
)
def asteroids_of_short_arcs(rng: Rng) -> NDArray:
    """Eccentricities of asteroids that were seen for few nights are known to 0.08 or worse, and may be negative.

    The error grows with the distance, and is of two sizes: 0.06 after a month and 0.12 after a week.
    """
    n = 6100
    x = draw(ASTEROIDS, rng, n, 1.8, 3.0, 0.1, 9.0)
    x[:, 1] += x[:, 0] / 2.6 * np.where(some(rng, n, 0.6), 0.06, 0.12) * rng.standard_normal(n)
    return x


@case(
    ASTEROIDS,
    "pair",
    right=("edge_acceptance on axis", "outliers on inclination"),
    defensible=("mixture", "flat_background", "radiative_tail on inclination", "spread"),
)
def asteroids_far_or_retrograde(rng: Rng) -> NDArray:
    """Beyond 2.95 au asteroids are too faint for the survey: within 0.05 au the share that is seen falls to a tenth.

    In 2 % of the orbits two nights were mixed up, and the inclination is wrong by tens of degrees.
    """
    n = 9600
    x = draw(ASTEROIDS, rng, n, 1.6, 1.5, 0.14, 6.0)
    x = x[rng.random(n) < 0.1 + 0.9 / (1 + np.exp((x[:, 0] - 2.95) / 0.012))]
    x[:, 2] = np.abs(x[:, 2] + some(rng, len(x), 0.02) * 30 * rng.standard_t(4, len(x)))
    return x


@case(
    TRAFFIC,
    "single",
    right=("mixture",),
    defensible=("conditional_response on speed", "spread", "radiative_tail on speed", "second_exponential on speed"),
)
def traffic_with_rain(rng: Rng) -> NDArray:
    """In one minute of eight it rains: the free speed is 22 km/h lower, the noise is larger, and fewer are on the road.

    Everything else is as the simulator says, at another point of its parameters.
    """
    n = 3400
    dry, wet = draw(TRAFFIC, rng, n, 16.0, 108.0, 0.9, 5.0), draw(TRAFFIC, rng, n, 12.5, 86.0, 0.9, 8.0)
    return either(some(rng, n, 0.125), wet, dry)


@case(
    TRAFFIC,
    "pair",
    right=("double_counting on vehicles", "radiative_tail on speed"),
    defensible=("overdispersion on vehicles", "second_exponential on speed", "mixture", "spread"),
)
def traffic_with_trailers_and_ramps(rng: Rng) -> NDArray:
    """A fifth of the vehicles has a trailer or a second axle that the loop reads as another, 4 % of them as two more.

    In one minute of nine somebody who joins from the ramp brakes the others, by an exponential 16 km/h.
    """
    n = 4400
    x = draw(TRAFFIC, rng, n, 13.0, 100.0, 0.6, 4.0)
    vehicles = x[:, 0].astype(int)
    x[:, 0] += rng.binomial(vehicles, 0.2) + 2 * rng.binomial(vehicles, 0.04)
    x[:, 1] -= some(rng, n, 1 / 9) * rng.exponential(16.0, n)
    return x


@case(TRAFFIC, "outside")
def traffic_with_a_short_counter(rng: Rng) -> NDArray:
    """The counter has five digits of two: after 31 vehicles it starts again at 0, and a full minute reads 3.

    The slow speed still tells the full minute. Nothing is cut at a limit, lost or missed: the scale comes round.
    """
    x = draw(TRAFFIC, rng, 2000, 25.5, 118.0, 1.4, 6.0)
    x[:, 0] %= 32
    return x


CASES: list[Case] = [
    plain("turbine_alone", TURBINE, 1700, 6.7, 1.8, 2800.0, 95.0),
    plain("river_alone", RIVER, 450, 70.0, 0.75, 0.2),
    plain("asteroids_alone", ASTEROIDS, 21000, 2.6, 3.3, 0.09, 11.0),
    plain("traffic_alone", TRAFFIC, 7200, 8.5, 92.0, 1.8, 9.0),
    *(made for made in list(globals().values()) if isinstance(made, Case)),
]
