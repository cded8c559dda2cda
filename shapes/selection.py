"""Shapes of real features that lose events or add events and values of another origin.

Settings that are lengths or places are given in half ranges, and angles in radians.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtr

from avobench.challenge.shape import Place
from shapes.primitives import Library, either, log

SELECTION = Library("continuous")

SIDE = either(1, 1)
"""The end of the range at which something happens, -1 or 1."""


def cosine(place: Place) -> bool:
    """Whether the place is the cosine of an angle."""
    return place.cosine


def unbounded(place: Place) -> bool:
    """Whether the place is of features that may have any value."""
    return not place.cosine


def angle(x: NDArray) -> NDArray[np.float64]:
    """The angle (rad) whose cosine is x."""
    return np.arccos(np.clip(x, -1, 1))


def cotangent(x: NDArray) -> NDArray[np.float64]:
    """Where a track crosses a cylinder of radius one, along its axis."""
    return x / np.sqrt(np.maximum(1 - x**2, 1e-12))


def size(n: int, at: Place) -> tuple[int, int]:
    """The size of the features of n events: (n, k)."""
    return n, len(at.columns)


def spectrum(density: Callable, n: int, at: Place, rng: np.random.Generator) -> NDArray[np.float64]:
    """Values in [-1, 1] of a density that need not be normalised: (n, k)."""
    edges = np.linspace(-1, 1, 2001)
    share = np.cumsum(density((edges[1:] + edges[:-1]) / 2))
    return np.interp(rng.random(size(n, at)), np.r_[0, share / share[-1]], edges)


def stretched(x: NDArray, at: Place, reach: float) -> NDArray[np.float64]:
    """Values in [-1, 1] that reach beyond the range by a factor, unless they are cosines."""
    return x if at.cosine else reach * x


def changed(x: NDArray, y: NDArray, share: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A share of the values x is replaced by y, each feature for itself."""
    return np.where(rng.random(x.shape) < share, y, x)


# Losses at the edges of the range.


@SELECTION.keep("edge_acceptance", on="any", strength=(0.05, 0.95), begin=(0.7, 0.95), width=(0.03, 0.12))
def erf_turn_on(x, at, by, rng):
    """Events near both ends of the range are lost, and the resolution of the detector's rim blurs where this begins."""
    return 1 - by.strength * ndtr((np.abs(x) - by.begin) / by.width)


@SELECTION.keep("edge_acceptance", suits=cosine, strength=(0.05, 0.6), width=log(0.001, 0.1))
def beam_pipe(x, at, by, rng):
    """Particles within a small angle (rad) of the beam escape through the beam pipe, which ends sharply or softly."""
    return expit((angle(np.abs(x)) - by.strength) / by.width)


@SELECTION.keep("edge_acceptance", on="any", strength=(0.05, 1.0), depth=log(0.05, 0.3))
def rim_loss(x, at, by, rng):
    """Events near either end of the range leak out and are lost, exponentially fewer the further they are from it."""
    return 1 - by.strength * np.exp(-np.maximum(1 - np.abs(x), 0) / by.depth)


@SELECTION.keep("edge_acceptance", on="any", strength=(0.05, 0.95), begin=(0.6, 0.9), layers=(2, 6))
def layers_missed(x, at, by, rng):
    """Towards both ends of the range particles miss one layer after the other, and each step costs more events."""
    beyond = np.clip((np.abs(x) - by.begin) / (1 - by.begin), 0, 1)
    return 1 - by.strength * np.ceil(int(by.layers) * beyond) / int(by.layers)


@SELECTION.keep("edge_acceptance", strength=(0.08, 0.9), power=(3, 9))
def vignetting(x, at, by, rng):
    """The light falls off towards both ends of the range as a power, so that ever more events are lost there."""
    return 1 - by.strength * np.minimum(np.abs(x), 1) ** by.power


@SELECTION.keep("edge_acceptance", strength=(0.05, 1.0), clear=(0.2, 0.8))
def shaded_mirror(x, at, by, rng):
    """The tube of a telescope shades its mirror, so both ends of the field lose light as two circles move apart."""
    apart = np.clip((np.abs(x) - by.clear) / (1 - by.clear), 0, 1)
    return 1 - by.strength * (1 - 2 / np.pi * (np.arccos(apart) - apart * np.sqrt(1 - apart**2)))


