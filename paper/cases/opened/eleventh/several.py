"""Case cases of several numbers: blood pressures, transits of planets, a drift chamber, nests, floods."""

import numpy as np

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some


def _pressure(theta, rng):
    """Systolic and diastolic blood pressure of adults, of which the second follows the first."""
    mean, spread = theta.T
    n = len(theta)
    systolic = mean + spread * rng.normal(size=n)
    return np.column_stack([systolic, 80 + 0.5 * (systolic - 125) + 6 * rng.normal(size=n)])


PRESSURE = task(
    _pressure,
    prior={"mean": (110, 145), "spread": (8, 22)},
    units={"mean": "mmHg", "spread": "mmHg"},
    features=["systolic", "diastolic"],
    feature_units={"systolic": "mmHg", "diastolic": "mmHg"},
    name="blood-pressure",
)


def _transit(theta, rng):
    """Logarithm of the period in days, depth in per mille and duration in hours of planets in transit."""
    period, radius = theta.T
    n = len(theta)
    log_period = period + 0.35 * rng.normal(size=n)
    ratio = radius * np.exp(0.3 * rng.normal(size=n))
    chord = np.sqrt(1 - rng.uniform(0, 0.95, n) ** 2)
    duration = 1.8 * 10 ** (log_period / 3) * chord * np.exp(0.12 * rng.normal(size=n))
    return np.column_stack([log_period, 1000 * ratio**2 * np.exp(0.1 * rng.normal(size=n)), duration])


TRANSITS = task(
    _transit,
    prior={"period": (0.3, 1.5), "radius": (0.01, 0.1)},
    features=["log_period", "depth", "duration"],
    feature_units={"duration": "h"},
    name="transits",
)


def _drift(theta, rng):
    """Drift time, charge and number of clusters of a track's hit in a cell of 8 mm of a drift chamber."""
    velocity, gain, clusters = theta.T
    n = len(theta)
    distance = rng.uniform(0, 8, n)
    time = 1000 * distance / velocity + 3 * np.sqrt(distance) * rng.normal(size=n)
    number = 1 + rng.poisson(clusters)
    return np.column_stack([time, gain * rng.gamma(2.0 * number) / 2, number])


DRIFT = task(
    _drift,
    prior={"velocity": (30, 70), "gain": (2, 12), "clusters": (6, 25)},
    units={"velocity": "um/ns", "gain": "fC"},
    features=["time", "charge", "clusters"],
    kinds={"clusters": "count"},
    feature_units={"time": "ns", "charge": "fC"},
    name="drift-chamber",
)


def _nest(theta, rng):
    """Day of the first egg, number of eggs, and young that fly, of great tits; the later, the fewer of both."""
    start, clutch, survival = theta.T
    n = len(theta)
    late = rng.normal(size=n)
    eggs = 1 + rng.poisson(clutch * np.exp(-0.06 * late))
    return np.column_stack([start + 8 * late, eggs, rng.binomial(eggs, survival / (1 + 0.1 * np.exp(late)))])


NESTS = task(
    _nest,
    prior={"start": (15, 40), "clutch": (4, 9), "survival": (0.4, 0.95)},
    units={"start": "d"},
    features=["day", "eggs", "fledged"],
    kinds={"eggs": "count", "fledged": "count"},
    feature_units={"day": "d"},
    name="nests",
)


def _flood(theta, rng):
    """Logarithms of a flood's peak flow and volume, and its duration: the volume follows the other two."""
    peak, duration = theta.T
    n = len(theta)
    log_peak = peak + 0.35 * rng.gumbel(size=n)
    hours = duration * rng.gamma(4.0, 0.25, n)
    return np.column_stack([log_peak, log_peak + np.log(hours) - 1 + 0.15 * rng.normal(size=n), hours])


