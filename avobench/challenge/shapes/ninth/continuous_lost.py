"""Shapes of real features: events lost or foreign along the range, and features that act on one another."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Change, Injection, Replacement, drawn, strength
from avobench.challenge.shapes.places import Along, Single, Together, reflected, unscaled


@dataclass(frozen=True)
class SlantAbsorption(Along):
    """Particles cross the wall of a tube at a slant, and the more so the nearer they fly to an end of the range. On the
    longer way through the wall more of them are absorbed."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "beam pipes and cryostat walls, air mass in astronomy"

    strength: float = strength(0.03, 1.0)
    longest: float = drawn(3, 8)
    """The way through the wall in units of its thickness where the tube ends, beyond which it grows no further."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        across = np.sqrt(np.maximum(1 - s**2, self.longest**-2))
        return np.exp(-self.strength * (1 / across - 1))


@dataclass(frozen=True)
class TurnOn(Along):
    """The trigger asks for a value some way inside one end of the range, and its own noise blurs the demand. Events
    near this end are hardly ever recorded, those further inside are as always."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "turn-on curves of calorimeter triggers"

    strength: float = strength(0.01, 0.35, "half ranges", sign=True)
    """How far from the end half of the events pass; the sign tells which end."""
    noise: float = drawn(0.1, 0.4)
    """Of the trigger, in units of that distance."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        reach = abs(self.strength)
        inside = 1 - np.sign(self.strength) * s
        return ndtr((inside - reach) / (self.noise * reach))


@dataclass(frozen=True)
class HalfOff(Along):
    """One of two halves of the detector was switched off for a share of the time. In a band at the middle, where both
    halves overlap, the loss sets in gradually."""

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "endcaps with power supplies of their own"

    strength: float = strength(0.02, 0.5, sign=True)
    """The share of the time; the sign tells which half."""
    overlap: float = drawn(0.02, 0.3, "half ranges")

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - abs(self.strength) * (1 + np.sign(self.strength) * np.clip(s / self.overlap, -1, 1)) / 2


@dataclass(frozen=True)
class OneEndReadout(Along):
    """A long bar is read out at one end only, and what starts in its far half must cross more material to get there.
    The chance to arrive falls exponentially with the distance."""

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "scintillator bars, drift tubes with electron attachment"

    strength: float = strength(0.03, 1.0, sign=True)
    """The bar's length in units of that of attenuation; the sign tells which end is far."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        distance = (1 + np.sign(self.strength) * np.clip(s, -1, 1)) / 2
        return np.exp(-abs(self.strength) * distance)


@dataclass(frozen=True)
class Combinatorial(Single, Replacement):
    """Some candidates are built of particles that do not belong together. Their values spread over the whole range,
    with a density that is a straight line of small slope."""

    name: ClassVar = "flat_background"
    source: ClassVar = "combinatorial background in spectroscopy of decays"

    strength: float = strength(0.01, 0.3)
    slope: float = drawn(0.02, 0.5, sign=True)
    """Change of the density from the middle to an end, in units of that at the middle."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        a = self.slope
        s = (np.sqrt((1 - a) ** 2 + 4 * a * rng.random((n, 1))) - 1) / a
        return unscaled(self.place, s)


@dataclass(frozen=True)
class SkyAndRoom(Single, Replacement):
    """Muons from the sky and decays in the walls of the hall are recorded as if they were events. Along the horizontal
    beam the walls shine evenly, and the sky as one minus the square of the place."""

    name: ClassVar = "flat_background"
    source: ClassVar = "cosmic muons and natural radioactivity at surface laboratories"

    strength: float = strength(0.01, 0.3)
    sky: float = drawn(0.1, 0.6)
    """Share of the background that comes from the sky."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        walls = rng.uniform(-1, 1, n)
        muons = np.sort(rng.uniform(-1, 1, (n, 3)), axis=1)[:, 1]  # a median of three has density 3/4 (1 - s^2)
        return unscaled(self.place, np.where(rng.random(n) < self.sky, muons, walls)[:, None])


