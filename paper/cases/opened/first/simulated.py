"""Ten simulators of other fields, each with data sets in which nothing is missing, or what that field knows of.

The effects are written as the literature of the field has them. The names that count as right follow from the sentence
that `avobench list effects` gives for each name, and were written down before any diagnosis was made.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

import avobench
from paper.cases.case import Case

Array = NDArray[np.float64]
Rng = np.random.Generator


def at(num_events: int, *theta: float) -> Array:
    """The same parameters for each event: (num_events, p)."""
    return np.tile(theta, (num_events, 1)).astype(float)


def replaced(events: Array, share: float, others: Array, rng: Rng) -> Array:
    """The events (N,) of which a random share is replaced by others (N,)."""
    return np.where(rng.random(len(events)) < share, others, events)


def selected(draw: Callable[[int], NDArray], chance: Callable[[NDArray], Array], num_events: int, rng: Rng) -> NDArray:
    """As many events as asked for, of those that are kept with this chance."""
    kept: list[NDArray] = []
    while sum(map(len, kept)) < num_events:
        events = draw(num_events)
        kept.append(events[rng.random(num_events) < chance(events)])
    return np.concatenate(kept)[:num_events]


# Mass spectrometry: the isotopic pattern of a peptide, each ion a mass-to-charge ratio, on chemical noise.


def isotopes(theta: Array, rng: Rng) -> Array:
    """Monoisotopic mass, mean number of heavy isotopes, width of a peak: (n, 3) -> m/z (n,) in Th, charge 1."""
    mass, heavy, width = theta.T
    n = len(theta)
    ions = mass + 1.00235 * rng.poisson(heavy) + rng.normal(0, width)
    return np.where(rng.random(n) < 0.05, rng.uniform(1045, 1053, n), ions)


def with_doubly_charged(rng: Rng) -> Array:
    """A contaminant of charge 2 has a peak half-way between two isotopes."""
    ions = isotopes(at(12_000, 1046.54, 0.62, 0.05), rng)
    return replaced(ions, 0.07, rng.normal(1047.04, 0.05, len(ions)), rng)


def with_late_ions(rng: Rng) -> Array:
    """A time of flight with tailing peaks: an exponential delay of each ion (Di Marco and Bombi 2001)."""
    return isotopes(at(6000, 1046.54, 0.62, 0.04), rng) + rng.exponential(0.07, 6000)


peptide = avobench.task(
    isotopes,
    prior={"mass": (1046.3, 1046.8), "heavy": (0.3, 1.2), "width": (0.02, 0.15)},
    features=["mz"],
    units={"mass": "Th", "width": "Th"},
)

# Reaction times: the first passage of a diffusion to a threshold (Wald), after a time that is no decision.


def wald(theta: Array, rng: Rng) -> Array:
    """Drift, threshold, time beside the decision in s: (n, 3) -> reaction time (n,) in s."""
    drift, threshold, rest = theta.T
    return rest + rng.wald(threshold / drift, threshold**2)


def with_lapses(rng: Rng) -> Array:
    """Lapses of attention: contaminants uniform over the window (Ratcliff and Tuerlinckx 2002)."""
    times = wald(at(3000, 3.0, 1.2, 0.25), rng)
    return replaced(times, 0.05, rng.uniform(0.25, 2.5, 3000), rng)


def with_fast_guesses(rng: Rng) -> Array:
    """Guesses before the stimulus was seen, about 150 ms after it appeared (Ollman 1966)."""
    times = wald(at(4000, 3.0, 1.2, 0.25), rng)
    return replaced(times, 0.08, 0.1 + rng.gamma(6, 0.012, 4000), rng)


reaction = avobench.task(
    wald,
    prior={"drift": (1.5, 5), "threshold": (0.7, 2), "rest": (0.1, 0.4)},
    features=["time"],
    feature_units={"time": "s"},
    units={"rest": "s"},
)

# Seismology: magnitude (Gutenberg and Richter) and depth of local earthquakes.


def seismicity(theta: Array, rng: Rng) -> Array:
    """b value, median depth in km, spread of its logarithm: (n, 3) -> magnitude from 1, and depth in km (n, 2)."""
    b, median, spread = theta.T
    return np.stack([1 + rng.exponential(1 / (b * np.log(10))), median * np.exp(rng.normal(0, spread))], axis=1)


def with_incompleteness(rng: Rng) -> Array:
    """The chance of detection is a cumulative Gaussian in magnitude (Ogata and Katsura 1993)."""
    return selected(lambda n: seismicity(at(n, 0.95, 8, 0.5), rng), lambda x: norm.cdf(x[:, 0], 1.25, 0.2), 5000, rng)


def with_fixed_depths(rng: Rng) -> Array:
    """A locator fixes the depth at 10 km where the stations do not determine it."""
    events = seismicity(at(4000, 0.95, 8, 0.5), rng)
    events[:, 1] = replaced(events[:, 1], 0.12, np.full(4000, 10.0), rng)
    return events


earthquakes = avobench.task(
    seismicity,
    prior={"b": (0.6, 1.6), "median": (4, 16), "spread": (0.2, 1)},
    features=["magnitude", "depth"],
    feature_units={"depth": "km"},
    units={"median": "km"},
)

# Epidemics: secondary cases in households of six, of which one brings the infection (Reed and Frost).


def reed_frost(theta: Array, rng: Rng) -> NDArray[np.int64]:
    """Chance that one infects another: (n, 1) -> secondary cases (n,), 0 to 5."""
    escape = 1 - theta[:, 0]
    susceptible = np.full(len(theta), 5)
    infectious = np.ones(len(theta), dtype=np.int64)
    for _ in range(5):
        infectious = rng.binomial(susceptible, 1 - escape**infectious)
        susceptible = susceptible - infectious
    return 5 - susceptible


def with_immune_households(rng: Rng) -> NDArray[np.int64]:
    """A fifth of the households is immune throughout, as after vaccination."""
    return np.where(rng.random(1500) < 0.2, 0, reed_frost(at(1500, 0.3), rng))


def with_underreporting(rng: Rng) -> NDArray[np.int64]:
    """Each secondary case is reported with a chance of 60 %."""
    return rng.binomial(reed_frost(at(2500, 0.4), rng), 0.6)


households = avobench.task(reed_frost, prior={"transmission": (0.05, 0.7)}, features=["cases"])

# Pharmacology: a sigmoid dose-response curve (Hill), logarithm of the dose and response of each well.


def hill(theta: Array, rng: Rng) -> Array:
    """log10 EC50, slope, top, noise: (n, 4) -> log10 dose and response (n, 2)."""
    ec50, slope, top, noise = theta.T
    dose = rng.uniform(-2, 2, len(theta))
    return np.stack([dose, top / (1 + 10 ** (slope * (ec50 - dose))) + rng.normal(0, noise)], axis=1)


def with_saturated_reader(rng: Rng) -> Array:
    """The plate reader does not read above its full scale."""
    events = hill(at(3000, 0.2, 1.1, 100, 5), rng)
    events[:, 1] = np.minimum(events[:, 1], 88)
    return events


def with_pipetting_errors(rng: Rng) -> Array:
    """The dose in the well scatters about the nominal one by a log-normal error of the pipettes (Berkson)."""
    events = hill(at(2000, 0.2, 1.1, 100, 4), rng)
    real = events[:, 0] + rng.normal(0, 0.3, 2000)
    events[:, 1] = 100 / (1 + 10 ** (1.1 * (0.2 - real))) + rng.normal(0, 4, 2000)
    return events


assay = avobench.task(
    hill, prior={"ec50": (-1, 1), "slope": (0.6, 2), "top": (70, 130), "noise": (2, 12)}, features=["dose", "response"]
)

# Astronomy: apparent magnitude and colour of the stars of a field.


def photometry(theta: Array, rng: Rng) -> Array:
    """Slope of the number counts, colour at magnitude 19, spread of colours: (n, 3) -> magnitude and colour (n, 2)."""
    slope, colour, spread = theta.T
    u = rng.random(len(theta))
    magnitude = 22 + np.log10(10 ** (-6 * slope) + u * (1 - 10 ** (-6 * slope))) / slope
    return np.stack([magnitude, colour + 0.08 * (magnitude - 19) + rng.normal(0, spread)], axis=1)


def with_photon_noise(rng: Rng) -> Array:
    """The error of the colour grows as the root of the inverse flux, to 0.15 at magnitude 22."""
    events = photometry(at(20_000, 0.3, 0.7, 0.1), rng)
    events[:, 1] += rng.normal(0, 0.15 * 10 ** (0.2 * (events[:, 0] - 22)))
    return events


def with_white_dwarfs(rng: Rng) -> Array:
    """Some of the objects are white dwarfs, blue at any magnitude."""
    events = photometry(at(10_000, 0.3, 0.7, 0.2), rng)
    events[:, 1] = replaced(events[:, 1], 0.04, rng.normal(-0.15, 0.12, 10_000), rng)
    return events


stars = avobench.task(
    photometry,
    prior={"slope": (0.15, 0.6), "colour": (0.4, 1), "spread": (0.05, 0.4)},
    features=["magnitude", "colour"],
    feature_units={"magnitude": "mag", "colour": "mag"},
)

# Particle physics: decay times in a window of 20 us, with the resolution of the counter.


def decays(theta: Array, rng: Rng) -> Array:
    """Lifetime in us: (n, 1) -> decay time (n,) in us, from 0 to 20."""
    lifetime = theta[:, 0]
    u = rng.random(len(theta))
    return -lifetime * np.log1p(-u * -np.expm1(-20 / lifetime))


def with_accidentals(rng: Rng) -> Array:
    """Accidental coincidences are uniform in time."""
    return replaced(decays(at(30_000, 2.2), rng), 0.04, rng.uniform(0, 20, 30_000), rng)


def with_capture(rng: Rng) -> Array:
    """Negative muons are captured by aluminium nuclei and live 0.864 us there (Suzuki et al. 1987)."""
    times = decays(at(50_000, 2.197), rng)
    return replaced(times, 0.35, decays(at(50_000, 0.864), rng), rng)


muons = avobench.task(
    decays, prior={"lifetime": (0.5, 5)}, features=["time"], feature_units={"time": "us"}, units={"lifetime": "us"}
)

# Queueing: service times of a call centre, log-normal (Brown et al. 2005).


def service(theta: Array, rng: Rng) -> Array:
    """Mean and standard deviation of the logarithm of the seconds: (n, 2) -> service time (n,) in s."""
    return np.exp(rng.normal(theta[:, 0], theta[:, 1]))


def with_short_calls(rng: Rng) -> Array:
    """Agents hung up on customers: a surplus of calls of less than ten seconds (Brown et al. 2005)."""
    return replaced(service(at(8000, 4.9, 0.8), rng), 0.07, rng.gamma(3, 2, 8000), rng)


def with_time_limit(rng: Rng) -> Array:
    """The record of a call ends at five minutes."""
    return np.minimum(service(at(2500, 4.9, 0.8), rng), 300)


calls = avobench.task(
    service, prior={"mean": (4, 6), "std": (0.4, 1.3)}, features=["time"], feature_units={"time": "s"}
)

# Ecology: birds counted at a point, negative binomial.


def flocks(theta: Array, rng: Rng) -> NDArray[np.int64]:
    """Mean and dispersion: (n, 2) -> birds (n,)."""
    mean, dispersion = theta.T
    return rng.poisson(rng.gamma(dispersion, mean / dispersion))


def with_empty_sites(rng: Rng) -> NDArray[np.int64]:
    """A quarter of the sites is not occupied (MacKenzie et al. 2002)."""
    return np.where(rng.random(1200) < 0.25, 0, flocks(at(1200, 14, 4), rng))


def with_round_numbers(rng: Rng) -> NDArray[np.int64]:
    """Observers give flocks of more than twenty as a multiple of five, in two of three counts (Vaudor et al. 2011)."""
    birds = flocks(at(3000, 24, 4), rng)
    heaped = (birds > 20) & (rng.random(3000) < 0.67)
    return np.where(heaped, 5 * np.rint(birds / 5).astype(np.int64), birds)


birds = avobench.task(flocks, prior={"mean": (5, 40), "dispersion": (1, 12)}, features=["birds"])

# Hydrology: annual maxima of the discharge, of many gauges scaled to one (Gumbel).


def gumbel(theta: Array, rng: Rng) -> Array:
    """Location and scale in m3/s: (n, 2) -> annual maximum (n,) in m3/s."""
    return rng.gumbel(theta[:, 0], theta[:, 1])


def with_two_kinds_of_flood(rng: Rng) -> Array:
    """The larger of an ordinary and a rarer, larger flood: two-component extreme values (Rossi et al. 1984)."""
    return np.maximum(rng.gumbel(320, 60, 2000), rng.gumbel(50, 170, 2000))


def with_overbank_flow(rng: Rng) -> Array:
    """The rating curve of the channel sees only 60 % of what flows above bankfull stage."""
    flow = gumbel(at(3000, 330, 70), rng)
    return np.where(flow > 400, 400 + 0.6 * (flow - 400), flow)


floods = avobench.task(
    gumbel, prior={"location": (250, 450), "scale": (30, 100)}, features=["flow"], feature_units={"flow": "m3/s"}
)

CASES = (
    Case("spectrum-null", peptide, lambda rng: isotopes(at(8000, 1046.54, 0.62, 0.05), rng), "nothing is missing"),
    Case(
        "spectrum-contaminant",
        peptide,
        with_doubly_charged,
        "a peak of other ions; as a whole pattern elsewhere it is a mixture, which tells it less well",
        ("peak_background",),
        ("mixture", "offset"),
    ),
    Case(
        "spectrum-tail",
        peptide,
        with_late_ions,
        "each value is blurred upwards by an exponential, a skewed resolution and a tail at once",
        ("resolution", "radiative_tail"),
        ("spread", "outliers"),
    ),
    Case("reaction-null", reaction, lambda rng: wald(at(1500, 3.0, 1.2, 0.25), rng), "nothing is missing"),
    Case(
        "reaction-lapses",
        reaction,
        with_lapses,
        "uniform contaminants",
        ("flat_background",),
        ("outliers", "mixture", "spread"),
    ),
    Case(
        "reaction-guesses",
        reaction,
        with_fast_guesses,
        "a narrow peak of other responses before the true ones",
        ("peak_background",),
        ("mixture", "outliers"),
    ),
    Case("earthquakes-null", earthquakes, lambda rng: seismicity(at(3000, 0.95, 8, 0.5), rng), "nothing is missing"),
    Case(
        "earthquakes-incomplete",
        earthquakes,
        with_incompleteness,
        "events near the lower end of the magnitudes are lost; a dead region at the end tells it less well",
        ("edge_acceptance on magnitude",),
        ("dead_region on magnitude", "forward_backward_acceptance on magnitude"),
    ),
    Case(
        "earthquakes-fixed",
        earthquakes,
        with_fixed_depths,
        "values gathered at one place; that they were replaced and not added cannot be seen",
        ("peak_background on depth",),
        ("quantisation on depth", "mixture"),
    ),
    Case("households-null", households, lambda rng: reed_frost(at(800, 0.25), rng), "nothing is missing"),
    Case(
        "households-immune",
        households,
        with_immune_households,
        "zero whatever happens; a chance of zero in some households is also a mixture or a spread of the chance",
        ("zero_inflation",),
        ("mixture", "spread", "overdispersion"),
    ),
    Case(
        "households-unreported",
        households,
        with_underreporting,
        "each case has the same chance to be missed, which no transmission imitates",
        ("inefficiency",),
        ("dead_time",),
    ),
    Case("assay-null", assay, lambda rng: hill(at(2000, 0.2, 1.1, 100, 5), rng), "nothing is missing"),
    Case(
        "assay-saturated",
        assay,
        with_saturated_reader,
        "values above a limit are recorded as the limit",
        ("saturation on response",),
        ("peak_background on response", "quantisation on response"),
    ),
    Case(
        "assay-pipettes",
        assay,
        with_pipetting_errors,
        "an error of the logarithm of the dose is, but for its ends, a resolution of it, and exactly a spread of ec50",
        ("resolution on dose", "spread on ec50"),
        ("conditional_response on response", "conditional_response on dose"),
    ),
    Case("stars-null", stars, lambda rng: photometry(at(20_000, 0.3, 0.7, 0.15), rng), "nothing is missing"),
    Case(
        "stars-noise",
        stars,
        with_photon_noise,
        "the error of one feature depends on the other; a resolution of the colour is a part of it",
        ("conditional_response on colour",),
        ("resolution on colour",),
    ),
    Case(
        "stars-dwarfs",
        stars,
        with_white_dwarfs,
        "a peak of other objects in colour",
        ("peak_background on colour",),
        ("mixture", "outliers on colour"),
    ),
    Case("muons-null", muons, lambda rng: decays(at(50_000, 2.197), rng), "nothing is missing"),
    Case(
        "muons-accidentals",
        muons,
        with_accidentals,
        "uniform in the window",
        ("flat_background",),
        ("second_exponential",),
    ),
    Case(
        "muons-capture",
        muons,
        with_capture,
        "a second lifetime, which is also the same simulator at another one, and a spread of two values",
        ("second_exponential", "mixture", "spread"),
    ),
    Case("calls-null", calls, lambda rng: service(at(1000, 4.9, 0.8), rng), "nothing is missing"),
    Case(
        "calls-short",
        calls,
        with_short_calls,
        "other calls, all near zero: a peak there, or a fast second exponential",
        ("peak_background", "second_exponential"),
        ("mixture",),
    ),
    Case(
        "calls-limit",
        calls,
        with_time_limit,
        "values beyond the end of the scale are recorded as its end",
        ("saturation",),
        ("peak_background",),
    ),
    Case("birds-null", birds, lambda rng: flocks(at(600, 14, 4), rng), "nothing is missing"),
    Case("birds-empty", birds, with_empty_sites, "zero whatever happens", ("zero_inflation",), ("mixture",)),
    Case(
        "birds-heaped",
        birds,
        with_round_numbers,
        "readings are rounded to a coarser step than one count",
        ("quantisation",),
    ),
    Case("floods-null", floods, lambda rng: gumbel(at(700, 330, 70), rng), "nothing is missing"),
    Case(
        "floods-two",
        floods,
        with_two_kinds_of_flood,
        "a second population with an exponential tail of its own",
        ("mixture", "second_exponential"),
        ("spread", "outliers", "radiative_tail"),
    ),
    Case(
        "floods-overbank",
        floods,
        with_overbank_flow,
        "the scale is another one above a level; a soft saturation says the same",
        ("scale", "saturation"),
    ),
)
"""Thirty data sets: of each simulator one in which nothing is missing, and two with an effect."""
