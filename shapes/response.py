"""Shapes of how real features are measured and read out, and of parameters that are not the same for all events."""

from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtr

from avobench.challenge.shape import Place
from shapes.primitives import Library, either, log, run_time
from shapes.selection import SIDE, angle, cosine, cotangent, unbounded

RESPONSE = Library("continuous")

OTHER = (0.0, 1.0)
"""Range of the place among the other features of the one that acts, from the next one to the last."""


def positive(place: Place) -> bool:
    """Whether the place is of features that are never negative, such as an energy."""
    return not place.cosine and bool((place.reference[:, place.columns] >= 0).all())


def signed(place: Place) -> bool:
    """Whether at least 5 % of the values have either sign."""
    share = (place.reference[:, place.columns] > 0).mean(axis=0)
    return bool(((share > 0.05) & (share < 0.95)).all())


def moved(x: NDArray, by: NDArray, at: Place) -> NDArray[np.float64]:
    """Values moved by so many standard deviations. Of a cosine, the angle is turned by so many radians."""
    return np.cos(angle(x) - by) if at.cosine else x + by * at.spread


def zero(at: Place) -> NDArray[np.float64]:
    """Where the value 0 is, (k,)."""
    return -at.centre / at.half_range


def times(x: NDArray, gain: NDArray, at: Place) -> NDArray[np.float64]:
    """Values times a gain, which leaves the value 0 as it is."""
    return zero(at) + gain * (x - zero(at))


def size(x: NDArray, at: Place) -> NDArray[np.float64]:
    """How large values are without their signs, where the largest of the range is 1."""
    return np.minimum(np.abs(x - zero(at)) / (np.abs(zero(at)) + 1), 1)


def mistaken(x: NDArray, chance: NDArray, at: Place, rng: np.random.Generator) -> NDArray[np.float64]:
    """Values that get the other sign with this chance."""
    return np.where(rng.random(x.shape) < chance, 2 * zero(at) - x, x)


def limit(at: Place, share: float, side: float) -> NDArray[np.float64]:
    """The value that a share of the events exceeds, (k,), where features are multiplied by the side."""
    return side * at.quantile(1 - share if side > 0 else share)


def clipped(x: NDArray, at: Place) -> NDArray[np.float64]:
    """Values as they are, but cosines that run over an end stop there."""
    return np.clip(x, -1, 1) if at.cosine else x


def alternate(x: NDArray, uneven: float) -> NDArray[np.float64]:
    """The middles of steps that are by turns wider and narrower than 1 by this much."""
    pair, inside = np.divmod(x, 2)
    return 2 * pair + np.where(inside < 1 + uneven, (1 + uneven) / 2, (3 + uneven) / 2)


def driver(every: NDArray, at: Place, by: SimpleNamespace) -> NDArray[np.float64]:
    """The feature that acts on each of the place, in standard deviations from its mean: (n, k)."""
    count = every.shape[1]
    ahead = 1 + min(int(by.other * (count - 1)), count - 2)
    return every[:, [(column + ahead) % count for column in at.columns]]


def signals(every: NDArray, at: Place) -> NDArray[np.float64]:
    """All features in standard deviations from zero: (n, d)."""
    return every + at.reference.mean(axis=0) / at.reference.std(axis=0)


def direction(at: Place, turn: float) -> NDArray[np.float64]:
    """The direction in which the parameter of the place varies, or all together, as a width of the prior: (p,)."""
    names = at.task.parameter_names
    if at.feature in names:
        return (np.array(names) == at.feature) * at.task.prior.width
    return (np.cos(turn - np.arange(len(names)) * np.pi / 2) if len(names) > 1 else 1) * at.task.prior.width


# Values are blurred.


@RESPONSE.map("resolution", on="any", strength=(0.03, 0.6), tail_share=(0.05, 0.3), tail_width=(1.5, 4.0))
def double_gaussian(x, at, by, rng):
    """Values, or the angles of cosines, have Gaussian errors, and those of a share of the events are wider."""
    width = np.where(rng.random(x.shape) < by.tail_share, by.tail_width, 1)
    return moved(x, by.strength * width * rng.standard_normal(x.shape), at)


@RESPONSE.map("resolution", on="any", strength=(0.03, 0.6), share=(0.3, 1.0), shape=(0.4, 1.5), side=SIDE)
def straggling(x, at, by, rng):
    """A share of the variance of the errors has a long tail to one side, as of energy loss, and their mean is 0."""
    tail = (rng.gamma(by.shape, size=x.shape) - by.shape) / np.sqrt(by.shape)
    error = np.sqrt(1 - by.share) * rng.standard_normal(x.shape) + np.sqrt(by.share) * by.side * tail
    return x + by.strength * at.spread * error


@RESPONSE.map("resolution", suits=cosine, strength=(0.03, 0.5), power=(0.3, 1.0))
def slanted_material(x, at, by, rng):
    """The angle is blurred by scattering, the more the longer the way through the material is, so near the beam.

    Highland, Nuclear Instruments and Methods 129 (1975) 497.
    """
    width = by.strength * np.maximum(np.sin(angle(x)), 0.05) ** -by.power
    return moved(x, width * rng.standard_normal(x.shape), at)


@RESPONSE.map("resolution", suits=cosine, strength=(0.1, 0.6))
def multiple_scattering(x, at, by, rng):
    """The track is scattered in space by a small random angle before it is measured."""
    scattered, around = rng.rayleigh(by.strength, x.shape), 2 * np.pi * rng.random(x.shape)
    return np.clip(x * np.cos(scattered) + np.sin(angle(x)) * np.sin(scattered) * np.cos(around), -1, 1)