@SELECTION.keep("edge_acceptance", strength=(0.12, 1.2))
def natural_vignetting(x, at, by, rng):
    """Light that comes in aslant arrives as the fourth power of the cosine of its slant, so both ends lose events."""
    return (1 + (by.strength * x) ** 2) ** -2.0


@SELECTION.keep("edge_acceptance", strength=(0.02, 1.5), longest=(3, 8))
def slant_absorption(x, at, by, rng):
    """Towards both ends particles cross a wall ever more aslant, and more of them are absorbed on the longer way."""
    return np.exp(-by.strength * (1 / np.sqrt(np.maximum(1 - x**2, by.longest**-2)) - 1))


@SELECTION.keep("edge_acceptance", suits=cosine, strength=(0.05, 3.0), length=(1.0, 2.5))
def short_lever_arm(x, at, by, rng):
    """A track at a small angle leaves the barrel through its end, and with fewer layers it is more rarely found."""
    return np.minimum(by.length / np.maximum(np.abs(cotangent(x)), 1e-9), 1) ** by.strength


@SELECTION.keep("edge_acceptance", strength=(0.08, 0.9), edge=(0.55, 0.85), step=(0.05, 0.2), side=SIDE)
def raised_collimator(x, at, by, rng):
    """A collimator shadows one end of the range, and for half of the run it stands further in than planned."""
    beyond = by.side * x - by.edge
    return 1 - by.strength * ((beyond > 0).astype(float) + (beyond > by.step)) / 2


@SELECTION.keep("edge_acceptance", strength=(0.008, 1.2), half_shadow=(0.1, 1.0), remnant=(0, 0.02), side=SIDE)
def collimator_jaw(x, at, by, rng):
    """A collimator covers one end of the range, and in its half shadow the recorded share rises linearly to all."""
    covered = 1 - (1 - by.side * x) / by.strength
    return np.clip(1 - covered / by.half_shadow, by.remnant, 1)


@SELECTION.keep("edge_acceptance", strength=(0.001, 0.3), spared=(0, 0.2), side=SIDE)
def preselected_sample(x, at, by, rng):
    """A filter loses the events beyond a limit on one side, except for a few that pass through a parallel channel."""
    limit = at.quantile(1 - by.strength if by.side > 0 else by.strength)
    return np.where(by.side * (x - limit) > 0, by.spared, 1.0)


@SELECTION.keep("edge_acceptance", suits=unbounded, strength=(0.1, 1.0), depth=(0.1, 0.4), side=SIDE)
def leaking_edge(x, at, by, rng):
    """Close to one end of the range the signal leaks out through the wall, and such events often fail the selection."""
    return 1 - by.strength * np.exp(-np.maximum(1 - by.side * x, 0) / by.depth)


@SELECTION.keep("edge_acceptance", strength=(0.01, 0.6), haze=(0.05, 0.2), side=SIDE)
def horizon_extinction(x, at, by, rng):
    """Light from near the horizon, at one end of the range, crosses more air than other light and is absorbed in it."""
    height = np.clip((1 + by.side * x) / 2, 0, 1)
    return np.exp(-by.strength * ((1 + by.haze) / (height + by.haze) - 1))


@SELECTION.keep("edge_acceptance", strength=(0.01, 0.4), side=SIDE)
def horizon(x, at, by, rng):
    """One end of the range is at the horizon, and light crosses an air mass of one over the sine of its altitude."""
    altitude = np.pi / 4 * np.clip(1 - by.side * x, 0.03, 2)
    return np.exp(-by.strength * (1 / np.sin(altitude) - 1))


@SELECTION.keep("edge_acceptance", strength=(0.12, 0.7), width=(0.4, 0.8), side=SIDE)
def long_rise(x, at, by, rng):
    """The trigger's efficiency rises slowly from one end of the range and reaches its plateau beyond the middle."""
    return 1 - by.strength * np.exp(-(np.maximum(by.side * x + 1, 0) ** 2) / (2 * by.width**2))


@SELECTION.keep("edge_acceptance", strength=(0.01, 0.35), noise=(0.1, 0.4), side=SIDE)
def turn_on(x, at, by, rng):
    """The trigger asks for a value some way inside one end of the range, and its own noise blurs the demand."""
    return ndtr(((1 - by.side * x) / by.strength - 1) / by.noise)