FLOODS = task(
    _flood,
    prior={"peak": (2, 6), "duration": (15, 60)},
    units={"duration": "h"},
    features=["log_peak", "log_volume", "hours"],
    feature_units={"hours": "h"},
    name="floods",
)


PLAIN = [
    plain("pressure_plain", PRESSURE, 5500, 128.0, 15.0),
    plain("transits_plain", TRANSITS, 1100, 0.9, 0.04),
    plain("drift_plain", DRIFT, 18000, 52.0, 5.0, 13.0),
    plain("nests_plain", NESTS, 2100, 27.0, 7.3, 0.8),
    plain("floods_plain", FLOODS, 350, 4.1, 31.0),
]


@case(PRESSURE, "single", ("heaping on systolic",), ("quantisation on systolic",))
def pressure_zeros(rng):
    """The last digit of the systolic pressure is a zero too often: a fifth of the readings, twice as many from 140 on;
    the diastolic one is read from a device."""
    x = draw(PRESSURE, rng, 2900, 131.0, 17.0)
    lazy = rng.random(len(x)) < np.where(x[:, 0] >= 140, 0.4, 0.2)
    x[:, 0] = np.where(lazy, 10 * np.rint(x[:, 0] / 10), x[:, 0])
    return x


@case(
    PRESSURE,
    "single",
    ("conditional_response on diastolic",),
    ("crosstalk on diastolic", "correlation", "resolution on diastolic", "scale on diastolic"),
)
def pressure_stiff(rng):
    """Stiff arteries: the higher the systolic pressure above 125, the more the diastolic one is read too low, with a
    growing scatter."""
    x = draw(PRESSURE, rng, 6200, 126.0, 14.0)
    above = np.maximum(x[:, 0] - 125, 0)
    x[:, 1] -= 0.35 * above * rng.gamma(4.0, 0.25, len(x))
    return x


@case(
    TRANSITS,
    "single",
    ("dead_region on log_period",),
    ("edge_acceptance on log_period", "analysis_window on log_period", "turn_on on log_period"),
)
def transits_month(rng):
    """The light of the Moon comes and goes with the month: planets with a period of 25 to 33 days are lost in its
    harmonics, the most right at 29.5 days."""
    x = draw(TRANSITS, rng, 16000, 1.35, 0.05)
    off = (x[:, 0] - np.log10(29.5)) / 0.04
    return x[rng.random(len(x)) > 0.95 * np.exp(-0.5 * off**4)]


@case(
    DRIFT,
    "single",
    ("saturation on charge",),
    ("censoring on charge", "conditional_response on charge", "truncation on charge"),
)
def drift_rail(rng):
    """The preamplifier bends from 80 fC on and ends at 140 fC; which clusters there are is known from another
    readout."""
    x = draw(DRIFT, rng, 5800, 46.0, 8.0, 11.0)
    over = np.maximum(x[:, 1] - 80, 0)
    x[:, 1] = np.minimum(x[:, 1], 80) + 60 * np.tanh(over / 60)
    return x


@case(
    DRIFT,
    "single",
    ("edge_acceptance on time",),
    ("turn_on on time", "truncation on time", "analysis_window on time", "forward_backward_acceptance on time"),
)
def drift_borders(rng):
    """The field is weak near the wall of the cell and the threshold high near the wire, where the clusters are spread
    in time: hits of short and of long times are lost, more of the long ones."""
    x = draw(DRIFT, rng, 11000, 58.0, 4.0, 16.0)
    far = x[:, 0] / (8000 / 58.0)
    return x[rng.random(len(x)) < (1 - 0.6 * np.exp(-far / 0.06)) * (1 - 0.8 * np.clip((far - 0.8) / 0.2, 0, 1) ** 1.5)]