@RESPONSE.blur("resolution", on="any", suits=unbounded, strength=(0.03, 0.6), growth=(0.3, 2.0))
def stochastic_term(x, at, by, rng):
    """The value is blurred by noise and, the larger it is, by fluctuations of the shower as well."""
    return by.strength * at.spread * np.sqrt(1 + by.growth * np.abs(x - zero(at)) / at.spread)


@RESPONSE.blur("resolution", on="any", strength=(0.1, 0.55), growth=either(0.8, 2.0))
def worse_on_one_side(x, at, by, rng):
    """The measurement is sharp at one end of the range and gets blurrier, faster and faster, towards the other."""
    return by.strength * at.spread * np.exp(by.growth * np.clip(x, -1.5, 1.5) - np.abs(by.growth) / 2)


@RESPONSE.map("resolution", on="any", strength=(0.2, 0.9), power=(0.5, 2.5))
def ageing_sensor(x, at, by, rng):
    """Radiation ages the sensor, so that it measures well early in the run and with large random errors in the end."""
    width = by.strength * at.spread * run_time(len(x)) ** by.power
    return x + width * rng.laplace(scale=np.sqrt(0.5), size=x.shape)


@RESPONSE.map("resolution", strength=(0.02, 1.2), quality=(1.0, 2.0))
def uneven_quality(x, at, by, rng):
    """Each value, or the angle of a cosine, has a Gaussian error whose variance differs from event to event."""
    variance = rng.gamma(by.quality, 1 / by.quality, x.shape)
    return moved(x, by.strength * np.sqrt(variance) * rng.standard_normal(x.shape), at)


@RESPONSE.map("resolution", strength=(0.03, 1.8))
def long_drift(x, at, by, rng):
    """Charge spreads as it drifts to the readout at the middle, so values far from the middle are smeared most."""
    return moved(x, by.strength * np.sqrt(np.minimum(np.abs(x), 1)) * rng.standard_normal(x.shape), at)


@RESPONSE.blur("resolution", on="any", strength=(0.07, 1.1), anode=either(0.5, 1.0))
def drift_diffusion(x, at, by, rng):
    """Charge drifts to the readout at one end and spreads, with a width that grows as the square root of the way."""
    return by.strength * at.spread * np.sqrt(np.maximum(1 - by.anode * x, 0) / (1 + np.abs(by.anode)))


@RESPONSE.map("resolution", on="any", strength=(0.05, 0.8), power=(2.5, 4.8))
def moffat_seeing(x, at, by, rng):
    """Turbulent air spreads the image of a star, which has a core and wings that fall off as a power of the distance.

    Moffat, Astronomy and Astrophysics 3 (1969) 455.
    """
    core = by.strength / np.sqrt(2 ** (1 / by.power) - 1)
    radius = core * np.sqrt(rng.uniform(0, 1, x.shape) ** (-1 / (by.power - 1)) - 1)
    return x + at.spread * radius * np.cos(rng.uniform(0, 2 * np.pi, x.shape))


@RESPONSE.map("resolution", on="any", strength=(0.12, 0.8), narrower=(0.1, 1.0))
def finite_slits(x, at, by, rng):
    """Each value is smeared by the widths of an entrance and an exit slit, together a trapezoid."""
    across = rng.uniform(-1, 1, x.shape) + by.narrower * rng.uniform(-1, 1, x.shape)
    return x + by.strength * at.spread * across * np.sqrt(3 / (1 + by.narrower**2))


@RESPONSE.map("resolution", on="any", strength=(0.15, 1.0), unsteady=(0.0, 0.3))
def mirror_vibration(x, at, by, rng):
    """The instrument swings at a resonance of its mount, and each value is displaced by the swing at that moment."""
    amplitude = by.strength * at.spread * (1 + by.unsteady * rng.uniform(-1, 1, x.shape))
    return x + amplitude * np.sin(rng.uniform(0, 2 * np.pi, x.shape))


@RESPONSE.blur("resolution", strength=(0.1, 1.2), points=(1.0, 6.0))
def hits_on_track(x, at, by, rng):
    """Each value is fitted to the points that happened to be recorded, and is precise if they are many."""
    return by.strength * at.spread / np.sqrt(1 + rng.poisson(by.points, x.shape))


# Values are displaced.


@RESPONSE.map("offset", on="any", strength=either(0.003, 0.4, log=True), drift=(0.0, 0.5))
def drifting_offset(x, at, by, rng):
    """The zero of the scale, or of the angle of a cosine, is shifted by an amount that drifts over the run."""
    return moved(x, by.strength * (1 + by.drift * rng.uniform(-1, 1, (len(x), 1))), at)


@RESPONSE.map("offset", suits=cosine, strength=either(0.005, 0.25, log=True), bunch=(0.0, 0.5))
def displaced_vertex(x, at, by, rng):
    """Collisions take place off the centre of the barrel, along the beam, and angles are measured from its centre."""
    along = cotangent(x) + by.strength * (1 + by.bunch * rng.standard_normal(x.shape))
    return along / np.hypot(1, along)


@RESPONSE.map("offset", on="any", strength=either(0.005, 1.2, log=True), since=(0.5, 1.0))
def stale_survey(x, at, by, rng):
    """A detector was moved during the run, and all values that were measured since are shifted by the same amount."""
    return x + by.strength * at.spread * (run_time(len(x)) > 1 - by.since)


@RESPONSE.map("offset", on="any", strength=either(0.01, 0.25, log=True), knock=(0.1, 0.5), mended=(0.6, 0.9))
def knocked_survey(x, at, by, rng):
    """In the middle of the run somebody knocks against the frame, and the displacement is later half mended."""
    time = run_time(len(x))
    return x + by.strength * at.spread * np.where(time < by.knock, 0, np.where(time < by.mended, 1, 0.5))