@SELECTION.keep("edge_acceptance", suits=unbounded, strength=(0.03, 0.4), steepness=(4.0, 12.0))
def hill_trigger(x, at, by, rng):
    """The trigger sees part of the signal, so few small values and nearly all large ones pass, with a gradual rise."""
    half = np.maximum(at.quantile(by.strength) + 1, 0.02)
    return 1 / (1 + (half / np.maximum(x + 1, 1e-3)) ** by.steepness)


@SELECTION.keep("edge_acceptance", suits=unbounded, strength=(0.01, 0.4), spread=(0.1, 0.35))
def scattered_levels(x, at, by, rng):
    """Many channels trigger at levels that lie evenly between two bounds, where the efficiency rises linearly."""
    return np.clip((x - at.quantile(by.strength)) / (2 * by.spread) + 0.5, 0, 1)


# Losses of one half of the range.


@SELECTION.keep("forward_backward_acceptance", strength=(0.02, 0.95), width=log(0.01, 0.25), side=SIDE)
def weak_half(x, at, by, rng):
    """One half of the detector misses a share of its events, and the passage to the other half is washed out."""
    return 1 - by.strength * expit(by.side * x / by.width)


@SELECTION.keep("forward_backward_acceptance", on="any", strength=(0.02, 0.6), width=(0.4, 1.5), side=SIDE)
def fading_side(x, at, by, rng):
    """The efficiency falls from one end of the range to the other, most steeply in the middle."""
    return 1 - by.strength * expit(4 * by.side * x / by.width)


@SELECTION.keep("forward_backward_acceptance", on="any", strength=(0.02, 0.6), width=(0.02, 0.15), side=SIDE)
def two_halves(x, at, by, rng):
    """One half of the detector is less efficient, and the resolution blurs the border between the halves."""
    return 1 - by.strength * ndtr(by.side * x / by.width)


@SELECTION.keep("forward_backward_acceptance", strength=(0.02, 0.6), overlap=log(0.02, 0.3), side=SIDE)
def half_off(x, at, by, rng):
    """One half of the detector is off for a share of the time, and where the halves overlap the loss rises linearly."""
    return 1 - by.strength * (1 + np.clip(by.side * x / by.overlap, -1, 1)) / 2


@SELECTION.keep("forward_backward_acceptance", strength=(0.03, 1.2), side=SIDE)
def one_end_readout(x, at, by, rng):
    """A long bar is read out at one end only, and the signal is absorbed exponentially on the way to this end."""
    return np.exp(-by.strength * np.clip(1 + by.side * x, 0, 2) / 2)


@SELECTION.keep("forward_backward_acceptance", on="any", strength=(0.03, 0.9), length=(0.5, 2), side=SIDE)
def attenuated_light(x, at, by, rng):
    """Events are lost at the end far from the readout, and exponentially fewer the further they are from this end."""
    return 1 - by.strength * np.exp(-(1 - np.clip(by.side * x, -1, 1)) / by.length)


@SELECTION.keep("forward_backward_acceptance", suits=cosine, strength=(0.08, 0.8), power=(0.3, 1.0), side=SIDE)
def material_in_front(x, at, by, rng):
    """Cables run out on one side only, and the absorption in them rises as a power of the cosine."""
    return np.exp(-by.strength * np.maximum(by.side * x, 0) ** by.power)


@SELECTION.keep("forward_backward_acceptance", strength=(0.03, 0.9), rise=(0.1, 0.6), side=SIDE)
def windward_dust(x, at, by, rng):
    """Dust settles on the windward half of a dome and takes light away there, more towards the rim."""
    return 1 - by.strength * np.clip(by.side * x, 0, 1) ** by.rise


# Losses inside the range.


@SELECTION.keep("dead_region", on="any", strength=(0.01, 0.25), middle=(-0.8, 0.8), side=(0.1, 0.5), residual=(0, 0.4))
def soft_gap(x, at, by, rng):
    """Most events are lost in a gap of the range, whose sides are washed out."""
    u = (x - by.middle) / by.strength
    return 1 - (1 - by.residual) * ndtr((u + 1) / by.side) * ndtr((1 - u) / by.side)


