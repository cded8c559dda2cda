"""Shapes for images [eta, phi] of hits or of energies."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import Injection, Place, Simulate, drawn, strength

BATCH = 1000
"""Images that are changed at a time, to keep the memory small."""


class OfImages(Injection):
    """An injection that changes every image, in units of energy; a hit without a size is 1."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return len(place.task.event_shape) == 2 and not isinstance(place.feature, int)

    @abstractmethod
    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """What is read out: (n, rows, columns) -> (n, rows, columns)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.recorded(simulate(theta, rng), rng)

    def recorded(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        """The images (n, d) as they are read out, in the units of the task."""
        out = np.empty_like(x)
        for start in range(0, len(x), BATCH):
            rows = slice(start, start + BATCH)
            image = self.record(self.energy(x[rows]).reshape(-1, *self.place.task.event_shape), rng)
            out[rows] = self.units(image.reshape(len(image), -1))
        return out

    def energy(self, x: NDArray) -> NDArray[np.float64]:
        x = x.astype(float)
        return np.expm1(x) if self.logarithmic else x

    def units(self, energy: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.place.binary:
            return (energy > 0).astype(float)
        return np.log1p(energy) if self.logarithmic else energy

    @property
    def logarithmic(self) -> bool:
        return bool(getattr(self.place.task, "log1p", False))

    @property
    def eta(self) -> NDArray[np.float64]:
        """Of the rows, from -1 to 1: (rows, 1)."""
        return np.linspace(-1, 1, self.place.task.event_shape[0])[:, None]

    def deposit(self, shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float64]:
        """Sizes of false hits, on average half of a true one's."""
        if self.place.binary:
            return np.ones(shape)
        energy = self.energy(self.place.reference)
        return rng.exponential(energy[energy > 0].mean() / 2, shape)


class OfEnergies(OfImages):
    """An injection that means nothing for hits without a size."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and not place.binary


@dataclass(frozen=True)
class DeadBoard(OfImages):
    """A board that reads a rectangle of cells is dead. That opposite shares its supply and fails in half of the run."""

    strength: float = strength(0.004, 0.25, "of the cells")
    row: float = drawn(0.2, 0.8, "of the rows")
    column: float = drawn(0, 1, "of the columns")
    name, source = "dead_cells", "Failed low voltage of a read-out board"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        rows, columns = image.shape[1:]
        half = np.sqrt(self.strength) / 2
        near = np.abs((np.arange(rows) + 0.5) / rows - self.row) < max(half, 0.5 / rows)
        turn = (np.arange(columns) / columns - self.column) % 1
        first = near[:, None] & (turn < 2 * half)
        second = near[:, None] & ((turn + 0.5) % 1 < 2 * half) & (rng.random((len(image), 1, 1)) < 0.5)
        return np.where(first | second, 0, image)


@dataclass(frozen=True)
class WarmRegulator(OfImages):
    """Cells around a warm voltage regulator fire by themselves, the nearer to it the more often."""

    strength: float = strength(0.01, 0.9, "firings an event of the nearest cell")
    row: float = drawn(0.1, 0.9, "of the rows")
    column: float = drawn(0.1, 0.9, "of the columns")
    reach: float = drawn(0.7, 2, "cells")
    name, stage, source = "noisy_cells", 4, "Leakage current that grows with the temperature"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        rows, columns = image.shape[1:]
        far = np.hypot(
            np.arange(rows)[:, None] - np.floor(self.row * rows), np.arange(columns) - np.floor(self.column * columns)
        )
        fires = rng.random(image.shape) < self.strength * np.exp(-far / self.reach)
        return image + fires * self.deposit(image.shape, rng)


@dataclass(frozen=True)
class LightBursts(OfImages):
    """Stray light makes cells fire anywhere, in some events hardly any and in others many at once."""

    strength: float = strength(0.0003, 0.05, "firings a cell")
    name, stage, source = "random_noise", 4, "Sparks in the beam pipe or a light leak"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        level = self.strength * rng.exponential(1, (len(image), 1, 1))
        return image + (rng.random(image.shape) < level) * self.deposit(image.shape, rng)


@dataclass(frozen=True)
class FadingPredecessor(OfImages):
    """In some events an earlier collision is still seen, in those cells that have not yet recovered."""

    strength: float = strength(0.01, 0.9, "of the events")
    left: float = drawn(0.4, 0.9, "of the earlier hits")
    name, stage, source = "pile_up", 4, "Collisions of the bunch crossing before"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return image * (rng.random(image.shape) < self.left)

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        late = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(late):
            earlier = self.recorded(simulate(theta[late], rng), rng)
            x[late] = self.units(self.energy(x[late]) + self.energy(earlier))
        return x


@dataclass(frozen=True)
class ForwardDamage(OfImages):
    """Sensors close to the beam have suffered most from radiation, and miss ever more hits towards either end."""

    strength: float = strength(0.02, 0.95, "of the hits at the ends")
    power: float = drawn(0.5, 2)
    name, source = "inefficiency", "Trapping of charge in irradiated silicon"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return image * (rng.random(image.shape) >= self.strength * np.abs(self.eta) ** self.power)


@dataclass(frozen=True)
class BusyLink(OfImages):
    """All cells of a row share one link, so a hit is the more often lost the more others the row has."""

    strength: float = strength(0.01, 0.8, "of the hits, lost for each other one")
    name, source = "inefficiency", "Limited bandwidth of a data concentrator"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        others = np.maximum((image > 0).sum(axis=2, keepdims=True) - 1, 0)
        return image * (rng.random(image.shape) < (1 - self.strength) ** others)


@dataclass(frozen=True)
class TemperatureGradient(OfEnergies):
    """One end of the detector is colder than the other, and the gain changes steadily from end to end."""

    strength: float = strength(0.01, 0.6, "at the ends", sign=True)
    name, source = "gain", "Light yield that depends on the temperature"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return image * (1 + self.strength * self.eta)


@dataclass(frozen=True)
class RaisedForward(OfEnergies):
    """Small signals are cut away by a threshold, blurred by noise and raised towards the noisy ends."""

    strength: float = strength(0.03, 2, "median energies of a hit cell")
    rise: float = drawn(0, 1.5, "at the ends")
    name, stage, source = "threshold", 3, "Discriminators tuned to an equal rate of noise"

    def record(self, image: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        energy = self.energy(self.place.reference)
        threshold = self.strength * np.median(energy[energy > 0]) * (1 + self.rise * self.eta**2)
        return image * (rng.random(image.shape) < expit((image / threshold - 1) / 0.15))


FAMILIES = (
    DeadBoard,
    WarmRegulator,
    LightBursts,
    FadingPredecessor,
    ForwardDamage,
    BusyLink,
    TemperatureGradient,
    RaisedForward,
)
