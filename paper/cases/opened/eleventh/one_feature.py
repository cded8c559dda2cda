"""Case cases of one number: headways of cars, fill weights, grain sizes, redshifts of a survey, ages at death."""

import numpy as np

from avobench import task
from paper.cases.case import Case, case, draw, plain, some


def _headway(theta, rng):
    """Time gaps of cars on a lane: a share follows the car in front closely, the others are free (Cowan's M4)."""
    mean, following = theta.T
    n = len(theta)
    close = 0.5 + rng.gamma(4.0, 0.3, n)
    return np.where(rng.random(n) < following, close, close + rng.exponential(mean))


HEADWAYS = task(
    _headway,
    prior={"free": (3, 15), "following": (0.1, 0.7)},
    units={"free": "s"},
    features=["gap"],
    feature_units={"gap": "s"},
    name="headways",
)

WEIGHTS = task(
    lambda theta, rng: rng.normal(theta[:, 0], theta[:, 1]),
    prior={"fill": (490, 515), "sigma": (1, 6)},
    units={"fill": "g", "sigma": "g"},
    features=["weight"],
    feature_units={"weight": "g"},
    name="fill-weights",
)

GRAINS = task(
    lambda theta, rng: theta[:, 0] * np.exp(theta[:, 1] * rng.normal(size=len(theta))),
    prior={"median": (5, 40), "sigma": (0.25, 0.8)},
    units={"median": "um"},
    features=["diameter"],
    feature_units={"diameter": "um"},
    name="grains",
)


def _redshift(theta, rng):
    """Redshifts of a survey down to a magnitude: z^2 exp(-(z / z0)^1.5), as Smail and others took it."""
    return theta[:, 0] * rng.gamma(2.0, size=len(theta)) ** (2 / 3)


REDSHIFTS = task(_redshift, prior={"z0": (0.2, 0.9)}, features=["z"], name="redshifts")


def _age(theta, rng):
    """Ages at death of a cohort from the age of 20 on, after Gompertz: by the commonest age and the spread around."""
    mode, spread = theta.T
    start = np.exp((20 - mode) / spread)
    return mode + spread * np.log(start + rng.exponential(size=len(theta)))


AGES = task(
    _age,
    prior={"mode": (65, 90), "spread": (6, 15)},
    units={"mode": "yr", "spread": "yr"},
    features=["age"],
    feature_units={"age": "yr"},
    name="ages-at-death",
)


PLAIN = [
    plain("headways_plain", HEADWAYS, 3300, 6.5, 0.35),
    plain("weights_plain", WEIGHTS, 480, 503.2, 2.2),
    plain("grains_plain", GRAINS, 7600, 12.5, 0.55),
    plain("redshifts_plain", REDSHIFTS, 60000, 0.47),
    plain("ages_plain", AGES, 1700, 82.0, 10.5),
]


@case(HEADWAYS, "single", ("turn_on",), ("edge_acceptance", "truncation", "analysis_window"))
def headways_loop(rng):
    """The loop in the road takes two cars that are close together for one long one: the closer, the more often, on a
    skewed curve that reaches a half at 1.5 s."""
    gap = draw(HEADWAYS, rng, 7000, 5.0, 0.45)[:, 0]
    return gap[rng.random(len(gap)) < 1 - np.exp(-np.log(2) * (gap / 1.5) ** 4)]


@case(WEIGHTS, "single", ("truncation",), ("turn_on", "edge_acceptance", "analysis_window"))
def weights_checked(rng):
    """The checkweigher pushes packs of less than 500 g off the belt; its own limit drifts by a third of a gram."""
    weight = draw(WEIGHTS, rng, 2600, 502.6, 3.4)[:, 0]
    return weight[weight > 500 + 0.33 * np.sin(np.arange(len(weight)) / 150)]


@case(GRAINS, "single", ("quantisation",), ("heaping",))
def grains_pixels(rng):
    """The diameter is that of a disc with as many pixels as the grain has in the picture, of 3 um each: possible values
    lie far apart for small grains and close together for large ones."""
    diameter = draw(GRAINS, rng, 5200, 9.0, 0.35)[:, 0]
    pixels = np.maximum(np.rint(np.pi / 4 * (diameter / 3) ** 2), 1)
    return 3 * np.sqrt(4 / np.pi * pixels)