@SELECTION.keep("dead_region", on="any", strength=(0.02, 0.35), middle=(-0.8, 0.8), depth=(0.6, 1))
def tapered_gap(x, at, by, rng):
    """Particles cross a crack aslant, so the losses rise linearly towards its middle and fall linearly beyond."""
    return 1 - by.depth * np.clip(1 - np.abs(x - by.middle) / by.strength, 0, 1)


@SELECTION.keep("dead_region", strength=(0.03, 1.0), spot=(-0.6, 0.6), width=log(0.04, 0.15))
def worn_spot(x, at, by, rng):
    """A beam has damaged one spot, and events are lost there as the Gaussian profile of the beam."""
    return 1 - by.strength * np.exp(-(((x - by.spot) / by.width) ** 2) / 2)


@SELECTION.keep("dead_region", strength=(0.04, 0.6), middle=(-0.5, 0.5), hole=(0.05, 0.15), path=(0.1, 0.3))
def sliding_hole(x, at, by, rng):
    """A hole that records nothing slides along the range during part of the run, and leaves a shallow trough."""
    wide, narrow = by.hole + by.path, np.abs(by.hole - by.path)
    return 1 - by.strength * np.clip((wide - np.abs(x - by.middle)) / max(wide - narrow, 1e-6), 0, 1)


@SELECTION.keep("dead_region", strength=(0.04, 0.6), start=(-0.6, 0.0), period=(0.15, 0.3), blind=(0.2, 0.4))
def spacer_ribs(x, at, by, rng):
    """Three ribs that hold the chamber together stand at equal distances, and few events are recorded behind them."""
    rib, inside = np.divmod((x - by.start) / by.period, 1)
    return 1 - by.strength * ((rib >= 0) & (rib < 3) & (inside < by.blind))


@SELECTION.keep("dead_region", strength=(0.003, 0.175), middle=(-0.6, 0.6), half_shadow=log(0.2, 2), remnant=(0, 0.02))
def support_rib(x, at, by, rng):
    """A rib hides a part of the range, and beside its full shadow there is a half shadow of so many half widths."""
    return np.clip((np.abs(x - by.middle) / by.strength - 1) / by.half_shadow, by.remnant, 1)


@SELECTION.keep("dead_region", strength=(0.004, 0.35), module=(0.2, 0.75), residual=(0, 0.17))
def barrel_gaps(x, at, by, rng):
    """There is a gap on either side of the middle module of the detector, where most events are lost."""
    return np.where(np.abs(np.abs(x) - by.module) < by.strength / 2, by.residual, 1.0)


@SELECTION.keep("dead_region", suits=cosine, strength=(0.05, 1.0), middle=(0.5, 0.8), width=(0.03, 0.1))
def cable_gap(x, at, by, rng):
    """Cables leave through a gap between the barrel and each of its end caps, where tracks are seldom recorded."""
    return 1 - by.strength * (np.abs(np.abs(x) - by.middle) < by.width / 2)


@SELECTION.keep("dead_region", strength=(0.1, 4.0), middle=(-0.6, 0.6), width=(0.04, 0.15))
def dust_lane(x, at, by, rng):
    """A lane of dust, thickest along its middle, crosses the field and absorbs what lies behind it."""
    return np.exp(-by.strength / np.cosh(np.clip((x - by.middle) / by.width, -20, 20)) ** 2)


@SELECTION.keep("dead_region", strength=(0.07, 4), line=(-0.55, 0.55), width=log(0.03, 0.1))
def absorption_line(x, at, by, rng):
    """A gas in the light path absorbs in a Lorentzian line, by the law of Beer and Lambert."""
    return np.exp(-by.strength / (1 + ((x - by.line) / by.width) ** 2))


@SELECTION.keep("dead_region", strength=(0.1, 1.0), middle=(-0.5, 0.5), radius=(0.06, 0.25))
def round_beam_stop(x, at, by, rng):
    """A round stop catches the direct beam, and its shadow is as deep as the chord of a circle is long."""
    return 1 - by.strength * np.sqrt(np.maximum(1 - ((x - by.middle) / by.radius) ** 2, 0))


# Events that are spread over the range.