@case(
    NESTS,
    "single",
    ("zero_inflation on fledged",),
    ("mixture on fledged", "overdispersion on fledged", "mixture", "spread", "flat_background on fledged"),
)
def nests_robbed(rng):
    """A marten found 13 % of the nests and took all young of two in three of them, and about half of the others'."""
    x = draw(NESTS, rng, 1500, 24.0, 7.0, 0.85)
    n = len(x)
    left = np.where(some(rng, n, 2 / 3), 0, rng.binomial(x[:, 2].astype(int), 0.5))
    x[:, 2] = np.where(some(rng, n, 0.13), left, x[:, 2])
    return x


@case(
    FLOODS,
    "single",
    ("correlation",),
    ("resolution on log_peak", "resolution on log_volume", "spread", "mixture", "offset", "scale"),
)
def floods_rating(rng):
    """The rating curve turns the water level into the flow: its error, of a long-tailed kind and the same for all of a
    flood, shifts peak and volume together."""
    x = draw(FLOODS, rng, 4600, 3.6, 28.0)
    x[:, :2] += 0.35 * rng.standard_t(4, len(x))[:, None]
    return x


@case(
    NESTS,
    "single",
    ("outliers on day",),
    ("mixture on day", "peak_background on day", "flat_background on day", "resolution on day", "mixture"),
)
def nests_month(rng):
    """In 4 % of the notebooks the month is wrong by one, mostly too late."""
    x = draw(NESTS, rng, 3600, 28.0, 6.0, 0.7)
    n = len(x)
    x[:, 0] += np.where(some(rng, n, 0.04), rng.choice([-30.0, 30.0, 31.0, 31.0], n), 0)
    return x


def volunteers(x, rng):
    """A trial that takes nobody with a systolic pressure above 145, as measured a week before."""
    return x[x[:, 0] + 2 * rng.normal(size=len(x)) <= 145]


def diastolic_digits(x, rng):
    """A third of the diastolic readings end with a zero, or with a five in half as many cases."""
    x = x.copy()
    step = np.where(some(rng, len(x), 1 / 3), 5, 10)
    x[:, 1] = np.where(some(rng, len(x), 0.33), step * np.rint(x[:, 1] / step), x[:, 1])
    return x


@case(
    PRESSURE,
    "pair",
    ("truncation on systolic", "heaping on diastolic"),
    ("turn_on on systolic", "edge_acceptance on systolic", "analysis_window on systolic", "quantisation on diastolic"),
)
def pressure_trial(rng):
    """The trial takes nobody above 145, and a third of the diastolic readings are multiples of five or ten."""
    return diastolic_digits(volunteers(draw(PRESSURE, rng, 4800, 134.0, 15.0), rng), rng)


def shallow(x, rng):
    """The shallower the transit and the shorter, the less often it is found."""
    signal = x[:, 1] * np.sqrt(x[:, 2] / 4)
    return x[rng.random(len(x)) < signal**3 / (0.6**3 + signal**3)]


def cadence(x):
    """Durations are whole numbers of the long cadence of 29.4 minutes."""
    x = x.copy()
    x[:, 2] = 0.49 * np.maximum(np.rint(x[:, 2] / 0.49), 1)
    return x


@case(
    TRANSITS,
    "pair",
    ("turn_on on depth", "quantisation on duration"),
    ("truncation on depth", "edge_acceptance on depth", "heaping on duration", "turn_on on duration"),
)
def transits_survey(rng):
    """Shallow transits are missed, and durations are known in steps of the cadence."""
    return cadence(shallow(draw(TRANSITS, rng, 9500, 0.8, 0.025), rng))


def late_start(x, rng):
    """The start of the clock jitters from event to event, with a tail."""
    x = x.copy()
    x[:, 0] += 18 * rng.standard_t(6, len(x))
    return x


def delta_rays(x, rng):
    """Each cluster makes a further one with a chance of 0.35, and that one the same; the charge is not changed."""
    x = x.copy()
    young = x[:, 2].astype(int)
    while young.any():
        young = rng.binomial(young, 0.35)
        x[:, 2] += young
    return x