@RESPONSE.map("offset", on="any", strength=either(0.007, 1.0, log=True), warming=log(0.02, 0.5))
def warm_up(x, at, by, rng):
    """The zero drifts away while the electronics warm up, and then stays where it has come to."""
    return x - by.strength * at.spread * np.expm1(-run_time(len(x)) / by.warming)


# Values are stretched.


@RESPONSE.map("scale", suits=cosine, strength=either(0.003, 0.1, log=True), drift=(0.0, 0.3))
def angular_scale(x, at, by, rng):
    """Angles to the transverse plane are measured too wide or too narrow, by a factor that drifts over the run."""
    return np.sin((1 + by.strength * (1 + by.drift * rng.uniform(-1, 1, x.shape))) * np.arcsin(x))


@RESPONSE.map(
    "scale", on="any", suits=unbounded, strength=either(0.005, 0.2, log=True), bend=(-0.3, 0.3), drift=(0.0, 0.3)
)
def bent_gain(x, at, by, rng):
    """The gain is wrong, a little more or less so for large signals, and drifts over the run."""
    bend = by.bend * np.tanh(np.abs(x - zero(at)) / at.spread)
    return times(x, 1 + by.strength * (1 + bend + by.drift * rng.uniform(-1, 1, (len(x), 1))), at)


@RESPONSE.map("scale", on="any", suits=unbounded, strength=either(0.005, 0.2, log=True), slope=(-0.3, 0.3))
def logarithmic_gain(x, at, by, rng):
    """The gain is wrong, by an amount that goes with the logarithm of the signal."""
    order = np.log(np.clip(np.abs(x - zero(at)) / at.spread, 0.1, 10))
    return times(x, 1 + by.strength * (1 + by.slope * order), at)


@RESPONSE.map("scale", on="any", strength=either(0.005, 0.35, log=True), other=(0.3, 1.0), side=SIDE)
def stretched_barrel(x, at, by, rng):
    """Lengths from zero, or cotangents of angles, are measured in a wrong unit, unlike for the two signs."""
    gain = 1 + by.strength * np.where(by.side * (x - zero(at)) > 0, 1, by.other)
    if not at.cosine:
        return times(x, gain, at)
    return gain * cotangent(x) / np.hypot(1, gain * cotangent(x))


@RESPONSE.map("scale", on="any", strength=either(0.004, 0.5, log=True), other=(0.0, 0.7), side=SIDE)
def two_slopes(x, at, by, rng):
    """Two amplifiers share the range, one on each side of the middle, and one has a gain that is more wrong."""
    return x * (1 + by.strength * np.where(by.side * x > 0, 1, by.other))


@RESPONSE.map("scale", on="any", strength=either(0.004, 0.15, log=True), days=(1.5, 8.0))
def gain_by_temperature(x, at, by, rng):
    """The gain follows the temperature of the hall and swings between right and wrong with day and night."""
    return x * (1 + by.strength * np.sin(np.pi * by.days * run_time(len(x))) ** 2)


@RESPONSE.map("scale", on="any", strength=either(0.01, 0.5, log=True))
def lens_distortion(x, at, by, rng):
    """A lens magnifies the middle of its field more, or less, than the edges, where its scale was set."""
    return x * (1 + by.strength * np.maximum(1 - x**2, 0))


@RESPONSE.map("scale", strength=(0.02, 1.5), empty=SIDE)
def birks_quenching(x, at, by, rng):
    """A scintillator gives less light for denser deposits and was calibrated at both ends, so others are too large.

    Birks, Proc. Phys. Soc. A 64 (1951) 874.
    """
    deposit = (1 + by.empty * x) / 2
    light = deposit * (1 + by.strength) / (1 + by.strength * np.maximum(deposit, 0))
    return by.empty * (2 * np.where(deposit > 0, light, deposit) - 1)


@RESPONSE.map("scale", strength=either(0.02, 0.6, log=True), switch=(-0.7, 0.3))
def gain_range_switch(x, at, by, rng):
    """Above a certain value the amplifier switches to its low gain, whose factor is wrong."""
    return x + by.strength * np.maximum(x - by.switch, 0)


@RESPONSE.map("scale", strength=either(0.006, 0.25, log=True), weather=(0.05, 0.3))
def weather_gain(x, at, by, rng):
    """The gain in gas depends exponentially on the air pressure, and the calibration was made in other weather."""
    pressure = 1 + by.weather * np.clip(rng.standard_normal(x.shape), -3, 3)
    return times(x, np.exp(by.strength * pressure), at)


@RESPONSE.map("scale", strength=(0.02, 0.7))
def ageing(x, at, by, rng):
    """The gain of the sensor decays exponentially over the run, so that late values shrink towards the middle."""
    return x * np.exp(-by.strength * run_time(len(x)))


@RESPONSE.map("scale", strength=either(0.008, 0.35, log=True), width=(0.7, 2.0))
def field_map(x, at, by, rng):
    """The field that sets the scale is wrong at the middle of the magnet and nearly right far from it."""
    return x * (1 + by.strength / (1 + (x / by.width) ** 2))


# Signs are mistaken.


@RESPONSE.map("charge_misid", on="any", strength=(0.005, 0.6), floor=(0.0, 0.5), power=log(0.5, 9))
def stiff_tracks(x, at, by, rng):
    """The sign is told from a curvature that is small for large values, so theirs is mistaken most often."""
    return mistaken(x, by.strength * (by.floor + (1 - by.floor) * size(x, at) ** by.power), at, rng)