@SELECTION.replace("flat_background", on="any", strength=(0.005, 0.35), reach=(0.9, 1.0))
def random_triggers(n, at, by, rng):
    """Noise or stray particles make events, whose values lie anywhere in the sensitive range with equal chance."""
    return rng.uniform(-by.reach, by.reach, size(n, at))


@SELECTION.replace(
    "flat_background", on="any", strength=(0.01, 0.4), slope=(-0.25, 0.25), curvature=(-0.6, 0.3), softness=(0.0, 0.15)
)
def nearly_flat(n, at, by, rng):
    """Events of another origin lie nearly evenly over the range, a little denser in its middle or at its ends."""
    u = spectrum(lambda u: 1 + by.slope * u + by.curvature * (3 * u**2 - 1) / 2, n, at, rng)
    return u if at.cosine else u + by.softness * rng.standard_normal(u.shape)


@SELECTION.replace("flat_background", on="any", strength=(0.008, 0.35), slope=either(0.02, 0.6), reach=(0.95, 1.3))
def combinatorial(n, at, by, rng):
    """Some events are combined of particles that do not belong together, and their density is a straight line."""
    return stretched(spectrum(lambda u: 1 + by.slope * u, n, at, rng), at, by.reach)


@SELECTION.replace("flat_background", on="any", strength=(0.008, 0.35), slope=either(0.1, 0.7))
def room_return(n, at, by, rng):
    """Neutrons come back from the walls of the hall, and their density falls exponentially towards one end."""
    return spectrum(lambda u: np.exp(by.slope * u), n, at, rng)


@SELECTION.replace("flat_background", on="any", strength=(0.008, 0.35), narrow=(0.05, 0.375), reach=(1.0, 1.25))
def accidental_coincidences(n, at, by, rng):
    """Two unrelated gates overlap by chance, and the difference in time lies on a plateau that slopes at both ends."""
    wide, narrow = rng.uniform(-1, 1, (2, *size(n, at)))
    return stretched((1 - by.narrow) * wide + by.narrow * narrow, at, by.reach)


@SELECTION.replace("flat_background", strength=(0.014, 0.25), ends=(0.6, 0.95))
def beam_gas_spells(n, at, by, rng):
    """The beam hits residual gas, and such events are spread widely, with soft ends on both sides."""
    return stretched(by.ends * rng.uniform(-1, 1, n) + (1 - by.ends) * rng.triangular(-1, 0, 1, n), at, 1.25)


@SELECTION.replace(
    "flat_background", on="any", strength=(0.01, 0.4), channels=(6, 25), spread=(0.05, 0.3), seed=(0, 2**31)
)
def uneven_noise(n, at, by, rng):
    """Noise makes events evenly within each channel of the detector, and nearly evenly between the channels."""
    rate = np.exp(by.spread * np.random.default_rng(int(by.seed)).standard_normal(int(by.channels)))
    channel = rng.choice(len(rate), size(n, at), p=rate / rate.sum())
    return 2 * (channel + rng.random(channel.shape)) / len(rate) - 1


@SELECTION.replace("flat_background", on="any", strength=(0.005, 0.5), reach=(1.0, 1.8))
def cosmic_rays(n, at, by, rng):
    """Muons from the sky pass close to the centre by chance, and are spread broadly but avoid the ends."""
    return stretched(2 * rng.beta(1.5, 1.5, size(n, at)) - 1, at, by.reach)


# Events that gather at one value.


@SELECTION.replace(
    "peak_background", on="any", strength=(0.003, 0.15), line=(-0.7, 0.7), width=log(0.01, 0.08), cut=log(4.5, 100)
)
def breit_wigner(n, at, by, rng):
    """A resonance lies under the events, a line of Breit and Wigner (1936) that is cut after so many half widths."""
    low, high = np.arctan(np.clip((np.array([-1, 1]) - by.line) / by.width, -by.cut, by.cut))
    return by.line + by.width * np.tan(rng.uniform(low, high, size(n, at)))


@SELECTION.replace(
    "peak_background",
    on="any",
    strength=(0.002, 0.15),
    line=(-0.75, 0.75),
    width=log(0.01, 0.06),
    tail=either(0.02, 0.15),
    tailed=(0.3, 1.0),
)
def tailed_line(n, at, by, rng):
    """A line is blurred, and a share of its events lies in an exponential tail to one side."""
    lost = rng.standard_exponential(size(n, at)) * (rng.random(size(n, at)) < by.tailed)
    return by.line + by.width * rng.standard_normal(size(n, at)) + by.tail * lost


