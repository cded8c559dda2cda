"""Cases of two to four numbers: leaves, tracks in emulsion, marathons, polarised light, and ice cores."""

import numpy as np
from numpy.typing import NDArray

from avobench import task
from paper.cases.case import Case, case, draw, either, plain, some


def _leaf(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Length and width of a leaf, and the insects on it, in proportion to its area."""
    length, shape, insects = theta.T
    n = len(theta)
    long = length * np.exp(0.22 * rng.normal(size=n))
    wide = shape * long * np.exp(0.13 * rng.normal(size=n))
    return np.column_stack([long, wide, rng.poisson(insects * 0.7 * long * wide / 1000)])


LEAF = task(
    _leaf,
    prior={"length": (35, 90), "shape": (0.3, 0.9), "insects": (0.5, 4)},
    units={"length": "mm"},
    features=["length", "width", "insects"],
    kinds={"insects": "count"},
    name="leaf",
)


def _track(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Length of a track in emulsion, its grains, and the angle by which it was scattered, larger where it is short."""
    reach, grains, scatter = theta.T
    length = reach * rng.gamma(3.0, size=len(theta)) / 3
    angle = scatter * np.sqrt(50 / (length + 10)) * rng.normal(size=len(theta))
    return np.column_stack([length, rng.poisson(grains * length / 10), angle])


TRACK = task(
    _track,
    prior={"reach": (20, 80), "grains": (2, 8), "scatter": (1, 6)},
    units={"reach": "um", "scatter": "deg"},
    features=["length", "grains", "angle"],
    kinds={"grains": "count"},
    name="track",
)


def _marathon(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Minutes of the first and of the second half of a marathon."""
    half, slower, uneven = theta.T
    first = half * np.exp(0.14 * rng.normal(size=len(theta)))
    return np.column_stack([first, first * slower * np.exp(uneven * rng.normal(size=len(theta)))])


MARATHON = task(
    _marathon,
    prior={"half": (85, 160), "slower": (1, 1.3), "uneven": (0.02, 0.12)},
    units={"half": "min"},
    features=["first", "second"],
    name="marathon",
)


def _stokes(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """Stokes parameters of one exposure of a polarised star, in hundredths of its light."""
    q, u, noise = theta.T
    return np.column_stack([rng.normal(q, noise), rng.normal(u, noise)])


STOKES = task(
    _stokes,
    prior={"q": (-6, 6), "u": (-6, 6), "noise": (0.3, 3)},
    units={"q": "%", "u": "%", "noise": "%"},
    features=["q", "u"],
    name="stokes",
)


def _ice(theta: NDArray, rng: np.random.Generator) -> NDArray:
    """A layer of an ice core: thickness, oxygen isotopes, sodium and dust; cold years are thin and full of dust."""
    thickness, oxygen, sodium, dust = theta.T
    n = len(theta)
    cold = rng.normal(size=n)
    return np.column_stack(
        [
            thickness * np.exp(-0.15 * cold + 0.2 * rng.normal(size=n)),
            oxygen - 1.2 * cold + 1.5 * rng.normal(size=n),
            sodium * np.exp(0.1 * cold + 0.5 * rng.normal(size=n)),
            dust * np.exp(0.45 * cold + 0.35 * rng.normal(size=n)),
        ]
    )


ICE = task(
    _ice,
    prior={"thickness": (4, 25), "oxygen": (-45, -30), "sodium": (5, 60), "dust": (20, 300)},
    units={"thickness": "cm", "oxygen": "permil", "sodium": "ug/kg", "dust": "ug/kg"},
    features=["thickness", "oxygen", "sodium", "dust"],
    name="ice",
)


# Nothing is missing.
leaves_as_told = plain("leaves_as_told", LEAF, 1700, 58.0, 0.55, 1.8)
tracks_as_told = plain("tracks_as_told", TRACK, 7800, 43.0, 4.6, 2.7)
marathon_as_told = plain("marathon_as_told", MARATHON, 17_500, 118.0, 1.11, 0.055)
stokes_as_told = plain("stokes_as_told", STOKES, 420, 1.9, -2.6, 0.9)
ice_as_told = plain("ice_as_told", ICE, 3000, 11.0, -37.5, 22.0, 90.0)


# One effect.
@case(LEAF, "single", ("analysis_window on length", "truncation on length"), ("edge_acceptance on length",))
def leaves_that_fit(rng: np.random.Generator) -> NDArray:
    """The frame of the scanner takes leaves from 40 to 72 mm; others are thrown away, though one in twelve of the
    longer is put in aslant."""
    leaf = draw(LEAF, rng, 4200, 56.0, 0.6, 1.2)
    inside = (leaf[:, 0] > 40) & ((leaf[:, 0] < 72) | some(rng, 4200, 1 / 12))
    return leaf[inside]


@case(
    TRACK,
    "single",
    ("threshold_loss on grains",),
    ("turn_on on length", "truncation on length", "inefficiency on grains"),
)
def tracks_overlooked(rng: np.random.Generator) -> NDArray:
    """A scanner overlooks tracks of few grains: all below six, and the share that is found rises to one at sixteen."""
    track = draw(TRACK, rng, 6000, 38.0, 4.0, 3.0)
    return track[rng.random(6000) < np.clip((track[:, 1] - 5) / 11, 0, 1)]


@case(TRACK, "single", ("offset on length",), ("conditional_response on length", "turn_on on length"))
def tracks_with_stub(rng: np.random.Generator) -> NDArray:
    """Lengths are taken from the edge of the star at the vertex, eight micrometres before the track begins, in the
    older plates nine."""
    track = draw(TRACK, rng, 3500, 45.0, 5.0, 2.2)
    track[:, 0] += np.where(some(rng, 3500, 0.4), 9.0, 8.0)
    return track


@case(MARATHON, "single", ("conditional_response on second",), ("radiative_tail on second", "mixture"))
def marathon_with_wall(rng: np.random.Generator) -> NDArray:
    """Runners who go out fast hit the wall: the faster the first half below 125 minutes, the slower the second, and
    the more unlike each other (Smyth 2018)."""
    split = draw(MARATHON, rng, 9800, 120.0, 1.06, 0.04)
    haste = np.maximum(125 - split[:, 0], 0) / 25
    split[:, 1] *= 1 + haste * (0.07 + 0.06 * rng.normal(size=9800))
    return split


@case(MARATHON, "single", ("mixture",), ("peak_background on first", "peak_background on second", "radiative_tail"))
def marathon_with_walkers(rng: np.random.Generator) -> NDArray:
    """A tenth walk for charity: 152 minutes for a half, and the second is 1.2 times as long."""
    walks = some(rng, 5600, 0.1)
    return either(walks, draw(MARATHON, rng, 5600, 152.0, 1.2, 0.08), draw(MARATHON, rng, 5600, 104.0, 1.05, 0.04))


@case(STOKES, "single", ("crosstalk on q",), ("correlation", "conditional_response on q"))
def stokes_with_leak(rng: np.random.Generator) -> NDArray:
    """The wave plate is not at its angle: a quarter of u is added to q, a little more in the warm part of the night."""
    light = draw(STOKES, rng, 4600, 2.0, 3.0, 1.3)
    light[:, 0] += np.linspace(0.2, 0.34, 4600) * light[:, 1]
    return light


@case(STOKES, "single", ("spread",), ("mixture", "resolution on u", "flat_background on u", "peak_background on u"))
def stokes_of_blazar(rng: np.random.Generator) -> NDArray:
    """The jet swings: u itself runs to and fro between -2 and 4, and stays long at either end, while q is at rest."""
    swing = 1 + 3 * np.sin(rng.uniform(0, 2 * np.pi, 2700))
    return STOKES.simulate(np.column_stack([np.full(2700, -1.5), swing, np.full(2700, 0.8)]), rng)


@case(ICE, "single", ("correlation",), ("crosstalk on sodium", "crosstalk on dust", "conditional_response on dust"))
def ice_diluted(rng: np.random.Generator) -> NDArray:
    """The melt water of sodium and of dust is diluted by one pump, whose flow errs by a third: both are wrong by one
    factor, skewed to small values."""
    ice = draw(ICE, rng, 6200, 12.0, -38.0, 24.0, 110.0)
    ice[:, 2:] *= np.exp(0.45 - 0.45 * rng.gamma(1.2, size=6200))[:, None]
    return ice


# Two effects.
@case(
    LEAF,
    "pair",
    ("heaping on length", "zero_inflation on insects"),
    ("quantisation on length", "mixture", "overdispersion on insects"),
)
def leaves_of_sprayed_trees(rng: np.random.Generator) -> NDArray:
    """A part of the pickers read lengths to five millimetres, four leaves in ten; and a quarter are from sprayed
    trees, where no insect or only a few of them live."""
    leaf = draw(LEAF, rng, 5200, 60.0, 0.5, 2.2)
    leaf[:, 0] = np.where(some(rng, 5200, 0.4), 5 * np.round(leaf[:, 0] / 5), leaf[:, 0])
    left = np.where(some(rng, 5200, 0.25), rng.choice([0.0, 0.15], 5200, p=[0.8, 0.2]), 1.0)
    leaf[:, 2] = rng.binomial(leaf[:, 2].astype(int), left)
    return leaf


@case(
    TRACK,
    "pair",
    ("flat_background on angle", "quantisation on length"),
    ("outliers on angle", "mixture", "heaping on length", "resolution on angle"),
)
def tracks_old_plates(rng: np.random.Generator) -> NDArray:
    """A twelfth of the angles belong to old tracks that cross by chance, at any angle within 25 degrees, more often
    near to the plane; and lengths are read in divisions of six micrometres."""
    track = draw(TRACK, rng, 8300, 50.0, 3.5, 2.5)
    chance = 25 * rng.choice([-1, 1], 8300) * rng.beta(1.0, 1.2, 8300)
    track[:, 2] = np.where(some(rng, 8300, 1 / 12), chance, track[:, 2])
    track[:, 0] = 6 * np.round(track[:, 0] / 6)
    return track


@case(STOKES, "pair", ("charge_misid on u", "outliers on q"), ("mixture", "resolution on q", "flat_background on q"))
def stokes_from_two_domes(rng: np.random.Generator) -> NDArray:
    """The sign of u follows another convention in one exposure of nine; and cosmic rays hit one of fourteen in the
    beam of q alone, with errors of a long tail."""
    light = draw(STOKES, rng, 3300, 0.5, 3.4, 1.0)
    light[:, 1] *= np.where(some(rng, 3300, 1 / 9), -1, 1)
    light[:, 0] += np.where(some(rng, 3300, 1 / 14), 5 * rng.standard_t(3, 3300), 0.0)
    return light


@case(
    ICE,
    "pair",
    ("radiative_tail on dust", "censoring on sodium"),
    ("outliers on dust", "mixture", "second_exponential on dust", "saturation on sodium", "truncation on sodium"),
)
def ice_of_stormy_years(rng: np.random.Generator) -> NDArray:
    """In a fifth of the layers dust storms add to the dust, by an exponential law of 1.5 times its mean; and sodium
    below the limit of the instrument, 12, is given as the limit."""
    ice = draw(ICE, rng, 4700, 9.0, -40.0, 20.0, 80.0)
    ice[:, 3] += np.where(some(rng, 4700, 0.2), rng.exponential(120.0, 4700), 0.0)
    ice[:, 2] = np.maximum(ice[:, 2], 12.0)
    return ice


# Effects outside the catalogue.
@case(MARATHON, "outside")
def marathon_with_columns_exchanged(rng: np.random.Generator) -> NDArray:
    """For the runners of one wave, one of four, the columns of the two halves were exchanged."""
    split = draw(MARATHON, rng, 7700, 112.0, 1.16, 0.035)
    return either(some(rng, 7700, 0.25), split[:, ::-1], split)


@case(STOKES, "outside")
def stokes_of_half_the_angle(rng: np.random.Generator) -> NDArray:
    """The angle in the plane of q and u was halved, as if it were the angle on the sky: a disc around the middle
    became a half disc, and what lay at negative q lies above or below."""
    light = draw(STOKES, rng, 2200, -0.6, 0.9, 1.6)
    angle = np.arctan2(light[:, 1], light[:, 0]) / 2
    return np.hypot(light[:, 0], light[:, 1])[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


@case(ICE, "outside")
def ice_with_labels_mixed(rng: np.random.Generator) -> NDArray:
    """A tray of bottles was put in the wrong order: for six layers in ten the dust is that of some other layer, so
    that each number is as it should be, and the dust no longer goes with the cold."""
    ice = draw(ICE, rng, 6900, 14.0, -36.0, 30.0, 70.0)
    mixed = np.flatnonzero(some(rng, 6900, 0.6))
    ice[mixed, 3] = ice[rng.permutation(mixed), 3]
    return ice


CASES: list[Case] = [value for value in list(globals().values()) if isinstance(value, Case)]
