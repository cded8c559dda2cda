"""Real features: how the detector responds."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, Simulate, drawn, strength
from avobench.challenge.shapes.fourth.scales import (
    cosine_of,
    cotangent,
    one_of_many,
    positive,
    real,
    standardised,
    unit,
    value,
)


class OfCosine(Change):
    """A change that only a cosine can have."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.cosine


class OfReal(Change):
    """A change of one feature that is not a cosine."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return real(place)


class OfPositive(Change):
    """A change of one feature that is never negative, such as an energy."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return positive(place)


class OfAll(Change):
    """A change of all features together."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.feature == "all" and len(place.columns) > 1


class ByOthers(Injection):
    """An injection that changes one feature by what the others are."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return one_of_many(place)

    @abstractmethod
    def by_others(self, x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        """The feature as it is measured: (n, d) -> (n,)."""

    @property
    def column(self) -> int:
        return self.place.columns[0]

    @property
    def next_column(self) -> int:
        return (self.column + 1) % self.place.reference.shape[1]

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        changed = x.copy()
        changed[:, self.column] = self.by_others(x, rng)
        return changed


@dataclass(frozen=True)
class MultipleScattering(OfCosine):
    """The track is scattered in the material before it is measured, so that its direction in space is off by a small
    random angle."""

    name = "resolution"
    source = "Highland formula for beam pipes and first layers"

    strength: float = strength(0.1, 0.6, "rad, in each projection")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        angle = rng.rayleigh(self.strength, x.shape)
        around = np.cos(2 * np.pi * rng.random(x.shape))
        return np.clip(x * np.cos(angle) + np.sqrt(1 - x**2) * np.sin(angle) * around, -1, 1)


@dataclass(frozen=True)
class UnevenQuality(OfReal):
    """Every value has a random error, and the size of this error differs from event to event, as the number of
    electrons collected does."""

    name = "resolution"
    source = "charge collection over varying numbers of strips"

    strength: float = strength(0.1, 0.9, "of the standard deviation, rms")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        width = self.strength * self.place.std * np.sqrt(rng.gamma(2.0, 0.5, x.shape))
        return x + width * rng.standard_normal(x.shape)


@dataclass(frozen=True)
class ShiftedBarrel(OfCosine):
    """The barrel sits a little along the beam from where it is believed to be, so that all tracks cross it at a
    shifted place."""

    name = "offset"
    source = "longitudinal alignment of barrel trackers"

    strength: float = strength(0.015, 0.25, "of the barrel's radius", sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return cosine_of(cotangent(x) + self.strength)


@dataclass(frozen=True)
class WarmingUp(OfReal):
    """The zero of the amplifier creeps away while it warms up and then stays there; the values are all taken to be
    from the zero of the start."""

    name = "offset"
    source = "pedestal drift of charge amplifiers"

    strength: float = strength(0.05, 0.8, "of the standard deviation", sign=True)
    speed: float = drawn(3.0, 20.0, "run over warm-up time")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x - self.strength * self.place.std * np.expm1(-self.speed * rng.random(x.shape))


@dataclass(frozen=True)
class WrongRadius(OfCosine):
    """The barrel's radius is not the one in the geometry file, so that the slopes of all tracks are wrong by one
    factor."""

    name = "scale"
    source = "radial expansion, a weak mode of tracker alignment"

    strength: float = strength(0.03, 0.35, "of the slope", sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return cosine_of(cotangent(x) * (1 + self.strength))


@dataclass(frozen=True)
class PushPull(OfReal):
    """The amplifier handles signals above and below its working point by two transistors, and one of them amplifies
    more than it should."""

    name = "scale"
    source = "push-pull output stages"

    strength: float = strength(0.03, 0.5, "of the gain", sign=True)
    side: float = drawn(1.0, 1.0, sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        u = unit(self.place, x)
        return value(self.place, u * np.where(self.side * u > 0, 1 + self.strength, 1))


@dataclass(frozen=True)
class SoftWireEnds(OfCosine):
    """The place along the wire is found from how the charge divides between its two ends, and close to the ends the
    found places are pressed together short of the end."""

    name = "saturation"
    source = "charge division on resistive wires"

    strength: float = strength(0.8, 1.5, "one over the end of the scale")
    hardness: float = drawn(6.0, 14.0)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x * (1 + np.abs(self.strength * x) ** self.hardness) ** (-1 / self.hardness)


@dataclass(frozen=True)
class SpaceCharge(OfReal):
    """Above some value the charge in the tube holds itself back, and the reading grows only as the logarithm of what
    is beyond."""

    name = "saturation"
    source = "space charge at the last dynodes"

    strength: float = strength(0.4, 20.0, "compression a half range")
    knee: float = drawn(0.0, 0.4, "of the half range")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        u = unit(self.place, x)
        beyond = np.maximum(u - self.knee, 0)
        return value(self.place, u - beyond + np.log1p(self.strength * beyond) / self.strength)


@dataclass(frozen=True)
class Bremsstrahlung(OfPositive):
    """The electron radiates photons in the material before it is measured, and what they carry away is missing: mostly
    next to nothing, sometimes much."""

    name = "radiative_tail"
    source = "Bethe and Heitler"

    strength: float = strength(0.005, 0.25, "radiation lengths")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x * np.exp(-rng.gamma(self.strength / np.log(2), size=x.shape))


@dataclass(frozen=True)
class InitialState(OfPositive):
    """In some events one photon leaves along the beam, unseen, with a share of the energy whose logarithm is evenly
    spread, and the rest is measured."""

    name = "radiative_tail"
    source = "initial-state radiation at e+e- colliders"

    strength: float = strength(0.01, 0.5, "of events")
    softest: float = drawn(0.02, 0.1, "of the energy")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        photon = self.softest ** rng.random(x.shape)
        return x * (1 - photon * (rng.random(x.shape) < self.strength))


@dataclass(frozen=True)
class CapacitiveNeighbours(ByOthers):
    """The channel couples to the channels on both of its sides, and the same small part of each of their signals
    appears in it."""

    name = "crosstalk"
    source = "interstrip capacitance"

    strength: float = strength(0.03, 0.6, "of a neighbour's signal", sign=True)

    def by_others(self, x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        sides = {self.next_column, (self.column - 1) % x.shape[1]}
        leaked = sum(standardised(self.place, x, side) for side in sides)
        return x[:, self.column] + self.strength * self.place.std[0] * leaked


@dataclass(frozen=True)
class SharedCharge(ByOthers):
    """Part of the charge of the next channel is collected by this one, a larger part the closer to the border it was
    set free."""

    name = "crosstalk"
    source = "charge sharing between pads"

    strength: float = strength(0.05, 0.8, "of the next channel's signal, at most")

    def by_others(self, x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        part = self.strength * np.sqrt(rng.random(len(x)))
        return x[:, self.column] + part * self.place.std[0] * standardised(self.place, x, self.next_column)


@dataclass(frozen=True)
class SaggingSupply(ByOthers):
    """The more the next channel draws from the common supply the lower is the gain of this one, until the supply
    cannot sag further."""

    name = "conditional_response"
    source = "gain sag of micro-channel plates"

    strength: float = strength(0.05, 0.7, "of the gain")

    def by_others(self, x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        load = 1 / (1 + np.exp(-2 * standardised(self.place, x, self.next_column)))
        centre = self.place.centre[0]
        return centre + (x[:, self.column] - centre) * (1 - self.strength * load)


@dataclass(frozen=True)
class BentField(ByOthers):
    """The drift field is bent away from the middle of the chamber, so that this coordinate is displaced by an amount
    that grows as the square of the next one."""

    name = "conditional_response"
    source = "field distortions in time projection chambers"

    strength: float = strength(0.03, 0.6, "of the standard deviation, at one of the other", sign=True)

    def by_others(self, x: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        away = np.minimum(standardised(self.place, x, self.next_column) ** 2, 6)
        return x[:, self.column] + self.strength * self.place.std[0] * away


@dataclass(frozen=True)
class CommonHum(OfAll):
    """All channels sit on one ground, whose voltage swings to and fro, and each reading contains the swing at its
    moment, the same in all channels."""

    name = "correlation"
    source = "common-mode pick-up on silicon detectors"

    strength: float = strength(0.1, 1.2, "amplitude over the standard deviation")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return x + self.strength * self.place.std * np.sin(2 * np.pi * rng.random((len(x), 1)))


@dataclass(frozen=True)
class CommonGain(OfAll):
    """All channels share one high-voltage supply that fluctuates, so that in each event all gains are too high or too
    low together."""

    name = "correlation"
    source = "ripple of high-voltage supplies"

    strength: float = strength(0.05, 0.4, "of the gain, rms")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        gain = 1 + self.strength * np.clip(rng.standard_normal((len(x), 1)), -2.4, 2.4)
        return value(self.place, unit(self.place, x) * gain)


FAMILIES = (
    MultipleScattering,
    UnevenQuality,
    ShiftedBarrel,
    WarmingUp,
    WrongRadius,
    PushPull,
    SoftWireEnds,
    SpaceCharge,
    Bremsstrahlung,
    InitialState,
    CapacitiveNeighbours,
    SharedCharge,
    SaggingSupply,
    BentField,
    CommonHum,
    CommonGain,
)
