"""Cells of an image that are dead, noisy, or differ along a row or a column."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import drawn, strength
from avobench.challenge.shapes.places import Picture

DARK = 1e-3
"""Share of the glow below which it is not followed any further."""


class Grid(Picture):
    """A change that acts on certain cells, whose places are drawn as shares of the image."""

    def row(self, share: float) -> int:
        """That lies at a share of the image's height."""
        return int(share * self.shape[0])

    def column(self, share: float) -> int:
        """That lies at a share of the image's width."""
        return int(share * self.shape[1]) % self.shape[1]

    def around(self, row: float, column: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """How far each cell is from the one at two shares: (rows, 1), (1, columns). Columns come round again."""
        rows, columns = self.shape
        across = (np.arange(columns) - self.column(column) + columns // 2) % columns - columns // 2
        return (np.arange(rows) - self.row(row))[:, None], across[None, :]


@dataclass(frozen=True)
class CrackedWafer(Grid):
    """A hairline crack runs slantwise through a silicon wafer. The cells that it crosses are dead."""

    name = "dead_cells"
    source = "cracks in silicon wafers under thermal stress"

    strength: float = strength(0.06, 1.0)
    """Length of the crack, as a share of the image's width."""
    height: float = drawn(0.4, 0.6)
    """Where it begins."""
    begin: float = drawn(0, 1)
    slant: float = drawn(0.05, 0.4, sign=True)
    """Rows a column."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        along = np.arange(round(self.strength * columns))
        row = np.clip(self.row(self.height) + np.rint(self.slant * along).astype(int), 0, rows - 1)
        hits[:, row, (self.column(self.begin) + along) % columns] = False
        return hits


@dataclass(frozen=True)
class BeamSpot(Grid):
    """A mis-steered beam hit the detector once and burnt a spot into it. All cells of this oval are dead."""

    name = "dead_cells"
    source = "beam-loss accidents in pixel detectors"

    strength: float = strength(0.8, 5.0, "cells")
    """Half of its height."""
    stretch: float = drawn(0.7, 2.0)
    """Its width, relative to the height."""
    height: float = drawn(0.4, 0.6)
    side: float = drawn(0, 1)

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        up, across = self.around(self.height, self.side)
        burnt = up**2 + (across / self.stretch) ** 2 <= self.strength**2
        return hits & ~burnt


@dataclass(frozen=True)
class AmplifierGlow(Grid):
    """The output amplifier of the chip glows in the infrared. The cells beside it often fire with no particle in them,
    those further away ever less.
    """

    name = "noisy_cells"
    source = "electroluminescence of readout amplifiers"
    stage = 4

    strength: float = strength(0.002, 0.5)
    """Probability to fire beside the amplifier."""
    length: float = drawn(0.6, 2.5, "cells")
    """Over which it falls by a factor e."""
    height: float = drawn(0.2, 0.8)
    side: float = drawn(0, 1)

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        glow = np.exp(-np.hypot(*self.around(self.height, self.side)) / self.length)
        row, column = np.nonzero(glow > DARK)
        fired = rng.random((len(hits), len(row)), dtype=np.float32) < self.strength * glow[row, column]
        hits[:, row, column] |= fired
        return hits


@dataclass(frozen=True)
class TelegraphCells(Grid):
    """A few cells sit on a defect that catches and releases a charge. They blink: for a stretch of events one fires in
    all of them, and then it is quiet again.
    """

    name = "noisy_cells"
    source = "random telegraph noise of image sensors"
    stage = 4

    strength: float = strength(0.01, 0.6)
    """Share of the time in which a cell fires."""
    cells: float = drawn(1, 10)
    stretch: float = drawn(1, 30, "events", log=True)
    pattern: float = drawn(0, 1)
    """Decides which cells."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        where, cells, stretch = np.random.default_rng(int(self.pattern * 2**32)), int(self.cells), round(self.stretch)
        row, column = where.integers(rows // 4, rows - rows // 4, cells), where.integers(columns, size=cells)
        fires = rng.random((-(-len(hits) // stretch), cells)) < self.strength
        fires = np.repeat(fires, stretch, axis=0)[: len(hits)]
        for k in range(cells):
            hits[:, row[k], column[k]] |= fires[:, k]
        return hits


@dataclass(frozen=True)
class ResistiveStrip(Grid):
    """The high voltage of a row of cells is fed in at one point, through a strip that has become resistive. The further
    round a cell of this row lies, the less efficient it is.
    """

    name = "gain"
    source = "voltage drop along the electrodes of resistive chambers"

    strength: float = strength(0.05, 1.0)
    """Share of the hits that the last cell loses."""
    height: float = drawn(0.38, 0.62)
    feed: float = drawn(0, 1)
    thickness: float = drawn(1, 4, "rows")
    """Of the strip, rounded down."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        columns = self.shape[1]
        strip = slice(self.row(self.height), self.row(self.height) + int(self.thickness))
        loss = self.strength * ((np.arange(columns) - self.column(self.feed)) % columns + 1) / columns
        part = hits[:, strip]
        hits[:, strip] = part & (rng.random(part.shape) >= loss)
        return hits


@dataclass(frozen=True)
class ClockFeedthrough(Grid):
    """The clock of the readout couples into one column, and half as much into the next: in some events several of its
    cells fire at once without a particle.
    """

    name = "gain"
    source = "clock feedthrough into columns of image sensors"
    stage = 4

    strength: float = strength(0.002, 0.3)
    """Probability of a cell to fire."""
    side: float = drawn(0, 1)
    bunching: float = drawn(0.2, 0.9)
    """Share of the events with no feedthrough at all; the others have the more."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        coupled = rng.random((len(hits), 1)) >= self.bunching
        chance = coupled * min(1.0, self.strength / (1 - self.bunching))
        for step, share in enumerate((1.0, 0.5)):
            column = (self.column(self.side) + step) % self.shape[1]
            hits[:, :, column] |= rng.random(hits.shape[:2]) < share * chance
        return hits