@SELECTION.replace("peak_background", on="any", strength=(0.003, 0.1), edge=(-0.7, 0.7), tail=either(0.05, 0.25))
def jacobian_peak(n, at, by, rng):
    """Events gather before a kinematic edge, beyond which there are none, and thin out to the other side."""
    return by.edge + by.tail * (np.sqrt(1 - rng.random(size(n, at)) ** 2) - 1)


@SELECTION.replace(
    "peak_background",
    strength=(0.003, 0.25),
    line=(-0.7, 0.7),
    apart=either(0.08, 0.3),
    first=(0.5, 0.85),
    width=log(0.05, 0.25),
)
def doublet(n, at, by, rng):
    """A calibration source leaks in, whose two neighbouring lines are of unequal strength."""
    return by.line + by.apart * ((rng.random(n) > by.first) + by.width * rng.standard_normal(n))


@SELECTION.replace("peak_background", strength=(0.003, 0.15), middle=(-0.7, 0.7), gap=(0.03, 0.12))
def copper_doublet(n, at, by, rng):
    """The collimator glows in two narrow X-ray lines, and the upper one is twice as strong as the lower."""
    return by.middle + by.gap * (np.where(rng.random(n) < 1 / 3, -0.5, 0.5) + rng.logistic(0, 0.11, n))


@SELECTION.replace("peak_background", strength=(0.002, 0.1), spot=(-0.75, 0.75), radius=(0.03, 0.15))
def scraper_spot(n, at, by, rng):
    """Stray beam hits a round spot of metal, and all events from it appear in one place."""
    return by.spot + by.radius * np.sqrt(rng.random(n)) * np.cos(2 * np.pi * rng.random(n))


@SELECTION.replace("peak_background", strength=(0.003, 0.1), reach=log(0.03, 0.12), side=SIDE)
def beam_halo(n, at, by, rng):
    """Particles that accompany the beam gather at one end of the range and fall off exponentially from it."""
    return by.side * (1 - np.minimum(by.reach * rng.standard_exponential(n), 2))


@SELECTION.replace("peak_background", strength=(0.003, 0.15), slit=(-0.7, 0.7), width=log(0.04, 0.2))
def slit_image(n, at, by, rng):
    """Light of a calibration lamp falls through a slit and adds an even patch with a half shadow at both sides."""
    return by.slit + by.width * (rng.uniform(-0.5, 0.5, n) + rng.uniform(-0.15, 0.15, n))


# Values that are far off.


@SELECTION.map("outliers", on="any", suits=unbounded, strength=(0.003, 0.15), width=(1, 3))
def student_tails(x, at, by, rng):
    """A share of the values is badly measured, with errors of Student's t distribution with 2.5 degrees of freedom."""
    return changed(x, x + by.width * at.spread * rng.standard_t(2.5, x.shape), by.strength, rng)


@SELECTION.map("outliers", on="any", suits=unbounded, strength=(0.003, 0.15), width=(0.7, 2))
def landau_tails(x, at, by, rng):
    """A share of the values is too large by the losses of energy that Moyal's formula (1955) describes."""
    return changed(x, x - 2 * by.width * at.spread * np.log(np.abs(rng.standard_normal(x.shape))), by.strength, rng)


@SELECTION.map("outliers", on="any", suits=unbounded, strength=(0.003, 0.15), lowest=(0.7, 1.5))
def bit_flips(x, at, by, rng):
    """One of three high bits of a value is flipped now and then, which moves it up if the bit was 0, else down."""
    bit = by.lowest * at.spread * 2.0 ** rng.integers(3, size=x.shape)
    one = np.floor((x + at.centre / at.half_range) / bit) % 2
    return changed(x, x + bit * (1 - 2 * one), by.strength, rng)


@SELECTION.flip("outliers", suits=unbounded, stage=4, strength=(0.001, 0.05))
def flipped_bits(x, at, by, rng):
    """A bit of the stored number is flipped in a few values, which are off by its large weight to either side."""
    return x + 1.5 * 2.0 ** rng.integers(3, size=x.shape) * rng.choice([-1, 1], x.shape)