@RESPONSE.map("charge_misid", suits=unbounded, strength=(0.01, 0.4), middle=(-0.25, 0.25))
def mirrored_tracks(x, at, by, rng):
    """The side of the middle on which a value lies is mistaken, and more often so the farther it is from there."""
    wrong = rng.random(x.shape) < np.minimum(by.strength * (0.3 + 0.7 * (x - by.middle) ** 2), 0.5)
    return np.where(wrong, 2 * by.middle - x, x)


@RESPONSE.map("charge_misid", suits=signed, strength=(0.28, 3.0))
def sagitta_error(x, at, by, rng):
    """The sign is that of the inverse of the value, which has a Gaussian error, so large values are often mistaken."""
    typical = np.hypot(at.mean, at.std) / at.half_range
    curvature = typical / np.maximum(np.abs(x - zero(at)), 1e-9 * typical)
    return mistaken(x, ndtr(-curvature / by.strength), at, rng)


@RESPONSE.map("charge_misid", on="any", strength=(0.005, 0.2), preference=either(0.2, 0.8))
def lopsided_flips(x, at, by, rng):
    """The sign is mistaken, more often for one charge than for the other."""
    return mistaken(x, by.strength * (1 + by.preference * np.sign(x - zero(at))), at, rng)


@RESPONSE.map("charge_misid", suits=cosine, strength=(0.03, 0.4), side=SIDE, slope=(-0.8, 0.8))
def sagitta_bias(x, at, by, rng):
    """A twist of the tracker bends all tracks one way, so that some of one charge are taken for the other."""
    chance = by.strength * (1 + by.slope * (2 * np.abs(x) - 1)) / (1 + np.abs(by.slope))
    return mistaken(x, np.where(by.side * x > 0, chance, 0), at, rng)


@RESPONSE.map("charge_misid", suits=cosine, strength=(0.005, 0.12))
def material_confusion(x, at, by, rng):
    """Scattering hides which way a track bends, mostly close to the beam, where tracks are short."""
    return mistaken(x, np.minimum(by.strength / np.maximum(1 - x**2, 1e-3), 0.5), at, rng)


@RESPONSE.map("charge_misid", suits=signed, strength=(0.01, 0.5), hardness=(0.3, 1.5), loss=(0.0, 0.4))
def brem_conversion(x, at, by, rng):
    """Electrons radiate a photon that turns into a pair, so that the charge is mistaken and some momentum is lost."""
    wrong = rng.random(x.shape) < by.strength * size(x, at) ** by.hardness
    return np.where(wrong, times(x, -(1 - by.loss * rng.random(x.shape)), at), x)


@RESPONSE.map("charge_misid", suits=signed, strength=(0.03, 1.0), inner=(0.1, 0.6), width=(0.2, 0.4))
def swapped_cables(x, at, by, rng):
    """In one ring the cables of the two sides are swapped on some modules, where values get the wrong sign."""
    ring = (size(x, at) > by.inner) & (size(x, at) < by.inner + by.width)
    return mistaken(x, by.strength * ring, at, rng)


@RESPONSE.map("charge_misid", suits=signed, strength=either(0.006, 0.5, log=True))
def lost_sign_bit(x, at, by, rng):
    """The sign bit is sometimes lost, so that values of one sign are read with the other, and never the reverse."""
    return mistaken(x, np.abs(by.strength) * (by.strength * (x - zero(at)) < 0), at, rng)


# Channels leak into one another.


@RESPONSE.respond("crosstalk", strength=either(0.01, 0.4, log=True), knee=(-1.5, 0.0), other=OTHER)
def rectified_crosstalk(x, every, at, by, rng):
    """A large signal in another channel leaks into this one, and one below a soft knee does not."""
    return x + by.strength * at.spread * np.logaddexp(0, 4 * (driver(every, at, by) - by.knee)) / 4


@RESPONSE.respond("crosstalk", on="any", strength=either(0.015, 0.8, log=True), level=(-0.5, 1.0), other=OTHER)
def leaky_diode(x, every, at, by, rng):
    """A diode between two channels opens when one of them is high, and what exceeds its level leaks into the other."""
    return x + by.strength * at.spread * np.maximum(driver(every, at, by) - by.level, 0)


@RESPONSE.respond("crosstalk", strength=either(0.01, 0.6, log=True), other_side=(0.2, 1.0))
def two_neighbours(x, every, at, by, rng):
    """The signals of the two neighbouring channels leak into this one, perhaps from one side more than the other."""
    signal, column = signals(every, at), at.columns[0]
    leak = signal[:, column - 1] + by.other_side * signal[:, (column + 1) % signal.shape[1]]
    return x + by.strength * at.spread * leak[:, None]


@RESPONSE.respond("crosstalk", strength=either(0.012, 0.3, log=True), decrease=(0.1, 0.7))
def anode_coupling(x, every, at, by, rng):
    """A part of every other channel's signal is added to this one, less with every step of distance."""
    steps = np.abs(np.arange(every.shape[1]) - at.columns)
    weights = np.where(steps > 0, by.decrease ** (steps - 1.0), 0)
    return x + by.strength * at.spread * (signals(every, at) @ weights)[:, None]


@RESPONSE.map("crosstalk", on="all", strength=either(0.02, 0.25, log=True), onset=(0.0, 0.6))
def loose_ground(x, at, by, rng):
    """A ground contact loosens in the run, and a growing part of each feature appears in both its neighbours."""
    grown = np.clip((run_time(len(x)) - by.onset) / (1 - by.onset), 0, 1)
    beside = np.pad(x / at.spread, ((0, 0), (1, 1)))
    return x + by.strength * at.spread * grown * (beside[:, :-2] + beside[:, 2:])


