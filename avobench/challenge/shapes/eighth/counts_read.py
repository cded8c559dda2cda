"""Counts that are read out or written down wrongly."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class AmplifierNoise(Counting, Change):
    """The count is told from the height of an amplified signal, and the amplifier adds thermal noise. The reading is
    the whole number next to the noisy height, and never negative.
    """

    name: ClassVar = "readout_noise"
    source: ClassVar = "charge readout of a CCD"
    stage: ClassVar = 4

    strength: float = strength(0.15, 0.8, "std")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.maximum(np.rint(x + rng.normal(0, self.strength * self.place.std[0], x.shape)), 0)


@dataclass(frozen=True)
class PopcornNoise(Counting, Change):
    """A trap in the readout transistor fills and empties at random. When it does so during a reading, the reading jumps
    up or down by a fixed step.
    """

    name: ClassVar = "readout_noise"
    source: ClassVar = "random telegraph noise of a CMOS sensor"
    stage: ClassVar = 4

    strength: float = strength(0.005, 0.3)
    """Share of the readings that jump."""
    step: float = drawn(1, 2, "std")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        step = max(round(self.step * float(self.place.std[0])), 1)
        jumps = rng.random(x.shape) < self.strength
        return np.maximum(x + step * jumps * rng.choice([-1, 1], x.shape), 0)


@dataclass(frozen=True)
class SquareRootCoding(Counting, Change):
    """When the link to the ground is slow, counts are sent as a short code of their square root. What is decoded from
    it has steps that grow with the count.
    """

    name: ClassVar = "quantisation"
    source: ClassVar = "on-board compression of a solar telescope"
    stage: ClassVar = 4

    strength: float = strength(0.01, 0.8)
    """Share of the events that are sent in this way."""
    step: float = drawn(1, 2, "std")
    """Of the code, as a multiple of the spread of the counts, which follows the square root as well."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        code = np.rint(2 * np.sqrt(x) / self.step)
        decoded = np.rint((code * self.step / 2) ** 2)
        return np.where(rng.random(x.shape) < self.strength, decoded, x)


@dataclass(frozen=True)
class RoundNumbers(Counting, Change):
    """People who note counts by hand like round numbers. The nearer a count lies to a multiple of five, or of ten where
    counts are large, the more often this one is noted instead.
    """

    name: ClassVar = "quantisation"
    source: ClassVar = "digit preference in clinical records"
    stage: ClassVar = 4

    strength: float = strength(0.02, 0.9)
    """Of the preference for the round number, very close to it."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        unit = 5 if self.mean < 40 else 10
        round_number = unit * np.rint(x / unit)
        nearness = 1 - np.abs(x - round_number) / (unit / 2)
        return np.where(rng.random(x.shape) < self.strength * nearness, round_number, x)


@dataclass(frozen=True)
class ScalerStops(Counting, Change):
    """The scaler has a largest number that it can hold and stops there. All higher counts are read as this number."""

    name: ClassVar = "censoring"
    source: ClassVar = "saturating hardware scaler"
    stage: ClassVar = 4

    strength: float = strength(0.001, 0.25)
    """About the share of the counts that lie higher."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return np.minimum(x, np.floor(self.quantile(1 - self.strength)))


@dataclass(frozen=True)
class DetectionLimit(Counting, Change):
    """A laboratory reports every count below its limit of detection as this limit. Another one, which takes the rest of
    the samples, reports them as they are.
    """

    name: ClassVar = "censoring"
    source: ClassVar = "environmental radioactivity and trace analysis"
    stage: ClassVar = 4

    strength: float = strength(0.004, 0.25)
    """About the share of the counts below the limit."""
    samples: float = drawn(0.4, 1)
    """Share of the samples that go to this laboratory."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = max(np.ceil(self.quantile(self.strength)), 1)
        return np.where(rng.random(x.shape) < self.samples, np.maximum(x, limit), x)


FAMILIES: tuple[type[Injection], ...] = (
    AmplifierNoise,
    PopcornNoise,
    SquareRootCoding,
    RoundNumbers,
    ScalerStops,
    DetectionLimit,
)