@SELECTION.map("outliers", on="any", suits=unbounded, stage=4, strength=(0.0004, 0.04))
def decimal_slip(x, at, by, rng):
    """The decimal point of a few values is typed one place too far right, so that they are ten times too large."""
    return changed(x, 10 * x + 9 * at.centre / at.half_range, by.strength, rng)


@SELECTION.flip("outliers", on="any", suits=unbounded, stage=4, strength=(0.0004, 0.01), factor=either(4, 16, log=True))
def wrong_range(x, at, by, rng):
    """A few events are read with the gain of another range, so that their distance from the middle is many times."""
    return by.factor * x


@SELECTION.map(
    "outliers",
    on="any",
    suits=unbounded,
    stage=4,
    strength=(0.0004, 0.008),
    least=(3, 6),
    tail=(1.2, 3),
    positive=(0.2, 1),
)
def lightning_strikes(x, at, by, rng):
    """Discharges strike in bursts of five events, and throw half of these off by many standard deviations."""
    burst = np.repeat(rng.random(len(x) // 5 + 1) < 2 * by.strength, 5)[: len(x), None]
    struck = burst & (rng.random((len(x), 1)) < 0.5)
    throw = np.minimum(by.least * (1 + rng.pareto(by.tail, x.shape)), 50) * at.spread
    return x + struck * throw * np.where(rng.random(x.shape) < by.positive, 1, -1)


@SELECTION.flip("outliers", on="any", suits=unbounded, strength=(0.002, 0.08), least=either(2.0, 6.0))
def lightning_pickup(x, at, by, rng):
    """Lightning induces pulses in long cables, and the few events during them are all too large in one direction."""
    return x + by.least * at.spread * (1 + rng.standard_exponential(x.shape))


@SELECTION.flip("outliers", strength=(0.0004, 0.06), least=(1.0, 2.0), tail=(1.2, 4), most=log(10, 100), side=SIDE)
def spikes(x, at, by, rng):
    """Cosmic rays or sparks add spikes to a few values, all in one direction, with heights that follow a power law."""
    return x + by.side * by.least * np.minimum(1 + rng.pareto(by.tail, x.shape), by.most)


@SELECTION.flip("outliers", strength=(0.003, 0.1), wavelength=(0.5, 1.3))
def cycle_slips(x, at, by, rng):
    """A receiver loses lock and counts whole wavelengths too many or too few, which a few values are then off by."""
    return x + by.wavelength * rng.geometric(0.6, x.shape) * rng.choice([-1, 1], x.shape)


@SELECTION.flip("outliers", strength=(0.004, 0.25), kink=(0.4, 1))
def decay_in_flight(x, at, by, rng):
    """A few particles decay on their way, and the kink throws the value or the angle (rad) off to either side."""
    kink = by.kink * rng.choice([-1, 1], x.shape) * (0.5 + rng.standard_exponential(x.shape))
    return np.cos(angle(x) - kink) if at.cosine else x + kink


@SELECTION.flip("outliers", suits=cosine, strength=(0.01, 0.3), width=(0.5, 1.5))
def hard_scattering(x, at, by, rng):
    """A share of the tracks is scattered by a large angle (rad), of an exponential distribution to either side."""
    return np.cos(angle(x) + rng.laplace(0, by.width, x.shape))


@SELECTION.flip("outliers", suits=cosine, strength=(0.02, 0.5), mean=(0.7, 2))
def nuclear_scattering(x, at, by, rng):
    """A share of the particles is scattered by a nucleus, by a large angle (rad) to any side in space."""
    polar, azimuth = rng.exponential(by.mean, x.shape), rng.uniform(0, 2 * np.pi, x.shape)
    return np.clip(x * np.cos(polar) + np.sin(angle(x)) * np.sin(polar) * np.cos(azimuth), -1, 1)


@SELECTION.flip("outliers", suits=cosine, strength=(0.004, 0.12), distance=(1.5, 4.0))
def wrong_vertex(x, at, by, rng):
    """A few tracks are attached to another collision far along the beam, and their direction comes out far off."""
    slope = cotangent(x) + by.distance * rng.uniform(0.7, 1.3, x.shape) * rng.choice([-1, 1], x.shape)
    return slope / np.sqrt(1 + slope**2)