@RESPONSE.respond("crosstalk", strength=(0.05, 0.8), other=OTHER)
def shared_charge(x, every, at, by, rng):
    """Part of another channel's charge is collected by this one, more of it the closer to the border it was made."""
    return x + by.strength * np.sqrt(rng.random(x.shape)) * at.spread * driver(every, at, by)


@RESPONSE.respond("crosstalk", strength=(0.01, 0.6), other=OTHER)
def light_leak(x, every, at, by, rng):
    """Light of another cell comes through its wrapping, by a share that depends on where in the cell it was made."""
    share = by.strength * rng.gamma(3, 1 / 3, x.shape)
    return x + share * at.spread * driver(signals(every, at), at, by)


@RESPONSE.respond("crosstalk", on="any", strength=(0.01, 0.4), jitter=(0.0, 0.4), other=OTHER)
def multiplexer_memory(x, every, at, by, rng):
    """One converter reads the channels in turn, and a share of what it read from one channel is left in another."""
    left = np.minimum(by.strength * np.exp(by.jitter * rng.uniform(-1, 1, x.shape)), 1)
    return times(x, 1 - left, at) + left * at.spread * driver(every, at, by)


@RESPONSE.map("crosstalk", on="all", strength=either(0.01, 0.3, log=True))
def held_charge(x, at, by, rng):
    """A converter is not fully emptied, so each channel gets a part of the one before, with what that one got."""
    column = np.arange(x.shape[1])
    steps = column - column[:, None]
    return at.spread * (x / at.spread @ np.where(steps < 0, 0, by.strength ** np.maximum(steps, 0)))


@RESPONSE.map("crosstalk", on="all", strength=(0.015, 0.4))
def strongest_spills(x, at, by, rng):
    """In every event the channel with the strongest signal spills a share of it into the channels beside it."""
    signal = x / at.spread
    strongest = np.abs(signal).argmax(axis=1)[:, None]
    beside = np.abs(np.arange(x.shape[1]) - strongest) == 1
    return x + by.strength * at.spread * beside * np.take_along_axis(signal, strongest, axis=1)


# Values are read in steps.


@RESPONSE.map("quantisation", stage=4, on="any", suits=unbounded, strength=(0.05, 1.0), noise=(0.0, 0.1))
def truncating_readout(x, at, by, rng):
    """Values are cut down to the steps of a converter, with a little noise of its own."""
    step = by.strength * at.spread
    return zero(at) + step * (np.floor((x - zero(at)) / step) + 0.5 + by.noise * rng.standard_normal(x.shape))


@RESPONSE.map("quantisation", stage=4, suits=cosine, strength=(0.01, 0.4), uneven=(0.0, 0.3))
def segments(x, at, by, rng):
    """The angle is that of the middle of the segment that was hit, and segments are by turns wide and narrow."""
    return np.cos(by.strength * alternate(angle(x) / by.strength, by.uneven))


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.003, 0.06), step=(0.08, 0.25), uneven=(0.1, 0.6))
def uneven_spell(x, at, by, rng):
    """At the end of the run values come in codes that are wide and narrow by turns, recorded at their middles."""
    return np.where(run_time(len(x)) > 1 - by.strength, by.step * alternate(x / by.step, by.uneven), x)


@RESPONSE.map("quantisation", stage=4, strength=(0.02, 1.5), imbalance=(0.0, 0.8))
def uneven_codes(x, at, by, rng):
    """A converter has wide and narrow steps in turn but evenly spaced codes, so every other code is too frequent."""
    step = by.strength * at.spread
    pair, inside = np.divmod(x / step, 2)
    return clipped((2 * pair + (inside > 1 + by.imbalance) + 0.5) * step, at)


@RESPONSE.map("quantisation", stage=4, suits=cosine, strength=(0.05, 0.6), border=(0.0, 1.0))
def eta_towers(x, at, by, rng):
    """The angle is that of the middle of the tower that was hit, and towers are equally wide in pseudorapidity."""
    tower = np.floor(np.arctanh(np.clip(x, -1 + 1e-12, 1 - 1e-12)) / by.strength + by.border)
    return np.tanh(by.strength * (tower + 0.5 - by.border))


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.003, 0.8), core=log(0.08, 1.0))
def companding(x, at, by, rng):
    """Values are stored in steps that are equal near the middle and grow in proportion to the distance beyond it."""
    return clipped(by.core * np.sinh(by.strength * np.rint(np.arcsinh(x / by.core) / by.strength)), at)


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.01, 0.8), core=log(0.01, 1.0))
def short_mantissa(x, at, by, rng):
    """Values are stored by the logarithm of their size in few bits, so that steps grow in proportion to the value."""
    core = by.core * at.spread
    code = np.rint(np.arcsinh((x - zero(at)) / core) / by.strength)
    return clipped(zero(at) + core * np.sinh(by.strength * code), at)


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.005, 0.9), step=log(0.1, 0.9))
def dial_reading(x, at, by, rng):
    """A share of the readings of a dial is given as the nearest round number, and the others are kept as they are."""
    step = by.step * at.spread
    mark = clipped(zero(at) + step * np.rint((x - zero(at)) / step), at)
    return np.where(rng.random(x.shape) < by.strength, mark, x)


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.008, 0.2), mark=(0.15, 0.4), pull=(0.1, 0.35))
def round_numbers(x, at, by, rng):
    """Values read off a scale stick to its long marks when they are near to one, and others are kept as they are."""
    nearest = by.mark * np.rint(x / by.mark)
    near = np.abs(x - nearest) < by.pull * by.mark
    return np.where(near & (rng.random(x.shape) < by.strength), nearest, x)


