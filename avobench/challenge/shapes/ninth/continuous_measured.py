"""Shapes in which the values of a real feature are measured wrongly."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, drawn, strength
from avobench.challenge.shapes.places import Single, clipped, reflected


class Signed(Single):
    """What happens to one real feature that takes both signs."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and bool(0.02 < (place.reference[:, place.columns] < 0).mean() < 0.98)


@dataclass(frozen=True)
class HitsOnTrack(Single, Change):
    """Each value is fitted to the few points that happened to be recorded. With many points it is precise, with only
    one or two it is poor."""

    name = "resolution"
    source = "wire chambers with few layers"
    strength: float = strength(0.1, 1.2, "std")
    """The error of a fit to a single point."""
    points: float = drawn(1, 6)
    """Mean number of points beside the first."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        points = 1 + rng.poisson(self.points, x.shape)
        error = self.strength * self.place.std / np.sqrt(points)
        return reflected(self.place, x + error * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class DriftDiffusion(Single, Change):
    """The signal drifts to the readout at one end of the range and spreads on its way. What starts far from the readout
    is measured less sharply, by the root of the way."""

    name = "resolution"
    source = "time projection chambers"
    strength: float = strength(0.06, 0.8, "std", sign=True)
    """The error after half of the range; the sign tells at which end the readout is."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        way = np.maximum(1 - np.sign(self.strength) * (x - self.place.centre) / self.place.half_range, 0)
        error = abs(self.strength) * self.place.std * np.sqrt(way)
        return reflected(self.place, x + error * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class EncoderZero(Single, Change):
    """The encoder was mounted a little away from its zero mark, so all readings are shifted by the same amount. Where
    the feature is a cosine it is the angle itself that is shifted."""

    name = "offset"
    source = "goniometers and linear encoders"
    strength: float = strength(0.01, 0.4, "std", sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        shift = self.strength * self.place.std
        if self.place.cosine:
            return np.cos(np.arccos(np.clip(x, -1, 1)) - shift)
        return x + shift


@dataclass(frozen=True)
class WarmUp(Single, Change):
    """The zero was set while the instrument was cold and moves away from there as it warms up. It settles
    exponentially, so that all but the first events of a run carry nearly the full shift."""

    name = "offset"
    source = "bridge amplifiers and balances"
    strength: float = strength(0.015, 0.5, "std", sign=True)
    """The shift of the warm instrument."""
    warming: float = drawn(0.05, 0.35, "run")
    """Time constant of the warming."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        time = rng.random(x.shape)
        return reflected(self.place, x - self.strength * self.place.std * np.expm1(-time / self.warming))


@dataclass(frozen=True)
class Ageing(Single, Change):
    """The gain of the sensor decays exponentially over the campaign while the calibration of its first day is used.
    Values shrink towards the rest point, the late ones most."""

    name = "scale"
    source = "photomultipliers and irradiated crystals"
    strength: float = strength(0.02, 0.7)
    """The decay over the whole campaign, in units of its exponent."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        gain = np.exp(-self.strength * rng.random(x.shape))
        return self.place.centre + gain * (x - self.place.centre)


@dataclass(frozen=True)
class FieldMap(Single, Change):
    """The field that sets the scale is wrong at the middle of the magnet and nearly right far from it. Values are
    stretched or shrunk there, less and less towards the ends."""

    name = "scale"
    source = "spectrometers with a short solenoid"
    strength: float = strength(0.008, 0.35, sign=True)
    width: float = drawn(0.7, 2.0, "half range")
    """How far from the middle the error of the field has fallen to a half."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        u = (x - self.place.centre) / self.place.half_range
        error = self.strength / (1 + (u / self.width) ** 2)
        return reflected(self.place, self.place.centre + self.place.half_range * u * (1 + error))


@dataclass(frozen=True)
class StiffTracks(Signed, Change):
    """The sign is read from a bend that becomes hard to see as the value grows. So the large values are the ones whose
    sign is mistaken most often, up to a blind guess."""

    name = "charge_misid"
    source = "tracks in magnetic fields"
    strength: float = strength(0.01, 0.5)
    """How often the sign is mistaken at the end of the range."""
    power: float = drawn(0.5, 2.5)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        size = np.abs(x) / (np.abs(self.place.centre) + self.place.half_range)
        return np.where(rng.random(x.shape) < np.minimum(self.strength * size**self.power, 0.5), -x, x)


@dataclass(frozen=True)
class LostSignBit(Signed, Change):
    """On the way to the disk the sign bit of some readings is lost, or sticks. Values of one sign then appear with the
    other, and never the other way round."""

    name = "charge_misid"
    source = "serial links of data loggers"
    strength: float = strength(0.006, 0.35, sign=True)
    """The share lost; its sign is that with which they appear."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        turned = (x * self.strength < 0) & (rng.random(x.shape) < abs(self.strength))
        return np.where(turned, -x, x)


@dataclass(frozen=True)
class DialReading(Single, Change):
    """A part of the readings is taken by eye and written down as the nearest mark of the dial. The others are kept as
    they are, so that the values gather at the marks."""

    name = "quantisation"
    source = "blood pressure and gauges read by eye"
    strength: float = strength(0.01, 0.9)
    """The share of the readings that is rounded."""
    step: float = drawn(0.06, 0.35, "half range", log=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.step * self.place.half_range
        marks = clipped(self.place, np.round(x / step) * step)
        return np.where(rng.random(x.shape) < self.strength, marks, x)


@dataclass(frozen=True)
class Companding(Single, Change):
    """To save bits the value is stored by its logarithm, in equal steps of that. Steps are fine around the middle and
    become coarser in proportion to the distance from it."""

    name = "quantisation"
    source = "telemetry with logarithmic codes"
    strength: float = strength(0.015, 0.6)
    """The step, relative to the distance from the middle."""
    core: float = drawn(0.08, 0.4, "half range", log=True)
    """Within it the steps are equal."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        core = self.core * self.place.half_range
        code = np.round(np.arcsinh((x - self.place.centre) / core) / self.strength)
        return clipped(self.place, self.place.centre + core * np.sinh(self.strength * code))


@dataclass(frozen=True)
class SpaceCharge(Single, Change):
    """Above a knee the response bends over and comes ever closer to a ceiling that it does not reach. Values at one end
    of the range are so pressed together below the ceiling."""

    name = "saturation"
    source = "silicon photomultipliers and gas amplification"
    strength: float = strength(0.05, 0.9, "half range", sign=True)
    """How far within the range the knee lies; the sign tells at which end."""
    room: float = drawn(0.1, 0.4, "half range")
    """Between the knee and the ceiling."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        side = np.sign(self.strength)
        u = side * (x - self.place.centre) / self.place.half_range
        knee = 1 - abs(self.strength)
        bent = knee - self.room * np.expm1(-np.maximum(u - knee, 0) / self.room)
        return np.where(u > knee, self.place.centre + side * self.place.half_range * bent, x)


@dataclass(frozen=True)
class SaggingRails(Single, Change):
    """The amplifier cannot go beyond its supply, and the battery that feeds it runs down. Values beyond either limit
    are recorded as the limit, which comes in steadily until the battery is changed."""

    name = "saturation"
    source = "battery operated field recorders"
    strength: float = strength(0.04, 0.8, "half range")
    """How far both limits have come in at the end."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = (1 - self.strength * rng.random(x.shape)) * self.place.half_range
        return np.clip(x, self.place.centre - limit, self.place.centre + limit)


@dataclass(frozen=True)
class Spikes(Single, Change):
    """Now and then a discharge adds a spike to the reading, always in the same direction. Most spikes are about as high
    as half the range, a few are many times as high."""

    name = "outliers"
    source = "cosmic rays on detectors of spectrographs"
    strength: float = strength(0.001, 0.06, sign=True)
    """The share of readings with a spike; the sign is that of the spikes."""
    tail: float = drawn(1.2, 3.5)
    """Exponent of the power law of their heights."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        height = np.minimum((1 - rng.random(x.shape)) ** (-1 / self.tail), 50)
        spiked = reflected(self.place, x + np.sign(self.strength) * self.place.half_range * height)
        return np.where(rng.random(x.shape) < abs(self.strength), spiked, x)


@dataclass(frozen=True)
class DecimalSlip(Single, Change):
    """A few values were typed with the decimal point one place too far to the right. They enter the table ten times too
    large."""

    name = "outliers"
    source = "case report forms of clinical trials"
    strength: float = strength(0.0007, 0.04)

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.cosine

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.where(rng.random(x.shape) < self.strength, 10 * x, x)


_ERRORS = HitsOnTrack, DriftDiffusion, EncoderZero, WarmUp, Ageing, FieldMap, StiffTracks, LostSignBit
_READINGS = DialReading, Companding, SpaceCharge, SaggingRails, Spikes, DecimalSlip
FAMILIES: tuple[type[Injection], ...] = (*_ERRORS, *_READINGS)
