"""Continuous features measured, selected and joined by others, by mechanisms that depend on where an event lies."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Replacement, Selection, Simulate, drawn, strength
from avobench.challenge.shapes.first.backgrounds import onto
from avobench.challenge.shapes.first.distortion import Crosstalk
from avobench.challenge.shapes.first.smearing import AngleChange, LineChange


@dataclass(frozen=True)
class SlantedMaterial(AngleChange):
    """The angle is blurred by scattering, the more the longer the way through the material, that is, near the beam."""

    name: ClassVar = "resolution"
    source: ClassVar = "Highland, Nuclear Instruments and Methods 129 (1975) 497: the square root of the thickness"
    strength: float = strength(0.03, 0.5, "rad, across the beam")
    power: float = drawn(0.3, 1, "of 1 / sin")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        width = self.strength * np.maximum(np.sin(angle), 0.05) ** -self.power
        return angle + width * rng.standard_normal(angle.shape)


@dataclass(frozen=True)
class StochasticTerm(LineChange):
    """The value is blurred by noise and, the larger it is, by fluctuations of the shower as well."""

    name: ClassVar = "resolution"
    source: ClassVar = "noise and stochastic term of calorimeters (Particle Data Group, Particle detectors)"
    strength: float = strength(0.03, 0.6, "standard deviations, at 0")
    growth: float = drawn(0.3, 2, "of the variance, per standard deviation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        variance = 1 + self.growth * np.abs(x) / self.place.std
        return x + self.strength * self.place.std * np.sqrt(variance) * rng.standard_normal(x.shape)


@dataclass(frozen=True)
class DisplacedVertex(AngleChange):
    """Collisions take place off the centre, along the beam; angles are measured from the centre of a barrel."""

    name: ClassVar = "offset"
    source: ClassVar = "longitudinal beam-spot displacement, with a bunch of finite length"
    strength: float = strength(0.005, 0.2, "radii of the barrel", sign=True)
    bunch: float = drawn(0, 0.5, "of the displacement")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        z = self.strength * (1 + self.bunch * rng.standard_normal(angle.shape))
        return np.arctan2(np.sin(angle), np.cos(angle) + z * np.sin(angle))


@dataclass(frozen=True)
class PedestalStep(LineChange):
    """In the course of the run the zero of the scale jumps, and stays where it is."""

    name: ClassVar = "offset"
    source: ClassVar = "pedestal jumps after a power cycle of the electronics"
    strength: float = strength(0.005, 0.3, "standard deviations", sign=True)
    after: float = drawn(0.5, 0.95, "share of the run")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x + self.strength * self.place.std * (rng.random((len(x), 1)) < self.after)


@dataclass(frozen=True)
class StretchedBarrel(AngleChange):
    """Lengths along the beam are measured too long or too short, not quite the same on either side of the middle."""

    name: ClassVar = "scale"
    source: ClassVar = "exact geometry of a length scale along the beam: the cotangent is scaled"
    strength: float = strength(0.005, 0.2, sign=True)
    sides: float = drawn(-0.4, 0.4, "share of the strength")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        z = np.cos(angle)
        return np.arctan2(np.sin(angle), (1 + self.strength * (1 + self.sides * np.sign(z))) * z)


@dataclass(frozen=True)
class LogarithmicGain(LineChange):
    """The gain is wrong, by an amount that goes with the logarithm of the signal."""

    name: ClassVar = "scale"
    source: ClassVar = "jet energy scale corrections, usually linear in the logarithm of the energy"
    strength: float = strength(0.005, 0.2, sign=True)
    slope: float = drawn(-0.3, 0.3, "share of the strength")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        size = np.log(np.clip(np.abs(x) / self.place.std, 0.1, 10))
        return x * (1 + self.strength * (1 + self.slope * size))


@dataclass(frozen=True)
class LayersMissed(Selection):
    """Towards both ends of the range particles miss one layer of the detector after the other, and events are lost."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "efficiency of tracks with a required number of layers, in steps"
    strength: float = strength(0.05, 0.95, "share lost at the edge")
    begin: float = drawn(0.6, 0.9, "half ranges")
    layers: float = drawn(2, 6, "rounded down")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        beyond = np.clip((np.abs(self.place.scaled(x)) - self.begin) / (1 - self.begin), 0, 1)
        return (1 - self.strength * np.ceil(int(self.layers) * beyond) / int(self.layers)).prod(axis=1)


@dataclass(frozen=True)
class AttenuatedLight(Selection):
    """The farther from the one end that is read out, the more events are lost, with an attenuation length."""

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "attenuation length of scintillators read out at one end"
    strength: float = strength(0.03, 0.9, "share lost at the far end", sign=True)
    length: float = drawn(0.5, 2, "half ranges")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        near = 1 - np.clip(np.sign(self.strength) * self.place.scaled(x), -1, 1)
        return (1 - abs(self.strength) * np.exp(-near / self.length)).prod(axis=1)


@dataclass(frozen=True)
class UnevenNoise(Replacement):
    """Noise events from all over the range: even within each channel of the detector, nearly so between them."""

    name: ClassVar = "flat_background"
    source: ClassVar = "random coincidences, with the spread of noise rates between channels"
    strength: float = strength(0.01, 0.4)
    channels: float = drawn(6, 25, "rounded down")
    spread: float = drawn(0.05, 0.3, "standard deviation of the logarithm")
    seed: float = drawn(0, 2**31, "which channels")

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        rate = np.exp(self.spread * np.random.default_rng(int(self.seed)).standard_normal(int(self.channels)))
        channel = rng.choice(len(rate), (n, len(self.place.columns)), p=rate / rate.sum())
        return onto(self.place, 2 * (channel + rng.random(channel.shape)) / len(rate) - 1)