@dataclass(frozen=True)
class TailedLine(Single, Replacement):
    """A radioactive contamination emits a line of one sharp value, blurred by the electronics. Charge that is trapped
    on the way draws out a tail to one side of the line."""

    name: ClassVar = "peak_background"
    source: ClassVar = "lines of potassium and lead in semiconductor spectrometers"

    strength: float = strength(0.003, 0.15)
    line: float = drawn(-0.75, 0.75, "half ranges")
    tail: float = drawn(0.02, 0.1, "half ranges", sign=True)
    """Mean of the exponential loss; the sign tells its side."""

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        s = self.line + 0.03 * rng.standard_normal((n, 1)) - self.tail * rng.standard_exponential((n, 1))
        return unscaled(self.place, s)


@dataclass(frozen=True)
class SlitImage(Single, Replacement):
    """Light of a calibration lamp falls through a narrow slit onto the detector during data taking. It adds an even
    patch with a half shadow at both of its sides."""

    name: ClassVar = "peak_background"
    source: ClassVar = "leaking calibration lamps of spectrographs, ghost images"

    strength: float = strength(0.003, 0.15)
    slit: float = drawn(-0.7, 0.7, "half ranges")
    width: float = drawn(0.04, 0.2, "half ranges", log=True)

    def foreign(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        patch = rng.uniform(-0.5, 0.5, (n, 1)) + rng.uniform(-0.15, 0.15, (n, 1))
        return unscaled(self.place, self.slit + self.width * patch)


@dataclass(frozen=True)
class ModuleGap(Along):
    """Between two modules of the detector there is a gap that sees nothing. At its sides the guard rings record a part
    of the events, the more the further from the gap."""

    name: ClassVar = "dead_region"
    source: ClassVar = "cracks between calorimeter modules and tiles of sensors"

    strength: float = strength(0.004, 0.12, "half ranges")
    """Half the width of the gap."""
    gap: float = drawn(-0.6, 0.6, "half ranges")

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip((np.abs(s - self.gap) / self.strength - 1) / 0.4, 0, 1)


@dataclass(frozen=True)
class BurntSpot(Along):
    """A strong beam once stood at one place of the detector and damaged the material there. Around the spot events are
    lost with a chance that falls off as the beam's bell-shaped profile did."""

    name: ClassVar = "dead_region"
    source: ClassVar = "radiation damage of sensors, ageing of wires, burn-in of screens and channel plates"

    strength: float = strength(0.03, 0.95)
    spot: float = drawn(-0.6, 0.6, "half ranges")
    width: float = drawn(0.04, 0.12, "half ranges")

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * np.exp(-(((s - self.spot) / self.width) ** 2) / 2)


@dataclass(frozen=True)
class HeldCharge(Together, Change):
    """One converter reads the channels one after another, and its capacitor is not fully emptied in between. Each
    reading carries on a part of the reading before it, with what that had carried on itself."""

    name: ClassVar = "crosstalk"
    source: ClassVar = "multiplexed converters with sample and hold"

    strength: float = strength(0.01, 0.3, sign=True)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        z = (x - self.place.centre) / self.place.std
        for j in range(1, z.shape[1]):
            z[:, j] += self.strength * z[:, j - 1]
        return self.place.centre + self.place.std * z


@dataclass(frozen=True)
class StrongestSpills(Together, Change):
    """In every event the channel with the strongest signal spills a share of it into the channels beside it. Weaker
    channels stay below what it takes to disturb their neighbours."""

    name: ClassVar = "crosstalk"
    source: ClassVar = "optical crosstalk of multi-anode photomultipliers, spectral overlap in cytometry"

    strength: float = strength(0.015, 0.4)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        z = (x - self.place.centre) / self.place.std
        strongest = np.abs(z).argmax(axis=1)[:, None]
        beside = np.abs(np.arange(z.shape[1]) - strongest) == 1
        return x + self.strength * self.place.std * beside * np.take_along_axis(z, strongest, axis=1)


@dataclass(frozen=True)
class TimeWalk(Together, Change):
    """A small pulse crosses the threshold later than a large one, so that what is timed with it shifts. The shift in
    one feature goes with the inverse of another and was set to nothing for pulses of middle height."""

    name: ClassVar = "conditional_response"
    source: ClassVar = "leading-edge discriminators"

    strength: float = strength(0.02, 0.5, "standard deviations", sign=True)
    pulse: float = drawn(0, 1)
    """Which feature is the height of the pulse, as a place among all; the next one is shifted."""
    pedestal: float = drawn(0.2, 0.6)
    """Height of the smallest pulses, in units of the range."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        k = x.shape[1]
        i = min(int(self.pulse * k), k - 1)
        j = (i + 1) % k
        height = np.clip((1 + (x[:, i] - self.place.centre[i]) / self.place.half_range[i]) / 2, 0, None)
        x[:, j] += self.strength * self.place.std[j] * (1 / (self.pedestal + height) - 1 / (self.pedestal + 0.5))
        return x


@dataclass(frozen=True)
class JointDriftDiffusion(Together, Change):
    """Charge drifts to the readout from a depth that is one of the features, and spreads on its way. Another feature is
    thereby smeared with a width that grows as the square root of the depth."""

    name: ClassVar = "conditional_response"
    source: ClassVar = "time projection chambers, thick silicon sensors"

    strength: float = strength(0.05, 1.0, "standard deviations")
    """Width of the smearing at the end of the range."""
    depth: float = drawn(0, 1)
    """Which feature is the depth, as a place among all; the one before it is smeared."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        k = x.shape[1]
        i = min(int(self.depth * k), k - 1)
        way = np.clip((1 + (x[:, i] - self.place.centre[i]) / self.place.half_range[i]) / 2, 0, None)
        x[:, i - 1] += self.strength * self.place.std[i - 1] * np.sqrt(way) * rng.standard_normal(len(x))
        return x


@dataclass(frozen=True)
class JointMainsHum(Together, Change):
    """The mains hum on all channels while an event is read out, at whatever phase it happens to have. Every channel
    gets the same sine wave, a little later than the channel before it."""

    name: ClassVar = "correlation"
    source: ClassVar = "ground loops in electrophysiology and front-end electronics"

    strength: float = strength(0.05, 1.0, "standard deviations")
    lag: float = drawn(0, 0.35, "rad")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.uniform(0, 2 * np.pi, (len(x), 1)) - self.lag * np.arange(x.shape[1])
        return reflected(self.place, x + self.strength * self.place.std * np.sin(phase))


@dataclass(frozen=True)
class Traverse(Together, Change):
    """Every quantity is measured from the one before it, as marks along a road are. An error made at one mark is
    carried on to all that follow, where the errors of the legs add up."""

    name: ClassVar = "correlation"
    source: ClassVar = "levelling in surveys, chains of comparisons in metrology"

    strength: float = strength(0.05, 0.8, "standard deviations")
    start: float = drawn(0.7, 2)
    """Error of the first mark in units of that of a leg."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        legs = rng.standard_normal(x.shape)
        legs[:, 0] *= self.start
        return x + self.strength * self.place.std * legs.cumsum(axis=1) / np.sqrt(x.shape[1])


FAMILIES: tuple[type[Injection], ...] = (
    SlantAbsorption,
    TurnOn,
    HalfOff,
    OneEndReadout,
    Combinatorial,
    SkyAndRoom,
    TailedLine,
    SlitImage,
    ModuleGap,
    BurntSpot,
    HeldCharge,
    StrongestSpills,
    TimeWalk,
    JointDriftDiffusion,
    JointMainsHum,
    Traverse,
)
