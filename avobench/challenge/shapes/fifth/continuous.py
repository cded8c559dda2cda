"""Shapes for one or a few continuous features: those that change values or put other events in their place."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, Replacement, Simulate, drawn, strength
from avobench.challenge.shapes.fifth import selections
from avobench.challenge.shapes.fifth.scale import OfOne, OfTwo, continuous, moved, partner, restored, unit

Values = NDArray[np.float64]


@dataclass(frozen=True)
class StiffTracks(OfOne, Change):
    """The sign is told from a curvature that vanishes for the largest values, so these are often flipped."""

    strength: float = strength(0.01, 0.6, "at the end of the range")
    name, source = "charge_misid", "Sagitta of stiff or forward tracks below the position resolution"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        largest = np.abs(self.place.centre) + self.place.half_range
        flipped = rng.random(x.shape) < self.strength * np.minimum(np.abs(x) / largest, 1) ** 2
        return np.where(flipped, -x, x)


@dataclass(frozen=True)
class SupplyDroop(OfTwo, Injection):
    """A large signal of either sign in a neighbour pulls down the common supply, and this feature is read shifted."""

    strength: float = strength(0.03, 1.5, "standard deviations", sign=True)
    which: float = drawn(0, 1)
    name, source = "conditional_response", "Common supply of two amplifiers"

    def measure(self, simulate: Simulate, theta: Values, rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        load = np.minimum(partner(self.place, self.which).scaled(x) ** 2, 1.5)
        x[:, self.place.columns] += self.strength * self.place.std * load
        return x


@dataclass(frozen=True)
class CommonMode(Injection):
    """Channels share the noise of one ground; each was then calibrated to its known width, so only the noise's
    share of it tells."""

    strength: float = strength(0.07, 1.2, "standard deviations")
    name, source = "correlation", "Common-mode noise of neighbouring channels"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.feature == "all" and continuous(place)

    def measure(self, simulate: Simulate, theta: Values, rng: np.random.Generator) -> NDArray:
        x, noise = simulate(theta, rng), self.strength * rng.standard_normal((len(theta), 1))
        mean = self.place.reference.mean(axis=0)
        return mean + (x - mean + noise * self.place.std) / np.hypot(1, self.strength)


@dataclass(frozen=True)
class LightLeak(OfTwo, Injection):
    """Light of another cell comes through its wrapping, by a share that depends on where in the cell it was made."""

    strength: float = strength(0.01, 0.6, "of the other signal")
    which: float = drawn(0, 1)
    name, source = "crosstalk", "Optical crosstalk between scintillator cells"

    def measure(self, simulate: Simulate, theta: Values, rng: np.random.Generator) -> NDArray:
        x, other = simulate(theta, rng), partner(self.place, self.which)
        share = self.strength * rng.gamma(3, 1 / 3, (len(x), 1))
        x[:, self.place.columns] += share * x[:, other.columns] * self.place.std / other.std
        return x


@dataclass(frozen=True)
class CosmicRays(Replacement):
    """Muons from the sky pass close to the centre by chance. They avoid the ends, but are broad otherwise."""

    strength: float = strength(0.005, 0.5, "of the events")
    reach: float = drawn(1, 1.8, "half ranges, 1 for a cosine")
    name, source = "flat_background", "Cosmic muons in coincidence with the beam"

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.feature is not None and continuous(place)

    def foreign(self, n: int, rng: np.random.Generator) -> Values:
        u = 2 * rng.beta(1.5, 1.5, (n, len(self.place.columns))) - 1
        return restored(self.place, u * (1 if self.place.cosine else self.reach))


@dataclass(frozen=True)
class SourceLeftOpen(OfOne, Replacement):
    """The calibration source was left open: a narrow line with a smaller escape line below it."""

    strength: float = strength(0.003, 0.25, "of the events")
    at: float = drawn(-0.45, 0.7, "half ranges")
    width: float = drawn(0.015, 0.05, "half ranges")
    name, source = "peak_background", "Full line and escape line of a radioactive source"

    def foreign(self, n: int, rng: np.random.Generator) -> Values:
        line = self.at - 0.3 * (rng.random((n, 1)) < 0.2)
        return restored(self.place, line + self.width * rng.standard_normal((n, 1)))


@dataclass(frozen=True)
class AfterTheIntervention(OfOne, Change):
    """The detector was opened during the run and closed slightly out of place; all later events are shifted."""

    strength: float = strength(0.01, 0.5, "half ranges", sign=True)
    later: float = drawn(0.5, 0.95, "of the events")
    name, source = "offset", "Alignment that is out of date after an access"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        return moved(self.place, x, self.strength * (rng.random(x.shape) < self.later))


@dataclass(frozen=True)
class DecayInFlight(OfOne, Change):
    """A few particles decay on their way, and the kink throws the measurement far off to either side."""

    strength: float = strength(0.004, 0.25, "of the events")
    kink: float = drawn(0.4, 1, "half ranges")
    name, source = "outliers", "Kinked tracks of pions and kaons that decay to muons"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        kinked = rng.random(x.shape) < self.strength
        return moved(
            self.place, x, kinked * self.kink * rng.choice([-1, 1], x.shape) * (0.5 + rng.exponential(1, x.shape))
        )


@dataclass(frozen=True)
class SharedStrips(OfOne, Change):
    """A hit in a strip's middle is read at its centre, one near a border fires both strips and is read in between."""

    strength: float = strength(0.02, 0.6, "half ranges")
    shared: float = drawn(0.15, 0.6, "of a strip")
    name, stage, source = "quantisation", 4, "Binary read-out of a strip detector"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        strip = unit(self.place, x) / self.strength
        centre, border = np.floor(strip) + 1 / 2, np.rint(strip)
        both = np.abs(strip - border) < self.shared / 2
        return restored(self.place, np.where(both, border, centre) * self.strength)