@dataclass(frozen=True)
class JacobianPeak(Replacement):
    """Events gather before a kinematic edge, beyond which there are none, and thin out to the other side."""

    name: ClassVar = "peak_background"
    source: ClassVar = "the Jacobian peak of transverse momentum in two-body decays, as of the W boson"
    strength: float = strength(0.003, 0.1)
    edge: float = drawn(-0.7, 0.7, "half ranges")
    tail: float = drawn(0.05, 0.25, "half ranges", sign=True)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        cosine = rng.random((n, len(self.place.columns)))
        return onto(self.place, self.edge + self.tail * (np.sqrt(1 - cosine**2) - 1))


@dataclass(frozen=True)
class TaperedGap(Selection):
    """A crack that particles cross at a slant: losses rise evenly towards its middle, and fall evenly beyond."""

    name: ClassVar = "dead_region"
    source: ClassVar = "cracks between calorimeter modules that point past the vertex"
    strength: float = strength(0.02, 0.35, "half ranges, half the gap's width")
    location: float = drawn(-0.8, 0.8, "half ranges")
    depth: float = drawn(0.6, 1, "share lost in the middle")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        distance = np.abs(self.place.scaled(x) - self.location) / self.strength
        return (1 - self.depth * np.clip(1 - distance, 0, 1)).prod(axis=1)


@dataclass(frozen=True)
class LopsidedFlips(Change):
    """The sign is mistaken, more often for one charge than for the other."""

    name: ClassVar = "charge_misid"
    source: ClassVar = "sagitta bias of misaligned trackers, which pushes tracks towards one charge"
    strength: float = strength(0.005, 0.2)
    preference: float = drawn(0.2, 0.8, "towards losing the positive sign", sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        flipped = rng.random(x.shape) < self.strength * (1 + self.preference * np.sign(x))
        return np.where(flipped, -x, x)


@dataclass(frozen=True)
class NuclearScattering(AngleChange):
    """A share of the particles is scattered by a nucleus, out of its way by a large angle to any side."""

    name: ClassVar = "outliers"
    source: ClassVar = "hadronic interactions in tracker material; spherical law of cosines"
    strength: float = strength(0.02, 0.5)
    mean: float = drawn(0.7, 2, "rad")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hit = rng.random(angle.shape) < self.strength
        by, to = rng.exponential(self.mean, angle.shape), rng.uniform(0, 2 * np.pi, angle.shape)
        cosine = np.cos(angle) * np.cos(by) + np.sin(angle) * np.sin(by) * np.cos(to)
        return np.where(hit, np.arccos(np.clip(cosine, -1, 1)), angle)


@dataclass(frozen=True)
class BitFlips(LineChange):
    """One of the higher bits of the value flips now and then, which moves it far up or down."""

    name: ClassVar = "outliers"
    source: ClassVar = "single-event upsets in readout electronics"
    strength: float = strength(0.003, 0.15)
    lowest: float = drawn(0.7, 1.5, "standard deviations, of the lowest of three bits")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        bit = self.lowest * self.place.std * 2.0 ** rng.integers(3, size=x.shape)
        flipped = np.where(np.floor(x / bit) % 2 == 1, x - bit, x + bit)
        return np.where(rng.random(x.shape) < self.strength, flipped, x)


@dataclass(frozen=True)
class TwoNeighbours(Crosstalk):
    """The signals of the two neighbouring channels leak into this one, from one side more than from the other."""

    source: ClassVar = "capacitive coupling of strips to both neighbours"
    strength: float = strength(0.01, 0.4, "own per other standard deviations", sign=True)
    other_side: float = drawn(0.2, 1)

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x, own = simulate(theta, rng).copy(), self.place.feature
        signal = x / self.place.reference.std(axis=0)
        leak = signal[:, own - 1] + self.other_side * signal[:, (own + 1) % x.shape[1]]
        x[:, own] += self.strength * self.place.std[0] * leak
        return x


@dataclass(frozen=True)
class EtaTowers(AngleChange):
    """The angle is known by the tower that was hit; towers are equally wide in pseudorapidity."""

    name: ClassVar = "quantisation"
    source: ClassVar = "calorimeters at colliders, segmented in pseudorapidity"
    strength: float = strength(0.05, 0.6, "of pseudorapidity")
    border: float = drawn(0, 1, "towers")

    def change_angle(self, angle: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        eta = np.arctanh(np.clip(np.cos(angle), -1 + 1e-12, 1 - 1e-12))
        tower = np.floor(eta / self.strength + self.border)
        return np.arccos(np.tanh(self.strength * (tower + 0.5 - self.border)))


@dataclass(frozen=True)
class LogarithmicConverter(LineChange):
    """Values are rounded to steps that are wider the larger they are."""

    name: ClassVar = "quantisation"
    source: ClassVar = "companding converters, here with an inverse hyperbolic sine"
    strength: float = strength(0.05, 0.8, "of a large value")
    linear: float = drawn(0.3, 1, "standard deviations, up to where steps are even")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        scale = self.linear * self.place.std
        return scale * np.sinh(self.strength * np.rint(np.arcsinh(x / scale) / self.strength))


@dataclass(frozen=True)
class UnsteadyRail(LineChange):
    """No value exceeds what the amplifier can give, and that goes up and down with its supply."""

    name: ClassVar = "saturation"
    source: ClassVar = "amplifiers that clip at their supply voltage"
    strength: float = strength(0.002, 0.25, "share of the events beyond the mean limit")
    ripple: float = drawn(0.05, 0.4, "standard deviations")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = np.quantile(self.place.reference[:, self.place.columns], 1 - self.strength, axis=0)
        return np.minimum(x, limit + self.ripple * self.place.std * rng.standard_normal(x.shape))