@case(REDSHIFTS, "single", ("outliers",), ("flat_background", "mixture", "radiative_tail", "resolution"))
def redshifts_catastrophic(rng):
    """Of 6 % of the galaxies the photometric redshift failed: it is far off, either way, by a long-tailed error."""
    n = 9000
    z = draw(REDSHIFTS, rng, n, 0.33)[:, 0]
    wrong = np.abs(z + 0.8 * rng.standard_t(2.5, n))
    return np.where(some(rng, n, 0.06), wrong, z)


@case(AGES, "single", ("heaping",), ("quantisation",))
def ages_round(rng):
    """Ages of the old are told in round numbers: the share that is a multiple of ten or, as often, of five rises from 5
    % at 50 to 40 % at 100."""
    n = 4400
    age = draw(AGES, rng, n, 78.0, 12.0)[:, 0]
    step = np.where(some(rng, n, 0.5), 10, 5)
    told = rng.random(n) < np.clip(0.05 + 0.007 * (age - 50), 0.05, 0.4)
    return np.where(told, step * np.rint(age / step), age)


@case(AGES, "single", ("peak_background",), ("mixture", "outliers", "flat_background"))
def ages_accidents(rng):
    """The accident hump: 4 % more deaths, of young people, between 20 and 35 with a skewed peak at 23."""
    n = 12000
    hump = 20 + rng.gamma(3.0, 1.6, n)
    return np.where(some(rng, n, 0.04), hump, draw(AGES, rng, n, 84.0, 9.0)[:, 0])


@case(WEIGHTS, "single", ("radiative_tail",), ("outliers", "mixture", "second_exponential", "spread"))
def weights_dripping(rng):
    """A valve that closes late lets some more product drip into one pack in eight, for an exponential time at a flow
    that differs from day to day."""
    n = 1900
    more = rng.exponential(1.0, n) * np.where(np.arange(n) % 600 < 300, 5.0, 9.0)
    return draw(WEIGHTS, rng, n, 501.0, 1.8)[:, 0] + np.where(some(rng, n, 1 / 8), more, 0)


@case(GRAINS, "single", ("saturation",), ("censoring", "truncation", "analysis_window"))
def grains_counter(rng):
    """The pulse of the sizing counter bends towards the rail of its amplifier: grains of up to 30 um are sized well,
    and none appears larger than 52 um."""
    diameter = draw(GRAINS, rng, 15000, 24.0, 0.6)[:, 0]
    return diameter / (1 + (diameter / 52) ** 5) ** 0.2


def overflow(gap):
    """A timer that stops at 16 s."""
    return np.minimum(gap, 16.0)


def ticks(gap):
    """A clock of four ticks a second: whole ticks."""
    return np.floor(4 * gap) / 4


@case(HEADWAYS, "pair", ("quantisation", "censoring"), ("heaping", "saturation", "truncation"))
def headways_timer(rng):
    """The counter at the roadside knows quarters of a second and stops at 16 s."""
    return ticks(overflow(draw(HEADWAYS, rng, 2800, 9.0, 0.3)[:, 0]))


def mistared(weight, rng):
    """The tare of 3 % of the packs was wrong, by up to two empty packs."""
    n = len(weight)
    return weight + np.where(some(rng, n, 0.03), 16 * rng.choice([-1.0, 1.0, 1.0], n) * rng.beta(2, 2, n), 0)


def grams(weight, rng):
    """One clerk in five notes even grams."""
    return np.where(some(rng, len(weight), 0.2), 2 * np.rint(weight / 2), weight)


@case(WEIGHTS, "pair", ("outliers", "heaping"), ("mixture", "quantisation", "flat_background", "radiative_tail"))
def weights_hand(rng):
    """3 % of the packs were weighed with a wrong tare, and one clerk in five notes even grams alone."""
    return grams(mistared(draw(WEIGHTS, rng, 6000, 507.0, 2.4)[:, 0], rng), rng)