@dataclass(frozen=True)
class LongDrift(OfOne, Change):
    """Charge made far from the read-out at the middle spreads as it drifts, so values far off are smeared most."""

    strength: float = strength(0.03, 0.7, "half ranges")
    name, source = "resolution", "Diffusion along the drift in a time projection chamber"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        spread = self.strength * np.sqrt(np.minimum(np.abs(unit(self.place, x)), 1))
        return moved(self.place, x, spread * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class UnevenAbsorber(OfOne, Change):
    """Each particle is scattered in a different thickness of material, most in little and some in much."""

    strength: float = strength(0.02, 0.5, "half ranges")
    name, source = "resolution", "Multiple scattering in cables and cooling pipes"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        thickness = rng.exponential(1, x.shape)
        return moved(self.place, x, self.strength * np.sqrt(thickness) * rng.standard_normal(x.shape))


@dataclass(frozen=True)
class SoftKneeAndRail(OfOne, Change):
    """Above a knee the amplifier answers with half its gain, until it stands at the rail."""

    strength: float = strength(0.03, 1.2, "half ranges from the knee to the end")
    name, source = "saturation", "Output stage of an amplifier close to its supply voltage"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        above = np.maximum(unit(self.place, x) - (1 - self.strength), 0)
        return restored(self.place, unit(self.place, x) - above + np.minimum(above / 2, 0.3 * self.strength))


@dataclass(frozen=True)
class BowedResponse(OfOne, Change):
    """The response was calibrated at the middle and at both ends; in between it bends away from a straight line."""

    strength: float = strength(0.01, 0.5, "slope at the middle", sign=True)
    name, source = "scale", "Integral nonlinearity of a converter"

    def change(self, x: Values, rng: np.random.Generator) -> Values:
        u = unit(self.place, x)
        return restored(self.place, u + self.strength * u * np.maximum(1 - u**2, 0))


FAMILIES = (
    StiffTracks,
    SupplyDroop,
    CommonMode,
    LightLeak,
    CosmicRays,
    SourceLeftOpen,
    AfterTheIntervention,
    DecayInFlight,
    SharedStrips,
    LongDrift,
    UnevenAbsorber,
    SoftKneeAndRail,
    BowedResponse,
    *selections.FAMILIES,
)