@RESPONSE.map("quantisation", stage=4, suits=unbounded, strength=(0.01, 0.9))
def round_values(x, at, by, rng):
    """Some values that are close to a round decimal number are written down as that number."""
    about = np.log10(0.7 * at.std)
    step = 10 ** np.floor(about) * np.select([about % 1 < 0.3, about % 1 < 0.7], [1, 2], 5) / at.half_range
    nearest = zero(at) + step * np.rint((x - zero(at)) / step)
    return np.where(rng.random(x.shape) < by.strength * (1 - 2 * np.abs(x - nearest) / step), nearest, x)


@RESPONSE.map("quantisation", stage=4, suits=cosine, strength=(0.005, 0.5))
def protractor(x, at, by, rng):
    """Some angles were read by eye from a protractor and written down at the nearest of its marks every ten degrees."""
    mark = np.cos(np.radians(10 * np.rint(np.degrees(angle(x)) / 10)))
    return np.where(rng.random(x.shape) < by.strength, mark, x)


@RESPONSE.map("quantisation", stage=4, strength=(0.03, 2.0), sharing=(0.05, 0.85))
def wire_pitch(x, at, by, rng):
    """A position is that of the wire that fired, or halfway between two wires if a particle between them fires both."""
    pitch = by.strength * at.spread
    midway = np.floor(x / pitch) + 0.5
    both = np.abs(x / pitch - midway) < by.sharing / 2
    return clipped(pitch * np.where(both, midway, np.rint(x / pitch)), at)


@RESPONSE.map("quantisation", stage=4, on="any", strength=(0.05, 1.0), cell=log(0.15, 0.5))
def cell_centres(x, at, by, rng):
    """Positions by the centre of gravity of neighbouring cells are drawn towards the centres of the cells."""
    wave = 2 * np.pi / (by.cell * at.spread)
    return x - by.strength / wave * np.sin(wave * x)


# The scale ends.


@RESPONSE.map("saturation", on="any", strength=(0.005, 0.45), room=log(0.02, 0.4), side=SIDE)
def soft_saturation(x, at, by, rng):
    """Beyond a knee, which a share of the events exceeds, the response bends over towards a limit it never reaches."""
    over = np.maximum(by.side * x - limit(at, by.strength, by.side), 0)
    return x - by.side * (over + by.room * np.expm1(-over / by.room))


@RESPONSE.map("saturation", strength=(0.03, 30.0), level=(0.0, 0.9), side=SIDE)
def soft_limit(x, at, by, rng):
    """Above a certain level the output of an amplifier grows only as the logarithm of its input."""
    over = np.maximum(by.side * x - by.level, 0)
    return x - by.side * (over - np.log1p(by.strength * over) / by.strength)


@RESPONSE.map("saturation", strength=(0.007, 0.8), limit=(0.1, 0.5), side=SIDE)
def quenched_top(x, at, by, rng):
    """Above a limit the light of dense deposits is quenched, and what goes beyond grows ever more slowly.

    Birks, Proc. Phys. Soc. A 64 (1951) 874.
    """
    over = np.maximum(by.side * x - by.limit, 0)
    return x - by.side * (over - over / (1 + by.strength * over))


@RESPONSE.map("saturation", strength=(0.03, 1.2))
def soft_knee_and_rail(x, at, by, rng):
    """Above a knee the amplifier answers with half its gain, until it stands at the rail."""
    over = np.maximum(x - 1 + by.strength, 0)
    return x - over + np.minimum(over / 2, 0.3 * by.strength)


@RESPONSE.map("saturation", suits=cosine, strength=(0.8, 1.5), hardness=(6.0, 14.0))
def soft_wire_ends(x, at, by, rng):
    """Positions from how charge divides between the two ends of a wire are pressed together short of the ends."""
    return x * (1 + np.abs(by.strength * x) ** by.hardness) ** (-1 / by.hardness)


@RESPONSE.map("saturation", stage=4, strength=(0.004, 0.3), ratio=(0.2, 0.9), side=SIDE)
def two_converters(x, at, by, rng):
    """Two converters take turns, and what is beyond the end of the scale of the one at work is recorded as that end."""
    near, far = limit(at, by.strength, by.side), limit(at, by.ratio * by.strength, by.side)
    return by.side * np.minimum(by.side * x, np.where(rng.random(x.shape) < 0.5, near, far))


@RESPONSE.map("saturation", on="any", strength=(0.002, 0.3), ripple=(0.0, 0.4), side=SIDE)
def unsteady_rail(x, at, by, rng):
    """No value exceeds what the amplifier can give, and that goes up and down with its supply."""
    rail = limit(at, by.strength, by.side) + by.ripple * at.spread * rng.standard_normal(x.shape)
    return by.side * np.minimum(by.side * x, rail)


@RESPONSE.map("saturation", strength=(0.002, 0.03), loose=(0.002, 0.03), tired=(1.5, 3.0), side=SIDE)
def tired_amplifier(x, at, by, rng):
    """The amplifier clips at a ceiling that differs a little from event to event and sinks after a large one."""
    fresh, tired = limit(at, by.strength, by.side), limit(at, by.tired * by.strength, by.side)
    ceiling = np.where(np.roll(by.side * x, 1, axis=0) > 0, tired, fresh)
    return by.side * np.minimum(by.side * x, ceiling + by.loose * np.abs(rng.standard_normal(x.shape)))


