"""Images of hits that have too many: noise of certain or any cells, and hits of other events."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, Simulate, drawn, strength
from avobench.challenge.shapes.places import Image, Picture
from avobench.challenge.shapes.seventh.images_lost import hits_of


@dataclass(frozen=True)
class DarkCurrent(Picture):
    """A few damaged cells leak current and now and then fire without a particle.

    Their leakage, and with it how often they fire, spreads over orders of magnitude.
    """

    strength: float = strength(0.002, 0.15)
    """Firings an image of the cell in the middle of them."""
    cells: float = drawn(3, 15, "cells", log=True)
    pattern: float = drawn(0, 1e6)
    """A number that decides which cells leak and how much."""

    name, source, stage = "noisy_cells", "hot pixels of irradiated CCD and CMOS sensors", 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        damage = np.random.default_rng(int(self.pattern))
        number = round(self.cells)
        at = damage.choice(hits[0].size, number, replace=False)
        leakage = damage.standard_normal(number)
        fires = -np.expm1(-self.strength * np.exp(1.2 * (leakage - np.median(leakage))))
        flat = hits.reshape(len(hits), -1)
        flat[:, at] |= rng.random((len(hits), number)) < fires
        return flat.reshape(hits.shape)


@dataclass(frozen=True)
class Discharge(Picture):
    """At a sharp edge inside the detector there is a discharge now and then, and the cells about it fire together.

    The light of a discharge fades with the distance, and so does the chance that a cell fires.
    """

    strength: float = strength(0.001, 0.3)
    """Share of the images with a discharge."""
    reach: float = drawn(0.5, 1.5, "cells")
    height: float = drawn(-0.4, 0.4)
    """Its row, where the rows run from -1 to 1."""

    name, source, stage = "noisy_cells", "micro-discharges, flashing photomultipliers of neutrino detectors", 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        row, column = np.indices(self.shape)
        away = np.hypot(row - round((1 + self.height) * (rows - 1) / 2), column - columns // 3)
        fires = np.where(away < 4 * self.reach, np.exp(-away / self.reach), 0)
        flashes = np.flatnonzero(rng.random(len(hits)) < self.strength)
        near = np.nonzero(fires)
        hits[flashes[:, None], near[0], near[1]] |= rng.random((len(flashes), len(near[0]))) < fires[near]
        return hits


@dataclass(frozen=True)
class Pickup(Picture):
    """The cables pick up noise from machines nearby, so that cells fire at random anywhere.

    How strong the noise is differs much from image to image: most have little of it, some have a lot.
    """

    strength: float = strength(0.002, 0.25)
    """Noise hits an image, relative to the hits of an average event."""
    spread: float = drawn(0.5, 1.3)
    """Of the logarithm of the noise."""

    name, source, stage = "random_noise", "electromagnetic pick-up on unshielded cables", 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        level = rng.lognormal(-(self.spread**2) / 2, self.spread, len(hits))
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength * hits_of(self) * level))
        flat = hits.reshape(len(hits), -1)
        flat[event, rng.integers(flat.shape[1], size=len(event))] = True
        return flat.reshape(hits.shape)


@dataclass(frozen=True)
class Radioactivity(Picture):
    """Traces of radioactive elements in the material of the detector fire cells at random places.

    Each decay fires one cell, and with some probability each of the four cells next to it.
    """

    strength: float = strength(0.001, 0.12)
    """Decays an image, relative to the hits of an average event."""
    shared: float = drawn(0.15, 0.7)
    """Probability that a decay fires a given cell next to its own."""

    name, source, stage = "random_noise", "radon and uranium traces in low-background detectors", 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength * hits_of(self), len(hits)))
        row, column = rng.integers(rows, size=len(event)), rng.integers(columns, size=len(event))
        hits[event, row, column] = True
        for up, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            fires = (rng.random(len(event)) < self.shared) & (row + up >= 0) & (row + up < rows)
            hits[event[fires], row[fires] + up, (column[fires] + right) % columns] = True
        return hits


@dataclass(frozen=True)
class BunchCrossing(Image):
    """Beam bunches are so dense that now and then more than one collision falls in one crossing and in one image.

    Further collisions are Poisson in number and happen elsewhere along the bunch.
    """

    strength: float = strength(0.002, 0.6)
    """Further collisions an image, on average."""
    spread: float = drawn(0.01, 0.15)
    """Of where they happen, relative to the width of the prior."""

    name, source, stage = "pile_up", "collisions of dense bunches at hadron colliders", 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        task = self.place.task
        number = rng.poisson(self.strength, len(x))
        for k in range(number.max(initial=0)):
            more = np.flatnonzero(number > k)
            moved = theta[more] + self.spread * task.prior.width * rng.standard_normal(theta[more].shape)
            x[more] = np.maximum(x[more], simulate(np.clip(moved, task.support.low, task.support.high), rng))
        return x


@dataclass(frozen=True)
class Afterglow(Image):
    """The signals of the event before have not died away when the next one comes, and its image shows both.

    The time between two events is exponential, and so is the decay of the earlier signals.
    """

    strength: float = strength(0.003, 0.8)
    """Rate of the events times the decay time of a signal."""

    name, source, stage = "pile_up", "slow scintillators and drift chambers at high rates", 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        left = np.exp(-rng.exponential(1 / self.strength, len(x)))
        late = np.flatnonzero(left > 0.01)
        if len(late):
            before = simulate(theta[late], rng)
            event, cell = np.nonzero(before)
            seen = rng.random(len(event)) < left[late][event]
            x[late[event[seen]], cell[seen]] = 1
        return x


FAMILIES: tuple[type[Injection], ...] = (
    DarkCurrent,
    Discharge,
    Pickup,
    Radioactivity,
    BunchCrossing,
    Afterglow,
)
