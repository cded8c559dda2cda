"""Real features whose scale, zero or resolution is not that of the simulation."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, drawn, strength
from avobench.challenge.shapes.places import Real, Single, reflected, unscaled


@dataclass(frozen=True)
class DriftDiffusion(Real, Change):
    """The charge drifts through the gas to the wires at one end and spreads by diffusion on its way. What was set free
    far from the wires is measured the worst, with an error that grows as the square root of the distance.
    """

    name: ClassVar = "resolution"
    source: ClassVar = "time projection chamber"

    strength: float = strength(0.12, 0.8, "std")
    """Standard deviation of the error at the far end."""
    wires: float = drawn(1, 1, sign=True)
    """The end at which the charge is read."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        s = (x - self.place.centre) / self.place.half_range
        distance = np.clip((1 - np.sign(self.wires) * s) / 2, 0, 1)
        return reflected(
            self.place, x + self.strength * self.place.std * np.sqrt(distance) * rng.standard_normal(x.shape)
        )


@dataclass(frozen=True)
class MirrorVibration(Real, Change):
    """The instrument swings at a resonance of its mount while events are recorded. Each value is displaced by the swing
    at a random moment, most often by nearly the whole amplitude.
    """

    name: ClassVar = "resolution"
    source: ClassVar = "vibration of a telescope's secondary mirror"

    strength: float = strength(0.15, 1, "std")
    """Amplitude of the swing."""
    unsteady: float = drawn(0, 0.3)
    """Relative spread of the amplitude from event to event."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        amplitude = self.strength * self.place.std * (1 + self.unsteady * rng.uniform(-1, 1, x.shape))
        return reflected(self.place, x + amplitude * np.sin(rng.uniform(0, 2 * np.pi, x.shape)))


@dataclass(frozen=True)
class WarmUp(Single, Change):
    """The zero of the electronics creeps away while it warms up after power was switched on, and then stays where it
    is. The calibration was made with cold electronics, so most events carry the whole shift.
    """

    name: ClassVar = "offset"
    source: ClassVar = "bench electronics after power-on"

    strength: float = strength(0.01, 0.5, "std", sign=True)
    warming: float = drawn(0.02, 0.2, log=True)
    """Time constant as a share of the run."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        warm = 1 - np.exp(-rng.random(x.shape) / self.warming)
        return reflected(self.place, x + self.strength * self.place.std * warm)


@dataclass(frozen=True)
class StaleSurvey(Single, Change):
    """A detector was moved when its magnet was opened, and its old position stayed in the database. From that day on
    all values are shifted by the same amount.
    """

    name: ClassVar = "offset"
    source: ClassVar = "geometry database of a spectrometer"

    strength: float = strength(0.01, 0.5, "std", sign=True)
    after: float = drawn(0.7, 1)
    """Share of the events that were recorded after the move."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        moved = rng.random(x.shape) < self.after
        return reflected(self.place, x + self.strength * self.place.std * moved)


@dataclass(frozen=True)
class WeatherGain(Single, Change):
    """The amplification in the gas depends exponentially on the air pressure, and the calibration was made in other
    weather. All values are too large or too small by a factor that changes a little from day to day.
    """

    name: ClassVar = "scale"
    source: ClassVar = "gas gain of a proportional chamber"

    strength: float = strength(0.006, 0.25, sign=True)
    """Mean of the logarithm of the factor."""
    weather: float = drawn(0.05, 0.3)
    """Spread of that logarithm, relative to its mean."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        pressure = 1 + self.weather * np.clip(rng.standard_normal(x.shape), -3, 3)
        return reflected(self.place, x * np.exp(self.strength * pressure))


@dataclass(frozen=True)
class LensDistortion(Real, Change):
    """A simple lens enlarges the picture more, or less, the farther a point is from the optical axis, and its scale was
    set at the rim of the picture. Inside, distances are told in a wrong unit that changes with their square.
    """

    name: ClassVar = "scale"
    source: ClassVar = "barrel and pincushion distortion of a camera"

    strength: float = strength(0.01, 0.3, sign=True)
    """Relative error of the unit at the optical axis."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        s = (x - self.place.centre) / self.place.half_range
        return unscaled(self.place, s * (1 + self.strength * (1 - np.minimum(s * s, 1.5))))


FAMILIES: tuple[type[Injection], ...] = (
    DriftDiffusion,
    MirrorVibration,
    WarmUp,
    StaleSurvey,
    WeatherGain,
    LensDistortion,
)
