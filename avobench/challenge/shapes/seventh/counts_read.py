"""What happens to counts when they are read out and written down."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from avobench.challenge.shapes.contract import Change, Injection, drawn, strength
from avobench.challenge.shapes.places import Counting


@dataclass(frozen=True)
class HumInCounts(Counting, Change):
    """The signal line picks up the hum of the mains, and each reading is taken at some phase of it. The reading is too
    high or too low by what the sine wave has there.
    """

    name = "readout_noise"
    source = "ground loops and mains pick-up"
    stage = 4
    strength: float = strength(0.1, 1.0, "std")
    """Root mean square of the hum."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        hum = np.sqrt(2) * self.strength * self.place.std[0] * np.sin(rng.uniform(0, 2 * np.pi, x.shape))
        return np.maximum(np.floor(x + hum + rng.random(x.shape)), 0)


@dataclass(frozen=True)
class TelegraphNoise(Counting, Change):
    """A trap in the transistor of the readout fills and empties at random, and its output jumps between two levels.
    Where it jumps between the two samples whose difference is read, the reading is one jump too high or too low.
    """

    name = "readout_noise"
    source = "random telegraph noise of CMOS sensors with correlated double sampling"
    stage = 4
    strength: float = strength(0.02, 0.6)
    """Share of the readings with a jump."""
    jump: float = drawn(0.7, 2.0, "std")

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        jump = max(round(self.jump * self.place.std[0]), 1)
        jumps = np.where(rng.random(x.shape) < self.strength, rng.choice([-jump, jump], x.shape), 0)
        return np.maximum(x + jumps, 0)


@dataclass(frozen=True)
class RoundTallies(Counting, Change):
    """People who report a number like to give a multiple of five or ten that is near to it. The nearer the round number
    is, the more of them do so.
    """

    name = "quantisation"
    source = "heaping in surveys, such as cigarettes a day, and of readings by eye"
    stage = 4
    strength: float = strength(0.02, 0.8)
    """Probability to go to a round number that is one away; it is squared at two, cubed at three, and so on."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        base = 10 if self.place.std[0] > 5 else 5
        near = base * np.maximum(np.rint(x / base), 1)
        return np.where((x > 0) & (rng.random(x.shape) < self.strength ** np.abs(x - near)), near, x)


@dataclass(frozen=True)
class SquareRootCompression(Counting, Change):
    """To save telemetry a spacecraft sends the square root of a count, rounded, for a part of its data. On the ground
    it is squared again, so that only some numbers can occur, further apart the larger they are.
    """

    name = "quantisation"
    source = "onboard compression of photon counts in solar and X-ray telescopes"
    stage = 4
    strength: float = strength(0.02, 1.0)
    """Share of the data that is compressed."""
    step: float = drawn(0.3, 0.8)
    """Of the square root; its statistical spread is 1/2."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        restored = np.rint((self.step * np.rint(np.sqrt(x) / self.step)) ** 2)
        return np.where(rng.random(x.shape) < self.strength, restored, x)


@dataclass(frozen=True)
class NarrowWindow(Counting, Change):
    """The range of the digitiser is set to a window around the usual counts. What is below it is recorded as its lower
    end and what is above it as its upper end.
    """

    name = "censoring"
    source = "oscilloscopes and digitisers with too small a range"
    stage = 4
    strength: float = strength(0.003, 0.25)
    """Share of the events beyond each end of a centred window, roughly."""
    shift: float = drawn(-0.4, 0.4, "std")
    """By how much the window is off the centre."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        std = self.place.std[0]
        middle, half = self.mean + self.shift * std, -ndtri(self.strength) * std
        return np.clip(x, max(np.rint(middle - half), 0), np.rint(middle + half))


@dataclass(frozen=True)
class DetectionLimit(Counting, Change):
    """Some of the laboratories write the detection limit wherever they have found less than that. The others report
    what they have counted.
    """

    name = "censoring"
    source = "environmental chemistry and microbiology, colony counts"
    stage = 4
    strength: float = strength(0.06, 1.0)
    """Share of the events from laboratories that do so."""
    below: float = drawn(0.05, 0.3, log=True)
    """Share of the events at the limit or below it."""

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        limit = max(self.quantile(self.below), 1.0)
        return np.where(rng.random(x.shape) < self.strength, np.maximum(x, limit), x)


FAMILIES: tuple[type[Injection], ...] = (
    HumInCounts,
    TelegraphNoise,
    RoundTallies,
    SquareRootCompression,
    NarrowWindow,
    DetectionLimit,
)