@RESPONSE.map("saturation", suits=unbounded, strength=(0.006, 0.3), ripple=log(0.005, 0.06))
def supply_rails(x, at, by, rng):
    """Values beyond either supply voltage are recorded as that voltage, which has a small ripple from the mains."""
    ripple = by.ripple * at.spread * np.sin(2 * np.pi * rng.random(x.shape))
    return np.clip(x, at.quantile(by.strength / 2) + ripple, at.quantile(1 - by.strength / 2) - ripple)


@RESPONSE.map("saturation", strength=(0.04, 0.8))
def sagging_rails(x, at, by, rng):
    """Values beyond either limit are recorded as the limit, which comes in steadily as the battery runs down."""
    rail = 1 - by.strength * run_time(len(x))
    return np.clip(x, -rail, rail)


@RESPONSE.map("saturation", stage=4, strength=(0.01, 0.4), bounce=log(0.002, 0.03))
def needle_at_stop(x, at, by, rng):
    """The needle runs against a stop at each end of its scale, where it rests or bounces back a little."""
    low, high = at.quantile(by.strength / 2), at.quantile(1 - by.strength / 2)
    back = np.minimum(by.bounce * rng.standard_exponential(x.shape), 0.2)
    return np.where(x < low, low + back, np.where(x > high, high - back, x))


@RESPONSE.map("saturation", stage=4, suits=cosine, strength=(0.05, 0.7), side=SIDE)
def encoder_stop(x, at, by, rng):
    """The angle is read by an arm that runs against a stop, and every track beyond is recorded at the stop."""
    return by.side * np.minimum(by.side * x, np.cos(by.strength))


# Energy is radiated.


@RESPONSE.map("radiative_tail", suits=positive, strength=(0.005, 0.25))
def bremsstrahlung(x, at, by, rng):
    """The electron radiates photons in the material, which carry away mostly next to nothing and sometimes much.

    Bethe and Heitler, Proc. R. Soc. A 146 (1934) 83.
    """
    return times(x, np.exp(-rng.gamma(by.strength / np.log(2), size=x.shape)), at)


@RESPONSE.map("radiative_tail", suits=positive, strength=(0.01, 0.5), softest=(0.02, 0.1))
def initial_state(x, at, by, rng):
    """In some events an unseen photon takes a share of the energy whose logarithm is evenly spread."""
    return times(x, 1 - by.softest ** rng.random(x.shape) * (rng.random(x.shape) < by.strength), at)


# One feature depends on another.


@RESPONSE.respond("conditional_response", on="any", strength=either(0.04, 0.4, log=True), blur=(0.0, 1.0), other=OTHER)
def dependent_zero(x, every, at, by, rng):
    """The zero point of a feature bends as a smooth function of another one, and its blur grows along the same way."""
    along = driver(every, at, by)
    blur = by.blur * (1 + np.tanh(0.8 * along)) / 2 * rng.standard_normal(x.shape)
    return x + by.strength * at.spread * (np.sin(0.85 * along) + blur)


@RESPONSE.respond("conditional_response", strength=(0.05, 0.7), other=OTHER)
def sagging_supply(x, every, at, by, rng):
    """The more another channel draws from the common supply the lower is the gain of this one, down to a limit."""
    return x * (1 - by.strength * expit(2 * driver(every, at, by)))


@RESPONSE.respond("conditional_response", on="any", strength=(0.02, 0.6), edge=(-0.5, 1.0), other=OTHER)
def leakage_behind_edge(x, every, at, by, rng):
    """Where another feature, the position, is beyond an edge, part of the energy leaks out through the side."""
    return (x + 1) * (1 - by.strength * expit((driver(every, at, by) - by.edge) / 0.2)) - 1


@RESPONSE.respond("conditional_response", strength=either(0.004, 0.6, log=True), other=OTHER)
def bent_field(x, every, at, by, rng):
    """A feature is displaced by an amount that grows as the square of another one, up to a limit."""
    return x + by.strength * at.spread * np.minimum(driver(every, at, by) ** 2, 6)


@RESPONSE.respond("conditional_response", strength=either(0.02, 0.35, log=True), other=OTHER)
def gas_gain(x, every, at, by, rng):
    """The gain grows exponentially with another feature, such as a temperature, so that deviations are stretched."""
    mean = (at.mean - at.centre) / at.half_range
    return mean + (x - mean) * np.exp(by.strength * np.clip(driver(every, at, by), -3, 3))


@RESPONSE.respond("conditional_response", strength=either(0.015, 0.3, log=True), other=OTHER)
def hall_probe(x, every, at, by, rng):
    """The gain of a sensor is proportional to its temperature, another feature, so that deviations are stretched."""
    mean = (at.mean - at.centre) / at.half_range
    return x + (x - mean) * by.strength * np.clip(driver(every, at, by), -2.5, 2.5)


@RESPONSE.respond(
    "conditional_response", on="any", strength=either(0.02, 0.6, log=True), softness=(0.7, 2.0), other=OTHER
)
def temperature_gain(x, every, at, by, rng):
    """The gain of a crystal follows its temperature, another feature, and levels off at both ends of it."""
    return x * (1 + by.strength * np.tanh(driver(every, at, by) / by.softness))


@RESPONSE.respond("conditional_response", strength=(0.2, 1.2), onset=(-0.5, 0.8), other=OTHER)
def pump_vibration(x, every, at, by, rng):
    """Above a certain flow, another feature, a pump makes the instrument vibrate, the more the larger the flow is."""
    above = np.clip(driver(every, at, by) - by.onset, 0, 3)
    return x + by.strength * at.spread * above * rng.standard_normal(x.shape)