@case(
    DRIFT,
    "pair",
    ("resolution on time", "after_pulses on clusters"),
    ("outliers on time", "overdispersion on clusters", "spread on clusters", "double_counting on clusters"),
)
def drift_trigger(rng):
    """The start time jitters, and delta rays are counted as clusters of their own."""
    return delta_rays(late_start(draw(DRIFT, rng, 7400, 55.0, 6.0, 9.0), rng), rng)


def visits(x):
    """The observer comes once a week and notes the day of the visit."""
    x = x.copy()
    x[:, 0] = 7 * np.ceil(x[:, 0] / 7)
    return x


def unseen(x, rng):
    """Small clutches are given up before anybody finds the nest."""
    kept = np.interp(x[:, 1], [1, 2, 3, 4, 5], [0.05, 0.1, 0.2, 0.5, 1])
    return x[rng.random(len(x)) < kept]


@case(
    NESTS,
    "pair",
    ("quantisation on day", "threshold_loss on eggs"),
    ("heaping on day", "truncation on eggs", "threshold_loss on fledged"),
)
def nests_weekly(rng):
    """The boxes are seen once a week, and nests of few eggs are given up before."""
    return visits(unseen(draw(NESTS, rng, 8800, 30.0, 5.5, 0.75), rng))


def overtopped(x):
    """The gauge is drowned by the largest floods: no peak above a level is recorded."""
    x = x.copy()
    x[:, 0] = np.minimum(x[:, 0], 5.6)
    return x


def quarter_days(x, rng):
    """Observers note the hours in quarters of a day, in four of ten floods."""
    x = x.copy()
    x[:, 2] = np.where(some(rng, len(x), 0.4), 6 * np.maximum(np.rint(x[:, 2] / 6), 1), x[:, 2])
    return x


@case(
    FLOODS,
    "pair",
    ("censoring on log_peak", "heaping on hours"),
    ("saturation on log_peak", "truncation on log_peak", "quantisation on hours"),
)
def floods_gauge(rng):
    """The gauge ends at a level that one flood in ten passes, and two observers in five note quarters of a day."""
    return quarter_days(overtopped(draw(FLOODS, rng, 2300, 4.8, 40.0)), rng)


@case(PRESSURE, "outside")
def pressure_columns(rng):
    """In 5 % of the records the two pressures stand in each other's column: values exchanged between two features."""
    x = draw(PRESSURE, rng, 1800, 129.0, 13.0)
    return either(some(rng, len(x), 0.05), x[:, ::-1], x)


@case(TRANSITS, "outside")
def transits_nightly(rng):
    """Stars are seen once a night, so that a frequency above half a cycle a day is found at its mirror image below:
    1.25 days become 5. The warp of the scale folds it, while depth and duration are right."""
    x = draw(TRANSITS, rng, 3900, 0.55, 0.06)
    frequency = 10.0 ** -x[:, 0]
    x[:, 0] = -np.log10(np.maximum(np.abs(frequency - np.rint(frequency)), 0.01))
    return x


@case(NESTS, "outside")
def nests_fostered(rng):
    """Young are moved between pairs of nests until both have as many, up to one: events change each other's values."""
    x = draw(NESTS, rng, 7000, 22.0, 6.5, 0.75)
    young = x[:, 2].reshape(-1, 2).sum(1)
    x[:, 2] = np.column_stack([np.ceil(young / 2), np.floor(young / 2)]).ravel()
    return x


@case(FLOODS, "outside")
def floods_linked(rng):
    """The tables of flows and of durations were joined with an error: in three rows of ten the hours are those of the
    flood before. Each feature alone is right, and no effect on one feature does this."""
    x = draw(FLOODS, rng, 5000, 4.4, 35.0)
    x[:, 2] = np.where(some(rng, len(x), 0.3), np.roll(x[:, 2], 1), x[:, 2])
    return x


CASES: list[Case] = PLAIN + [each for each in list(globals().values()) if isinstance(each, Case)]
