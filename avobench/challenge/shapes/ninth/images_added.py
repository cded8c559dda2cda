"""Images with hits that do not belong to their event."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from avobench.challenge.shapes.contract import Injection, Simulate, drawn, strength
from avobench.challenge.shapes.ninth.images_lines import Mapped
from avobench.challenge.shapes.ninth.images_lost import thinned
from avobench.challenge.shapes.places import Image, Picture

LEAKING = 12
"""Cells that leak enough to fire at all."""
PATCH = 2.5
"""Radius around a discharge beyond which nothing is felt, in cells."""


@dataclass(frozen=True)
class LeakageCurrents(Mapped):
    """A dozen cells have so much leakage current that they fire by themselves, each at its own steady rate. One is by
    far the worst, and the rates of the others fall off by rank.
    """

    name: ClassVar = "noisy_cells"
    source: ClassVar = "leakage currents in a silicon sensor"
    stage: ClassVar = 4

    strength: float = strength(0.005, 0.9)
    """Probability that the worst cell fires in an image."""
    slope: float = drawn(0.5, 2.5)
    """Power of the rank with which the rate falls."""
    arrangement: float = drawn(0, 1e6)
    """A number that tells which cells they are."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        flat = hits.reshape(len(hits), self.place.task.num_features)
        cells = np.random.default_rng(int(self.arrangement)).permutation(flat.shape[1])[:LEAKING]
        rates = self.strength / np.arange(1.0, len(cells) + 1) ** self.slope
        flat[:, cells] |= rng.random((len(flat), len(cells))) < rates
        return hits


@dataclass(frozen=True)
class MicroDischarge(Mapped):
    """At a scratch in the sensor there is a small discharge now and then, which makes the cell there fire. Each time
    the cells around it may fire along with it, the closer the more likely.
    """

    name: ClassVar = "noisy_cells"
    source: ClassVar = "micro-discharges at a sensor defect under high voltage"
    stage: ClassVar = 4

    strength: float = strength(0.004, 0.6)
    """Probability of a discharge during an image."""
    row: float = drawn(0.02, 0.98)
    """Share of all hits up to the row of the scratch."""
    column: float = drawn(0, 1)
    """Where the scratch lies among the columns."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        distance = self.distance(self.row_at(self.row), self.column_at(self.column))
        discharges = np.flatnonzero(rng.random(len(hits)) < self.strength)
        for row, column in np.argwhere(distance <= PATCH):
            hits[discharges, row, column] |= rng.random(len(discharges)) < np.exp(-distance[row, column])
        return hits


@dataclass(frozen=True)
class CommonMode(Picture):
    """The electronics adds Gaussian noise to every cell, and where it passes the threshold the cell fires. The baseline
    of all cells moves up and down together, so that some images have many such hits and others hardly any.
    """

    name: ClassVar = "random_noise"
    source: ClassVar = "common-mode noise of front-end chips"
    stage: ClassVar = 4

    strength: float = strength(0.004, 3, "hits")
    """Noise hits in an image whose baseline is where it should be."""
    sway: float = drawn(0.05, 0.4)
    """Standard deviation of the baseline, in that of the noise of a cell."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        flat = hits.reshape(len(hits), self.place.task.num_features)
        threshold = ndtri(self.strength / flat.shape[1])
        probability = ndtr(threshold + self.sway * rng.standard_normal(len(flat)))
        number = rng.poisson(-flat.shape[1] * np.log1p(-probability))
        event = np.repeat(np.arange(len(flat)), number)
        flat[event, rng.integers(flat.shape[1], size=len(event))] = True
        return hits


@dataclass(frozen=True)
class DarkCounts(Picture):
    """Cells fire in the dark by heat, anywhere and at any time. The light that a firing cell gives off may set off one
    of its four neighbours, which may do the same in turn.
    """

    name: ClassVar = "random_noise"
    source: ClassVar = "dark counts and optical crosstalk of silicon photomultipliers"
    stage: ClassVar = 4

    strength: float = strength(0.003, 2.5)
    """Dark counts in an image, without those that they set off."""
    crosstalk: float = drawn(0.05, 0.4)
    """Probability that a cell that fires sets off a neighbour."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength, len(hits)))
        row, column = rng.integers(rows, size=len(event)), rng.integers(columns, size=len(event))
        while len(event):
            hits[event, row, column] = True
            direction = rng.integers(4, size=len(event))
            row = row + np.array([1, -1, 0, 0])[direction]
            column = (column + np.array([0, 0, 1, -1])[direction]) % columns
            onward = (rng.random(len(event)) < self.crosstalk) & (row >= 0) & (row < rows)
            event, row, column = event[onward], row[onward], column[onward]
        return hits


@dataclass(frozen=True)
class SameCrossing(Image):
    """Several collisions may happen in the same crossing of the beams, and one image then shows all of their hits. The
    number of further collisions is a Poisson number.
    """

    name: ClassVar = "pile_up"
    source: ClassVar = "bunch crossings of a collider"
    stage: ClassVar = 4

    strength: float = strength(0.004, 0.6)
    """Mean number of further collisions in an image."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        further = rng.poisson(self.strength, len(x))
        for k in range(further.max(initial=0)):
            rows = np.flatnonzero(further > k)
            x[rows] = np.maximum(x[rows], simulate(theta[rows], rng))
        return x


@dataclass(frozen=True)
class SlowPixels(Image):
    """Cells stay above threshold for a while after a hit, so that an image still shows a part of the event before. The
    shorter the time between the two, which is random, the more of its hits are left.
    """

    name: ClassVar = "pile_up"
    source: ClassVar = "slow shaping in a monolithic pixel sensor"
    stage: ClassVar = 4

    strength: float = strength(0.005, 0.8)
    """Mean time that a cell stays above threshold, over the mean time between events."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        left = np.exp(-rng.standard_exponential(len(x)) / self.strength)
        rows = np.flatnonzero(left > 1e-3)
        if len(rows):
            before = thinned(self.pictures(simulate(theta[rows], rng)), left[rows], rng)
            x[rows] = np.maximum(x[rows], before.reshape(len(rows), -1).astype(x.dtype))
        return x


FAMILIES: tuple[type[Injection], ...] = (
    LeakageCurrents,
    MicroDischarge,
    CommonMode,
    DarkCounts,
    SameCrossing,
    SlowPixels,
)
