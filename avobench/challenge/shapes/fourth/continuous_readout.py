"""Real features: how values are reconstructed and written down."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import drawn, strength
from avobench.challenge.shapes.fourth.continuous_response import OfCosine, OfReal
from avobench.challenge.shapes.fourth.scales import cosine_of, cotangent, unit, value


@dataclass(frozen=True)
class MaterialConfusion(OfCosine):
    """The two muons are taken for one another when scattering hides which way they bend, which is more likely the more
    material the track crosses and the shorter it is, so mostly close to the beam."""

    name = "charge_misid"
    source = "charge confusion at small angles"

    strength: float = strength(0.005, 0.12, "of events at right angles")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        wrong = np.minimum(self.strength / np.maximum(1 - x**2, 1e-3), 0.5)
        return np.where(rng.random(x.shape) < wrong, -x, x)


@dataclass(frozen=True)
class StiffTracks(OfReal):
    """The sign of some values is taken wrongly, and more often so for large values, whose tracks are nearly
    straight."""

    name = "charge_misid"
    source = "sagitta of stiff tracks"

    strength: float = strength(0.01, 0.4, "of values at the end of the range")
    zero: float = drawn(-0.25, 0.25, "of the half range")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        u = unit(self.place, x) - self.zero
        wrong = np.minimum(self.strength * (0.3 + 0.7 * u**2), 0.5)
        mirrored = 2 * value(self.place, self.zero) - x
        return np.where(rng.random(x.shape) < wrong, mirrored, x)


@dataclass(frozen=True)
class WrongVertex(OfCosine):
    """A few tracks are attached to the vertex of another collision far along the beam, and their direction comes out
    far off."""

    name = "outliers"
    source = "vertex association at high luminosity"

    strength: float = strength(0.004, 0.12, "of events")
    distance: float = drawn(1.5, 4.0, "of the barrel's radius")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        wrong = rng.random(x.shape) < self.strength
        shift = self.distance * rng.uniform(0.7, 1.3, x.shape) * rng.choice([-1, 1], x.shape)
        return np.where(wrong, cosine_of(cotangent(x) + shift), x)


@dataclass(frozen=True)
class FlippedBits(OfReal):
    """In a few values one of the highest bits of the stored number is flipped, and the value is off by that bit's
    weight."""

    name = "outliers"
    source = "single-event upsets in memories"
    stage = 4

    strength: float = strength(0.001, 0.05, "of values")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        weight = 1.5 * self.place.half_range * 2.0 ** rng.integers(3, size=x.shape)
        return x + weight * rng.choice([-1, 1], x.shape) * (rng.random(x.shape) < self.strength)


@dataclass(frozen=True)
class EqualAngles(OfCosine):
    """The direction is known only by the block that was hit, and the blocks stand at equal steps of the angle; the
    value is that of the block's middle."""

    name = "quantisation"
    source = "rings of lead-glass blocks"
    stage = 4

    strength: float = strength(0.01, 0.3, "rad")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        blocks = round(np.pi / self.strength)
        hit = np.minimum(np.floor(np.arccos(x) * blocks / np.pi), blocks - 1)
        return np.cos((hit + 0.5) * np.pi / blocks)


@dataclass(frozen=True)
class Companding(OfReal):
    """The value is sent in few steps that are fine around the middle and become coarser and coarser away from it."""

    name = "quantisation"
    source = "mu-law companding in telemetry"
    stage = 4

    strength: float = strength(0.01, 0.25, "of the half range, the finest step")
    knee: float = drawn(0.3, 1.0, "of the half range")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = self.strength / self.knee
        code = np.rint(np.arcsinh(unit(self.place, x) / self.knee) / step)
        return value(self.place, self.knee * np.sinh(step * code))


@dataclass(frozen=True)
class EncoderStop(OfCosine):
    """The angle is read by an arm that runs against a stop on one side, and every track beyond the stop is written
    down with the stop's angle."""

    name = "censoring"
    source = "spectrometer arms with end stops"
    stage = 4

    strength: float = strength(0.05, 0.7, "rad")
    side: float = drawn(1.0, 1.0, sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return self.side * np.minimum(self.side * x, np.cos(self.strength))


@dataclass(frozen=True)
class TwoConverters(OfReal):
    """Two converters take turns, and each of them records what is beyond the end of its scale as that end, which is
    not the same for both."""

    name = "censoring"
    source = "interleaved flash converters"
    stage = 4

    strength: float = strength(0.004, 0.3, "of values beyond the nearer end")
    ratio: float = drawn(0.5, 0.9, "of those beyond the farther end")
    side: float = drawn(1.0, 1.0, sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        upward = self.side * self.place.reference[:, self.place.columns]
        near, far = np.quantile(upward, [1 - self.strength, 1 - self.ratio * self.strength])
        return self.side * np.minimum(self.side * x, np.where(rng.random(x.shape) < 0.5, near, far))


@dataclass(frozen=True)
class Protractor(OfCosine):
    """Some of the angles were read by eye from a protractor and written down at its nearest long mark, one at every
    ten degrees."""

    name = "heaping"
    source = "scanning of bubble-chamber photographs"
    stage = 4

    strength: float = strength(0.005, 0.5, "of events")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        mark = np.cos(np.radians(10 * np.rint(np.degrees(np.arccos(x)) / 10)))
        return np.where(rng.random(x.shape) < self.strength, mark, x)


@dataclass(frozen=True)
class RoundValues(OfReal):
    """Some values that are close to a round number are written down as that number."""

    name = "heaping"
    source = "digit preference in log books"
    stage = 4

    strength: float = strength(0.01, 0.9, "of values at a round number")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        about = np.log10(0.7 * self.place.std)
        step = 10 ** np.floor(about) * np.select([about % 1 < 0.3, about % 1 < 0.7], [1, 2], 5)
        nearest = step * np.rint(x / step)
        close = 1 - 2 * np.abs(x - nearest) / step
        return np.where(rng.random(x.shape) < self.strength * close, nearest, x)


FAMILIES = (
    MaterialConfusion,
    StiffTracks,
    WrongVertex,
    FlippedBits,
    EqualAngles,
    Companding,
    EncoderStop,
    TwoConverters,
    Protractor,
    RoundValues,
)