def beads(diameter, rng):
    """Standard beads of 25 um are left in the cell from the calibration, some of them stuck together in pairs."""
    n = len(diameter)
    bead = 25 * np.where(some(rng, n, 0.15), 2 ** (1 / 3), 1.0) * np.exp(0.03 * rng.normal(size=n))
    return np.where(some(rng, n, 0.04), bead, diameter)


def sieved(diameter, rng):
    """What is finer than some 6 um has been lost in the sieve."""
    return diameter[diameter > 6 * np.exp(0.05 * rng.normal(size=len(diameter)))]


@case(GRAINS, "pair", ("peak_background", "truncation"), ("turn_on", "edge_acceptance", "mixture", "analysis_window"))
def grains_beads(rng):
    """The fines were lost in the sieve, and 4 % of the grains are beads of 25 um from the calibration."""
    return sieved(beads(draw(GRAINS, rng, 10000, 10.0, 0.6)[:, 0], rng), rng)


def fakes(z, rng, share):
    """Spurious lines, at any redshift of the range up to 1.5 alike."""
    return np.where(some(rng, len(z), share), rng.uniform(0, 1.5, len(z)), z)


def desert(z, rng):
    """The strongest line falls between the bands of the sky: between 0.43 and 0.52 one galaxy in four is measured."""
    return z[(z < 0.43) | (z > 0.52) | some(rng, len(z), 0.25)]


@case(REDSHIFTS, "pair", ("dead_region", "flat_background"), ("outliers", "mixture"))
def redshifts_desert(rng):
    """7 % of the redshifts are of spurious lines, anywhere up to 1.5, and few are found between 0.43 and 0.52."""
    return desert(fakes(draw(REDSHIFTS, rng, 5000, 0.3)[:, 0], rng, 0.07), rng)


def fives(age, rng):
    """One age in seven is told as a multiple of five."""
    return np.where(some(rng, len(age), 1 / 7), 5 * np.rint(age / 5), age)


@case(AGES, "pair", ("truncation", "heaping"), ("quantisation", "turn_on", "edge_acceptance", "analysis_window"))
def ages_pension(rng):
    """The records are those of a pension fund, which knows nobody who died before 62, and one age in seven is told as a
    multiple of five."""
    age = draw(AGES, rng, 21000, 74.0, 11.0)[:, 0]
    return fives(age[age > 62], rng)


@case(WEIGHTS, "outside")
def weights_segment(rng):
    """The upper right segment of the display is dead, so that an 8 is read as a 6 and a 9 as a 5, for the grams and the
    tenths alike (the hundredths are noted as they are): a wrong reading that depends on the digits of the value."""
    weight = draw(WEIGHTS, rng, 1500, 504.5, 4.5)[:, 0]
    digits = np.floor(10 * weight).astype(int)
    seen = np.array([0, 1, 2, 3, 4, 5, 6, 7, 6, 5])
    return digits // 100 * 10.0 + seen[digits // 10 % 10] + seen[digits % 10] / 10 + (weight - digits / 10)


@case(REDSHIFTS, "outside")
def redshifts_attractors(rng):
    """The photometric redshift runs to and fro about the true one where the break passes from one filter to the next: a
    warp of the scale that does not even keep the order."""
    z = draw(REDSHIFTS, rng, 4000, 0.5)[:, 0]
    return z + 0.13 * np.sin(2 * np.pi * z**0.8 / 0.32) * np.minimum(z / 0.2, 1)


@case(HEADWAYS, "outside")
def headways_averaged(rng):
    """The logger stores the mean of each gap and the gap before it: neighbours change each other's values."""
    gap = draw(HEADWAYS, rng, 8500, 8.0, 0.25)[:, 0]
    return (gap + np.roll(gap, 1)) / 2


@case(GRAINS, "outside")
def grains_bit(rng):
    """A bit of the converter is stuck at one: to each diameter whose binary digit of 8 um is zero, 8 um are added."""
    diameter = draw(GRAINS, rng, 2900, 14.0, 0.45)[:, 0]
    return diameter + 8 * ((diameter // 8).astype(int) % 2 == 0)


CASES: list[Case] = PLAIN + [each for each in list(globals().values()) if isinstance(each, Case)]
