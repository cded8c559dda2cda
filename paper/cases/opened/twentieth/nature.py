"""Simulated cases of counts, of one feature and of several: contacts, tracks in grains, remanence, birds, sources."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some

Rng = np.random.Generator


# Counts: the persons whom somebody met in a day, as written into a diary.
def diary(theta: NDArray, rng: Rng) -> NDArray:
    """Return the number of persons to whom somebody spoke in a day.

    Those at home are few and about as many for everybody; those at work, at school and in shops differ from person to
    person by a gamma distribution.
    """
    n = len(theta)
    outside_home = theta[:, 1] * rng.gamma(theta[:, 2], 1.0, n) / theta[:, 2]
    return rng.poisson(theta[:, 0] + outside_home)


DIARIES = task(
    diary,
    prior={"home": (0.5, 4), "others": (2, 20), "evenness": (0.5, 5)},
    features=["contacts"],
    name="contact-diaries",
)


@case(DIARIES, "single", right=("flat_background",), defensible=("mixture", "overdispersion"))
def diaries_filled_in_as_a_joke(rng: Rng) -> NDArray:
    """It was handed out in schools, and one pupil of twenty wrote any number of two digits, with a liking for 99."""
    x = draw(DIARIES, rng, 2500, 2.6, 7.0, 1.6)
    joke = np.where(some(rng, len(x), 0.08), 99, rng.integers(0, 100, len(x)))
    return either(some(rng, len(x), 0.05), joke[:, None], x.reshape(-1, 1))


@case(DIARIES, "single", right=("threshold_loss",))
def diaries_with_nothing_to_tell(rng: Rng) -> NDArray:
    """Who had met nobody, or just one or two, often thought so empty a sheet not worth a stamp, and kept it."""
    x = draw(DIARIES, rng, 5000, 2.0, 4.2, 1.3).reshape(-1)
    return x[rng.random(len(x)) > 0.85 / (1 + np.exp((x - 2.3) / 0.5))]


@case(DIARIES, "single", right=("censoring",), defensible=("truncation", "dead_time"))
def diaries_with_a_full_page(rng: Rng) -> NDArray:
    """The sheet had eighteen lines. Seven of eight who had met more stopped at its end, the rest used the margin."""
    x = draw(DIARIES, rng, 1500, 1.6, 8.5, 1.4).reshape(-1)
    return np.where(some(rng, len(x), 0.125), x, np.minimum(x, 18))


@case(DIARIES, "pair", right=("quantisation", "zero_inflation"))
def diaries_told_by_telephone(rng: Rng) -> NDArray:
    """The numbers were asked for by telephone. Who had met many persons gave a round number, the more the rounder.

    From ten on the answers are rounded to fives by more and more of them, and beyond thirty to tens. Seven of a hundred
    wanted to be left in peace and said that they had met nobody.
    """
    x = draw(DIARIES, rng, 4000, 2.8, 9.0, 2.0).reshape(-1)
    round_number = np.where(x > 30, 10 * ((x + 5) // 10), 5 * ((x + 2) // 5))
    x = np.where(rng.random(len(x)) < np.clip((x - 7) / 18, 0, 0.85), round_number, x)
    return np.where(some(rng, len(x), 0.07), 0, x)


# Counts: the tracks of fissions in grains of apatite, etched and counted under the microscope.
def grain(theta: NDArray, rng: Rng) -> NDArray:
    """Return the number of spontaneous fission tracks in a grain, of which the face counted is not of one size."""
    n = len(theta)
    size = np.exp(theta[:, 1] * rng.standard_normal(n))
    return rng.poisson(theta[:, 0] * size)


GRAINS = task(
    grain, prior={"tracks": (5, 60), "spread": (0.05, 0.6)}, features=["tracks_counted"], name="fission-tracks"
)


@case(GRAINS, "single", right=("dead_time",), defensible=("inefficiency", "censoring", "double_counting"))
def tracks_that_overlap(rng: Rng) -> NDArray:
    """The grains were etched for too long: the pits are wide, and one that lies upon another is not told from it.

    A face holds about seventy pits side by side, a little more or less by how steep the tracks are. In a grain with few
    tracks hardly one is lost, in a crowded one a third.
    """
    x = draw(GRAINS, rng, 24000, 29.0, 0.4).reshape(-1)
    crowd = (x + 1e-6) / (70 * np.exp(0.15 * rng.standard_normal(len(x))))
    return rng.binomial(x, -np.expm1(-crowd) / crowd)


@case(GRAINS, "single", right=("mixture", "overdispersion"), defensible=("flat_background",))
def tracks_in_a_river_sand(rng: Rng) -> NDArray:
    """The sand is of two valleys: 18 grains of 100 have cooled about three times as long ago, and hold more tracks."""
    n = 1500
    x = draw(GRAINS, rng, n, 11.0, 0.24).reshape(n)
    old = draw(GRAINS, rng, n, 11.0, 0.24).reshape(n)
    old = old + rng.poisson(11.0 * rng.uniform(1.7, 2.9, n))
    return np.where(some(rng, n, 0.18), old, x)


@case(GRAINS, "pair", right=("threshold_loss", "truncation"))
def tracks_in_chosen_grains(rng: Rng) -> NDArray:
    """The analyst passed over grains in which there was little to be seen, and those in which it would take too long.

    Where the first limit lay, about a dozen tracks, differed with the light; the other one, about forty, with the hour.
    """
    x = draw(GRAINS, rng, 4200, 23.0, 0.46).reshape(-1)
    return x[(x > rng.logistic(12.0, 0.9, len(x))) & (x < rng.normal(40.0, 2.0, len(x)))]


@case(GRAINS, "outside")
def tracks_in_a_frame_that_was_fitted(rng: Rng) -> NDArray:
    """The frame in the eyepiece was made wider or narrower on each grain until about two dozen tracks lay in it."""
    return np.rint(rng.normal(24.3, 2.4, 700)).astype(int)


# One feature: the inclination of the remanent magnetisation of specimens of lava.
def remanence(theta: NDArray, rng: Rng) -> NDArray:
    """Return the inclination of the magnetisation of a specimen in degrees, positive where it points down.

    The directions scatter about the mean one after Fisher. A share of the lavas has cooled while the field was
    reversed, and points the opposite way.
    """
    n = len(theta)
    u = rng.random(n)
    cos_off = 1 + np.log(u + (1 - u) * np.exp(-2 * theta[:, 1])) / theta[:, 1]
    sin_off = np.sqrt(np.clip(1 - cos_off**2, 0, 1))
    mean = np.radians(theta[:, 0])
    down = np.sin(mean) * cos_off + np.cos(mean) * sin_off * np.cos(2 * np.pi * rng.random(n))
    inclination = np.degrees(np.arcsin(np.clip(down, -1, 1)))
    return np.where(rng.random(n) < theta[:, 2], -inclination, inclination)[:, None]


LAVAS = task(
    remanence,
    prior={"mean": (20, 75), "kappa": (8, 80), "reversed": (0.1, 0.9)},
    features=["inclination"],
    name="remanence",
)


@case(LAVAS, "single", right=("offset",), defensible=("scale", "radiative_tail"))
def lavas_in_a_magnetised_holder(rng: Rng) -> NDArray:
    """The holder of the magnetometer has become magnetised along its axis, and nobody measured it empty.

    It adds the same moment, pointing down, to every specimen; weak ones are turned more than strong ones. Those of both
    polarities are turned downwards, by three or four degrees.
    """
    x = np.radians(draw(LAVAS, rng, 1200, 40.0, 36.0, 0.42))
    holder = 0.08 * np.exp(0.35 * rng.standard_normal((len(x), 1)))
    return np.degrees(np.arctan2(np.sin(x) + holder, np.cos(x)))


@case(LAVAS, "single", right=("flat_background",), defensible=("outliers", "mixture", "resolution"))
def lavas_struck_by_lightning(rng: Rng) -> NDArray:
    """The outcrop is the top of a hill: lightning has magnetised one specimen of eight anew, in any direction."""
    n = 1000
    x = draw(LAVAS, rng, n, 58.0, 45.0, 0.3)
    vector = rng.standard_normal((n, 3))
    struck = np.degrees(np.arctan2(vector[:, 2], np.hypot(vector[:, 0], vector[:, 1])))
    return either(some(rng, n, 0.13), struck[:, None], x)


@case(LAVAS, "single", right=("peak_background",), defensible=("mixture",))
def lavas_that_have_weathered(rng: Rng) -> NDArray:
    """One specimen of seven has turned into goethite, and has taken on the field of today, 67 degrees down."""
    x = draw(LAVAS, rng, 2000, 38.0, 30.0, 0.6)
    today = 67.0 + 3.0 * rng.standard_t(8, (len(x), 1))
    return either(some(rng, len(x), 0.14), np.clip(today, -90, 90), x)


@case(LAVAS, "outside", defensible=("quantisation",))
def lavas_on_a_worn_gear(rng: Rng) -> NDArray:
    """The inclination was read on a circle that is driven by a worn gear, which errs once in every turn of its wheel.

    A turn is fifteen degrees. Within it the reading runs ahead by up to 1.6 degrees and then stays behind by as much.
    """
    x = draw(LAVAS, rng, 4500, 43.0, 24.0, 0.36)
    return x + 1.6 * np.sin(2 * np.pi * (x - 4.0) / 15.0)


# Several features: the measures of small birds that are caught in nets and ringed.
def warbler(theta: NDArray, rng: Rng) -> NDArray:
    """Return the length of the wing and of the tarsus of a bird in mm, and its mass in g.

    Both lengths and the lean mass follow the size of the bird. On top of that comes fat, which most have little of.
    """
    n = len(theta)
    size = theta[:, 1] * rng.standard_normal(n)
    wing = theta[:, 0] * np.exp(size + 0.011 * rng.standard_normal(n))
    tarsus = 0.31 * theta[:, 0] * np.exp(0.8 * size + 0.018 * rng.standard_normal(n))
    lean = theta[:, 2] * np.exp(2.6 * size + 0.03 * rng.standard_normal(n))
    fat = theta[:, 3] * rng.gamma(1.5, 1 / 1.5, n)
    return np.stack([wing, tarsus, lean * (1 + fat)], axis=1)


BIRDS = task(
    warbler,
    prior={"length": (58, 88), "spread": (0.012, 0.05), "lean": (7, 22), "fatness": (0.02, 0.4)},
    features=["wing", "tarsus", "mass"],
    name="ringed-birds",
)


@case(BIRDS, "single", right=("offset on wing", "scale on wing"), defensible=("offset on tarsus", "scale on tarsus"))
def birds_with_wings_not_flattened(rng: Rng) -> NDArray:
    """The ringers do not press the wing flat on the ruler: it comes out shorter by about a millimetre."""
    x = draw(BIRDS, rng, 1600, 67.0, 0.024, 11.0, 0.12)
    x[:, 0] -= rng.gamma(9.0, 0.9 / 9.0, len(x))
    return x


@case(
    BIRDS,
    "single",
    right=("conditional_response on mass",),
    defensible=("radiative_tail on mass", "scale on mass", "mixture", "spread", "correlation"),
)
def birds_that_will_cross_the_desert(rng: Rng) -> NDArray:
    """Birds with long wings come from the north, and in this month are those that fuel for the flight over the desert.

    The longer the wing, the likelier it is that a bird does so. What it then puts on is a tenth to a half of its mass.
    """
    x = draw(BIRDS, rng, 2200, 77.0, 0.027, 16.0, 0.07)
    fuels = rng.random(len(x)) < 0.75 / (1 + np.exp(-(x[:, 0] - 79.0) / 0.7))
    x[:, 2] *= 1 + fuels * rng.uniform(0.1, 0.5, len(x))
    return x


@case(BIRDS, "single", right=("quantisation on tarsus",), defensible=("resolution on tarsus",))
def birds_with_an_old_calliper(rng: Rng) -> NDArray:
    """Six tarsi of ten were measured with a calliper without a vernier, and read by eye to half a millimetre."""
    x = draw(BIRDS, rng, 1300, 65.0, 0.036, 10.5, 0.26)
    read = np.rint((x[:, 1] + rng.normal(0, 0.06, len(x))) / 0.5) * 0.5
    x[:, 1] = np.where(some(rng, len(x), 0.6), read, x[:, 1])
    return x


@case(BIRDS, "pair", right=("radiative_tail on wing", "saturation on mass"))
def birds_in_moult_on_a_small_balance(rng: Rng) -> NDArray:
    """In August three birds of ten are growing their longest feather, and lack up to a sixth of the wing.

    They were weighed with a spring balance that ends at 20 g: heavier ones pull the mark against the stop, where the
    ringer reads twenty or a tenth more or less.
    """
    x = draw(BIRDS, rng, 1800, 75.0, 0.026, 15.5, 0.17)
    x[:, 0] *= 1 - some(rng, len(x), 0.3) * rng.beta(1.1, 2.0, len(x)) / 6
    x[:, 2] = np.where(x[:, 2] > 20, 20 + 0.05 * rng.standard_normal(len(x)), x[:, 2])
    return x


@case(BIRDS, "outside")
def birds_on_the_wrong_line(rng: Rng) -> NDArray:
    """A line of the column of masses was left out in typing: two fifths of the birds have the mass of the next."""
    n = 2600
    x = draw(BIRDS, rng, n, 69.0, 0.038, 12.5, 0.06)
    slipped = int(0.4 * n)
    x[:slipped, 2] = x[1 : slipped + 1, 2]
    return x


# Several features: radio sources that stand in two catalogues.
def source(theta: NDArray, rng: Rng) -> NDArray:
    """Return the fluxes of a source at 150 and 1400 MHz and its size, as decadic logarithms of mJy and of arc seconds.

    The counts fall by a power of the flux from 10 mJy on. Most spectra are steep and scatter about a mean index; a
    share is flat. Faint sources are smaller on the sky.
    """
    n = len(theta)
    low = 1 + rng.standard_exponential(n) / (np.log(10) * theta[:, 0])
    steep = theta[:, 1] + theta[:, 2] * rng.standard_normal(n)
    flat = -0.1 + 0.2 * rng.standard_normal(n)
    index = np.where(rng.random(n) < theta[:, 3], flat, steep)
    size = 0.9 + 0.3 * (low - 1) + 0.33 * rng.standard_normal(n)
    return np.stack([low, low + index * np.log10(1400 / 150), size], axis=1)


SOURCES = task(
    source,
    prior={"slope": (0.6, 2), "index": (-1.1, -0.5), "scatter": (0.05, 0.3), "flat": (0.02, 0.4)},
    features=["low", "high", "size"],
    name="radio-sources",
)


@case(
    SOURCES,
    "single",
    right=("conditional_response on high",),
    defensible=("radiative_tail on high", "scale on high", "offset on high", "mixture", "correlation"),
)
def sources_resolved_out(rng: Rng) -> NDArray:
    """The array that mapped the sky at 1400 MHz has no short baselines, and does not see what is smooth and wide.

    Sources of more than some twenty arc seconds lose flux there, up to two thirds of it, and by how much of it is in
    knots, which is not the same in any two.
    """
    x = draw(SOURCES, rng, 3500, 1.1, -0.76, 0.13, 0.12)
    wide = 1 / (1 + (20 / 10 ** x[:, 2]) ** 3)
    x[:, 1] += np.log10(1 - wide * rng.uniform(0.1, 0.67, len(x)))
    return x


@case(
    SOURCES,
    "single",
    right=("edge_acceptance on low",),
    defensible=("edge_acceptance on high", "forward_backward_acceptance on low", "dead_region on low"),
)
def sources_near_the_limit(rng: Rng) -> NDArray:
    """In a third of the fields the noise at 150 MHz is worse, and most sources from 10 to 17 mJy are not found."""
    x = draw(SOURCES, rng, 5000, 1.5, -0.7, 0.15, 0.26)
    limit = np.where(some(rng, len(x), 0.35), rng.normal(17.0, 3.5, len(x)), 9.0)
    return x[10 ** x[:, 0] > limit]


@case(
    SOURCES,
    "single",
    right=("radiative_tail on low",),
    defensible=("outliers on low", "resolution on low", "radiative_tail on high", "outliers on high", "mixture"),
)
def sources_in_a_wide_beam(rng: Rng) -> NDArray:
    """At 150 MHz the beam is wide, and a quarter of the sources are measured with a neighbour, mostly a faint one."""
    x = draw(SOURCES, rng, 2400, 1.0, -0.85, 0.11, 0.08)
    neighbour = 3.0 * rng.random(len(x)) ** (-1 / 1.2)
    x[:, 0] = np.log10(10 ** x[:, 0] + some(rng, len(x), 0.25) * neighbour)
    return x


@case(SOURCES, "pair", right=("saturation on size", "edge_acceptance on high"))
def sources_small_and_faint(rng: Rng) -> NDArray:
    """No size below that of the beam can be told: for smaller sources the table gives 5 arc seconds, the limit.

    And the list is of those that were found at 1400 MHz as well, where half are lost at 3 mJy and few at 5.
    """
    x = draw(SOURCES, rng, 6000, 1.2, -0.72, 0.16, 0.15)
    x[:, 2] = np.maximum(x[:, 2], np.log10(5 + 0.05 * rng.standard_normal(len(x))))
    found = 10 ** x[:, 1] > rng.normal(3.0, 1.0, len(x))
    return x[found]


@case(SOURCES, "outside")
def sources_out_of_the_ordinary(rng: Rng) -> NDArray:
    """The list leaves out four of five sources of an ordinary spectrum, an index within 0.09 of -0.75, at any flux."""
    x = draw(SOURCES, rng, 6000, 1.1, -0.83, 0.21, 0.14)
    index = (x[:, 1] - x[:, 0]) / np.log10(1400 / 150)
    ordinary = np.abs(index + 0.75) < 0.09
    return x[~ordinary | some(rng, len(x), 0.2)]


CASES: list[Case] = [
    plain("diaries_plain", DIARIES, 3000, 2.8, 6.5, 1.1),
    diaries_filled_in_as_a_joke,
    diaries_with_nothing_to_tell,
    diaries_with_a_full_page,
    diaries_told_by_telephone,
    plain("tracks_plain", GRAINS, 1200, 26.0, 0.27),
    tracks_that_overlap,
    tracks_in_a_river_sand,
    tracks_in_chosen_grains,
    tracks_in_a_frame_that_was_fitted,
    plain("lavas_plain", LAVAS, 2500, 55.0, 32.0, 0.35),
    lavas_in_a_magnetised_holder,
    lavas_struck_by_lightning,
    lavas_that_have_weathered,
    lavas_on_a_worn_gear,
    plain("birds_plain", BIRDS, 4000, 70.0, 0.028, 12.0, 0.15),
    birds_with_wings_not_flattened,
    birds_that_will_cross_the_desert,
    birds_with_an_old_calliper,
    birds_in_moult_on_a_small_balance,
    birds_on_the_wrong_line,
    sources_resolved_out,
    sources_near_the_limit,
    sources_in_a_wide_beam,
    sources_small_and_faint,
    sources_out_of_the_ordinary,
]
"""The cases of this file."""
