"""Cases of one real number: trees, a spectral line, calls, orbits of asteroids and a current of the sea."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, plain, some


def _tree(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Diameter of a tree of a stand of one age, by Weibull's law (Bailey and Dell 1973)."""
    return theta[:, 0] * rng.weibull(theta[:, 1])


TREE = task(
    _tree, prior={"scale": (12, 45), "shape": (1.2, 4)}, units={"scale": "cm"}, features=["diameter"], name="tree"
)


def _line(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Speed along the line of sight, by the Doppler shift of a photon of one line of hot gas."""
    return rng.normal(theta[:, 0], theta[:, 1])


LINE = task(
    _line,
    prior={"speed": (-30, 30), "width": (6, 30)},
    units={"speed": "km/s", "width": "km/s"},
    features=["speed"],
    name="line",
)


def _call(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Seconds of a telephone call, lognormal (Bolotin 1994)."""
    return theta[:, 0] * np.exp(theta[:, 1] * rng.normal(size=len(theta)))


CALL = task(
    _call, prior={"median": (30, 240), "width": (0.5, 1.5)}, units={"median": "s"}, features=["seconds"], name="call"
)


def _orbit(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Inclination of the orbit of an asteroid, by Rayleigh's law."""
    return rng.rayleigh(theta[:, 0])


ORBIT = task(_orbit, prior={"width": (3, 15)}, units={"width": "deg"}, features=["inclination"], name="orbit")


def _current(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Speed of the water along a strait at any time: a mean, the tide, and eddies."""
    mean, tide, eddies = theta.T
    return rng.normal(mean + tide * np.sin(rng.uniform(0, 2 * np.pi, len(theta))), eddies)


CURRENT = task(
    _current,
    prior={"mean": (-15, 15), "tide": (20, 60), "eddies": (2, 15)},
    units={"mean": "cm/s", "tide": "cm/s", "eddies": "cm/s"},
    features=["speed"],
    name="current",
)


# Nothing is missing.
trees_as_told = plain("trees_as_told", TREE, 1300, 24.0, 2.3)
line_as_told = plain("line_as_told", LINE, 21_000, -6.5, 14.2)
calls_as_told = plain("calls_as_told", CALL, 4400, 95.0, 1.12)
orbits_as_told = plain("orbits_as_told", ORBIT, 9100, 7.7)
current_as_told = plain("current_as_told", CURRENT, 600, 4.0, 37.0, 6.0)


# One effect.
@case(TREE, "single", ("truncation", "analysis_window"), ("turn_on", "edge_acceptance"))
def trees_above_limit(rng: np.random.Generator) -> NDArray:
    """An inventory takes trees of ten centimetres or more; its crews judge by eye, each with a limit of its own from
    nine to ten and a half."""
    diameter = draw(TREE, rng, 5000, 21.0, 1.6).ravel()
    return diameter[diameter > rng.choice([9.0, 9.6, 10.0, 10.5], 5000, p=[0.1, 0.2, 0.5, 0.2])]


@case(TREE, "single", ("turn_on", "forward_backward_acceptance"), ("edge_acceptance", "mixture"))
def trees_in_nested_plots(rng: np.random.Generator) -> NDArray:
    """Nested plots: trees below 18 cm are measured in the inner circle alone, of 0.45 of the area, and those below
    11 cm in one of 0.25 of it; nobody wrote down which."""
    diameter = draw(TREE, rng, 14_000, 24.0, 1.9).ravel()
    area = np.where(diameter < 11, 0.25, np.where(diameter < 18, 0.45, 1))
    return diameter[rng.random(14_000) < area]


@case(LINE, "single", ("radiative_tail",), ("mixture", "outliers", "flat_background", "second_exponential"))
def line_from_wind(rng: np.random.Generator) -> NDArray:
    """Photons of the line are scattered in a wind that flows out: a fifth come out redder, by one scattering with a
    mean of 22 km/s, or by two."""
    speed = draw(LINE, rng, 8500, 3.0, 11.0).ravel()
    times = rng.choice([0, 1, 2], 8500, p=[0.8, 0.14, 0.06])
    return speed + np.where(times > 0, rng.gamma(np.maximum(times, 1), 22.0), 0)


@case(CALL, "single", ("quantisation",), ("heaping", "censoring", "offset"))
def calls_as_billed(rng: np.random.Generator) -> NDArray:
    """Seconds as billed: at least thirty, and above that up to the next six (a 30/6 tariff)."""
    seconds = draw(CALL, rng, 3100, 110.0, 0.9).ravel()
    return np.maximum(30.0, 6 * np.ceil(seconds / 6))


@case(CALL, "single", ("second_exponential",), ("mixture", "peak_background", "flat_background"))
def calls_to_a_machine(rng: np.random.Generator) -> NDArray:
    """One call of seven reaches an answering machine: most callers hang up at once, by an exponential law of five
    seconds, a few after the tone."""
    seconds = draw(CALL, rng, 6400, 120.0, 0.75).ravel()
    short = rng.exponential(5.0, 6400) + np.where(some(rng, 6400, 0.1), 14.0, 0.0)
    return np.where(some(rng, 6400, 1 / 7), short, seconds)


@case(ORBIT, "single", ("peak_background",), ("mixture",))
def orbits_with_family(rng: np.random.Generator) -> NDArray:
    """A family of fragments of one body: eight in a hundred have ten degrees, with a core of 0.25 and a halo of a
    degree (Eos; Hirayama 1918)."""
    tilt = draw(ORBIT, rng, 10_500, 6.8).ravel()
    family = 10.1 + np.where(some(rng, 10_500, 0.7), 0.25, 1.0) * rng.normal(size=10_500)
    return np.where(some(rng, 10_500, 0.08), family, tilt)


@case(CURRENT, "single", ("charge_misid",), ("mixture", "outliers"))
def current_with_lost_signs(rng: np.random.Generator) -> NDArray:
    """The vane of the meter sticks at slack water, and then the speed is given the wrong sign, until it turns: one of
    seven above twenty, and one of four of the slow ones."""
    speed = draw(CURRENT, rng, 7200, 13.0, 34.0, 5.0).ravel()
    wrong = rng.random(7200) < np.where(np.abs(speed) > 20, 1 / 7, 1 / 4)
    return np.where(wrong, -speed, speed)


@case(CURRENT, "single", ("saturation",), ("censoring", "scale", "truncation"))
def current_by_old_propeller(rng: np.random.Generator) -> NDArray:
    """The propeller slips in fast water, in one direction more: the reading bends towards 52 cm/s with the flood, and
    towards 38 cm/s with the ebb."""
    speed = draw(CURRENT, rng, 6800, 2.0, 48.0, 8.0).ravel()
    limit = np.where(speed > 0, 52.0, 38.0)
    return speed / (1 + np.abs(speed / limit) ** 5) ** 0.2


# Two effects.
@case(LINE, "pair", ("dead_region", "flat_background"), ("mixture", "outliers", "peak_background"))
def line_on_the_ground(rng: np.random.Generator) -> NDArray:
    """Ozone of the air swallows nine of ten photons of a strip from 12 to 19 km/s; and an eighth are of the starlight
    below, that falls gently to the red over the range from -70 to 70."""
    speed = draw(LINE, rng, 13_500, 8.0, 13.0).ravel()
    light = 140 * np.minimum(rng.random(13_500), rng.uniform(0.3, 1.3, 13_500)) - 70
    speed = np.where(some(rng, 13_500, 0.125), light, speed)
    return speed[~((speed > 12) & (speed < 19) & some(rng, 13_500, 0.9))]


@case(CALL, "pair", ("heaping", "censoring"), ("quantisation", "saturation", "truncation"))
def calls_remembered(rng: np.random.Generator) -> NDArray:
    """Durations from a diary: four in ten are written in whole minutes, of the longer ones in steps of five; and the
    exchange cuts every call after ten minutes."""
    seconds = np.minimum(draw(CALL, rng, 4000, 160.0, 1.0).ravel(), 600.0)
    step = np.where(seconds > 300, 300.0, 60.0)
    rounded = np.maximum(step * np.round(seconds / step), 60.0)
    return np.where(some(rng, 4000, 0.4), rounded, seconds)


@case(CURRENT, "pair", ("outliers", "dead_region"), ("resolution", "flat_background", "mixture", "charge_misid"))
def current_with_weed(rng: np.random.Generator) -> NDArray:
    """Weed and fish disturb one reading of eighteen, with errors of a long-tailed law; and the rotor stands still
    below six centimetres a second, where no reading is kept."""
    speed = draw(CURRENT, rng, 9500, 5.0, 30.0, 9.0).ravel()
    speed = speed + np.where(some(rng, 9500, 0.055), 35 * rng.standard_t(2.5, 9500), 0.0)
    return speed[np.abs(speed) > 6]


@case(ORBIT, "pair", ("mixture", "edge_acceptance"), ("turn_on", "truncation", "peak_background", "second_exponential"))
def orbits_of_two_belts(rng: np.random.Generator) -> NDArray:
    """A cold belt of three degrees and three in ten of a hot one of twelve; and a survey of the ecliptic that finds
    fewer of those that leave its strip, most of all above twenty degrees (Brown 2001)."""
    tilt = np.where(
        some(rng, 15_000, 0.3), draw(ORBIT, rng, 15_000, 12.0).ravel(), draw(ORBIT, rng, 15_000, 3.1).ravel()
    )
    return tilt[rng.random(15_000) < 1 / (1 + np.exp((tilt - 20) / 1.5))]


# Effects outside the catalogue.
@case(TREE, "outside")
def trees_read_from_the_wrong_end(rng: np.random.Generator) -> NDArray:
    """One crew, of six trees in ten, read the units of the calliper backwards from the next ten: 32.1 became 37.9, and
    the order within each ten is turned round."""
    diameter = draw(TREE, rng, 7000, 22.0, 2.6).ravel()
    tens = 10 * np.floor(diameter / 10)
    return np.where(some(rng, 7000, 0.6), 2 * tens + 10 - diameter, diameter)


@case(CALL, "outside")
def calls_as_decimals(rng: np.random.Generator) -> NDArray:
    """A table wrote minutes and seconds as 2.45, and somebody took it for a decimal number of minutes: the sixty
    seconds of each minute are squeezed to the first 36, and the rest of each is void."""
    seconds = draw(CALL, rng, 5800, 150.0, 0.7).ravel()
    return 60 * (np.floor(seconds / 60) + (seconds % 60) / 100)


@case(CURRENT, "outside")
def current_that_wraps(rng: np.random.Generator) -> NDArray:
    """A Doppler profiler knows the phase alone: speeds beyond 45 cm/s come back at the other end (ambiguity of the
    velocity), so that the strongest flood looks like an ebb."""
    speed = draw(CURRENT, rng, 3900, 9.0, 42.0, 7.0).ravel()
    return (speed + 45) % 90 - 45


CASES: list[Case] = [value for value in list(globals().values()) if isinstance(value, Case)]
