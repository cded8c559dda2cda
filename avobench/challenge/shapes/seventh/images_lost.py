"""Images of hits that lack some: cells that are dead, hits that are missed, images that do not start the readout."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc, gammaincc

from avobench.challenge.shapes.contract import Injection, Selection, drawn, strength
from avobench.challenge.shapes.places import Image, Picture

CHIP = 8
"""Cells along each side of a readout chip."""


def hits_of(image: Image) -> float:
    """Of an average event, but at least one."""
    return max(float(image.place.reference.sum(axis=1).mean()), 1.0)


def thinned(hits: NDArray[np.bool_], chance: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.bool_]:
    """Images whose hits are each kept with the chance that belongs to their image: chance (n,)."""
    flat = hits.reshape(-1)
    at = np.flatnonzero(flat)
    flat[at[rng.random(len(at)) >= chance[at // hits[0].size]]] = False
    return flat.reshape(hits.shape)


@dataclass(frozen=True)
class Scratch(Picture):
    """The sensor was scratched when it was mounted. The cells along the scratch, a straight line, record nothing."""

    strength: float = strength(1.5, 30, "cells")
    """Length of the scratch."""
    angle: float = drawn(0, np.pi, "rad")
    height: float = drawn(-0.3, 0.3)
    """Row of its middle, where the rows run from -1 to 1."""

    name, source = "dead_cells", "mechanical damage of silicon sensors"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        row, column = np.mgrid[:rows, :columns]
        up, right = row - (rows - 1) / 2 - self.height * rows / 2, column - (columns - 1) / 2
        along = np.cos(self.angle) * right + np.sin(self.angle) * up
        beyond = np.maximum(np.abs(along) - self.strength / 2, 0)
        away = np.hypot(np.cos(self.angle) * up - np.sin(self.angle) * right, beyond)
        return hits & (away > 0.71)


@dataclass(frozen=True)
class Delamination(Picture):
    """Thermal cycles tear the bump bonds of the readout chips off, beginning at a corner of each chip.

    Cells within a quarter circle about that corner are dead; its radius differs from chip to chip.
    """

    strength: float = strength(0.5, 4, "cells")
    """Median of the radius."""
    pattern: float = drawn(0, 1e6)
    """A number that decides how each chip fares."""

    name, source = "dead_cells", "bump bonds of hybrid pixel detectors"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        chips = np.random.default_rng(int(self.pattern))
        row, column = np.indices(self.shape)
        number = -(-np.array(self.shape) // CHIP)
        radius = self.strength * chips.lognormal(0, 0.5, number)
        corner = chips.integers(2, size=(2, *number)) * CHIP
        own = row // CHIP, column // CHIP
        away = np.hypot(row % CHIP + 0.5 - corner[0][own], column % CHIP + 0.5 - corner[1][own])
        return hits & (away > radius[own])


@dataclass(frozen=True)
class BusyReadout(Picture):
    """All cells share one readout, which is busy for a while after each hit that it handles.

    So the more hits an image has, the larger the share of them that is missed, wherever they are.
    """

    strength: float = strength(0.003, 0.6)
    """Time that the average number of hits keeps the readout busy, relative to the time that it is given."""

    name, source = "inefficiency", "shared readout of pixel and time projection chambers"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        load = hits.sum(axis=(1, 2)) / hits_of(self)
        return thinned(hits, 1 / (1 + self.strength * load), rng)


@dataclass(frozen=True)
class SupplyRipple(Picture):
    """The high voltage of the whole detector ripples with the mains, and hits are missed while it is low.

    Events come at any phase of the ripple, so some images are complete and others lack the largest share of their hits.
    """

    strength: float = strength(0.006, 0.8)
    """Share of the hits that is missed where the voltage is lowest."""

    name, source = "inefficiency", "mains ripple of high-voltage supplies"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        phase = rng.uniform(0, np.pi, len(hits))
        return thinned(hits, 1 - self.strength * np.sin(phase) ** 2, rng)


@dataclass(frozen=True)
class AnalogueSum(Image, Selection):
    """The readout starts when the summed pulse height of all hits passes a threshold, so images with few hits are lost.

    Each hit has a pulse height that fluctuates exponentially, as that of an avalanche does.
    """

    strength: float = strength(0.1, 1)
    """The threshold, relative to the sum that an average event has."""

    name, source = "threshold", "total-energy triggers, gas avalanches"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        number = (x > 0).sum(axis=1).astype(float)
        return np.where(number > 0, gammaincc(np.maximum(number, 1), self.strength * hits_of(self)), 0)


@dataclass(frozen=True)
class ColumnMajority(Image, Selection):
    """The readout starts when enough columns of the detector report that they have any hit at all.

    A column's report is now and then missed, and images whose few hits lie in few columns are lost.
    """

    strength: float = strength(0.003, 0.5)
    """Share of the images that have fewer columns with hits than it takes, on average, to pass."""
    report: float = drawn(0.8, 0.98)
    """Probability that a column with hits reports."""

    name, source = "threshold", "majority triggers of drift chambers and neutrino telescopes"

    @cached_property
    def needed(self) -> float:
        """Columns that must report."""
        return max(self.report * float(np.quantile(self.columns_hit(self.place.reference), self.strength)), 1.0)

    def columns_hit(self, x: NDArray) -> NDArray[np.int64]:
        """How many columns have hits: (n, d) -> (n,)."""
        return self.pictures(x).any(axis=1).sum(axis=1)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        number = self.columns_hit(x)
        spare = number - self.needed + 1
        return np.where(spare > 0, betainc(self.needed, np.maximum(spare, 1e-9), self.report), 0)


FAMILIES: tuple[type[Injection], ...] = (
    Scratch,
    Delamination,
    BusyReadout,
    SupplyRipple,
    AnalogueSum,
    ColumnMajority,
)