@RESPONSE.respond("conditional_response", strength=(0.12, 1.2), border=(-0.7, 0.7), other=OTHER)
def behind_the_rail(x, every, at, by, rng):
    """Where another feature is beyond the border of the rails, this one is smeared, and elsewhere it is exact."""
    behind = driver(every, at, by) > by.border
    return x + by.strength * at.spread * behind * rng.standard_normal(x.shape)


@RESPONSE.respond("conditional_response", on="any", strength=(0.05, 1.0), other=OTHER)
def joint_drift_diffusion(x, every, at, by, rng):
    """Charge spreads on its way to the readout, so a feature is smeared by the square root of another, the depth."""
    way = np.clip((1 + driver(every, at, by) / 2.6) / 2, 0, None)
    return x + by.strength * at.spread * np.sqrt(way) * rng.standard_normal(x.shape)


@RESPONSE.respond(
    "conditional_response", strength=either(0.02, 1.0, log=True), slope=(0.2, 0.5), power=(0.5, 1.0), other=OTHER
)
def time_walk(x, every, at, by, rng):
    """Small pulses cross a threshold late, so a feature shifts by an inverse power of another, the pulse height."""
    height = np.clip(1 + by.slope * driver(every, at, by), 0.15, 4)
    return x + by.strength * at.spread * (height**-by.power - 1)


# All features err together.


@RESPONSE.map(
    "correlation", on="all", strength=(0.09, 0.6), first=OTHER, second=OTHER, ratio=either(0.6, 1.4), tail=(4.0, 12.0)
)
def shared_error(x, at, by, rng):
    """Two features share a source of error, such as a clock, and are moved together or against each other."""
    count = x.shape[1]
    first = min(int(by.first * count), count - 1)
    second = (first + 1 + min(int(by.second * (count - 1)), count - 2)) % count
    pattern = np.eye(count)[first] + by.ratio * np.eye(count)[second]
    return x + by.strength * at.spread * pattern * rng.standard_t(by.tail, (len(x), 1)) * np.sqrt(1 - 2 / by.tail)


@RESPONSE.map("correlation", on="all", strength=(0.05, 1.2), lag=(0.0, 0.35))
def mains_hum(x, at, by, rng):
    """All channels pick up the hum of the mains at a random phase, each a little later than the one before."""
    phase = rng.uniform(0, 2 * np.pi, (len(x), 1)) - by.lag * np.arange(x.shape[1])
    return x + by.strength * at.spread * np.sin(phase)


@RESPONSE.map("correlation", on="all", strength=(0.05, 0.4))
def common_gain(x, at, by, rng):
    """All channels share one supply that fluctuates, so that in each event all gains are too high or too low."""
    return x * (1 + by.strength * np.clip(rng.standard_normal((len(x), 1)), -2.4, 2.4))


@RESPONSE.map("correlation", on="all", strength=(0.07, 1.2))
def common_mode(x, at, by, rng):
    """Channels share the noise of one ground, and each was then calibrated to have the width it should have."""
    mean = (at.mean - at.centre) / at.half_range
    noise = by.strength * at.spread * rng.standard_normal((len(x), 1))
    return mean + (x - mean + noise) / np.hypot(1, by.strength)


@RESPONSE.map("correlation", on="all", strength=(0.05, 0.6), single=(0.0, 0.3))
def common_ground(x, at, by, rng):
    """The voltage of the common ground wanders at random, and each channel has a little noise of its own besides."""
    noise = rng.standard_normal((len(x), 1)) + by.single * rng.standard_normal(x.shape)
    return x + by.strength * at.spread * noise


@RESPONSE.map("correlation", on="all", strength=(0.07, 1.0), busy=(0.3, 1.0))
def ground_bounce(x, at, by, rng):
    """When many outputs switch at once the ground jumps, and all channels of such an event move together."""
    jump = rng.laplace(0, by.strength, (len(x), 1)) * (rng.random((len(x), 1)) < by.busy)
    return x + at.spread * jump


@RESPONSE.map("correlation", on="all", strength=(0.08, 0.6), pivot=(-1.0, 1.0))
def tilting_table(x, at, by, rng):
    """The table that carries all sensors tilts about a pivot, so those on its two sides err in opposite directions."""
    lever = np.linspace(-1, 1, x.shape[1]) - by.pivot
    return x + by.strength * at.spread * lever / np.sqrt((lever**2).mean()) * rng.standard_normal((len(x), 1))


@RESPONSE.map("correlation", on="all", strength=(0.05, 0.8), start=(0.7, 2.0))
def traverse(x, at, by, rng):
    """Every quantity is measured from the one before it, so that an error at one is carried on to all that follow."""
    legs = rng.standard_normal(x.shape) * np.where(np.arange(x.shape[1]) > 0, 1, by.start)
    return x + by.strength * at.spread * legs.cumsum(axis=1) / np.sqrt(x.shape[1])


# Parameters are not the same for all events.


@RESPONSE.spread("spread", on="whole", strength=(0.1, 0.45), turn=either(0.2, 1.4))
def unsteady_beam(theta, at, by, rng):
    """A parameter of the process jitters about its value from event to event, mostly little."""
    return theta + by.strength * direction(at, by.turn) * rng.laplace(scale=np.sqrt(0.5), size=(len(theta), 1))


@RESPONSE.spread("mixture", on="whole", strength=(0.02, 0.4), turn=either(0.2, 2.9), apart=(0.4, 0.9))
def second_population(theta, at, by, rng):
    """The first part of the run was taken at another setting, so that its events have other parameters."""
    return theta + by.apart * direction(at, by.turn) * (run_time(len(theta)) < by.strength)
