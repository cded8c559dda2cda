"""Images in which one row or one column is not as the others, and the map of cells that other shapes need too."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, drawn, strength
from avobench.challenge.shapes.places import Picture


class Mapped(Picture):
    """What happens at certain cells."""

    @cached_property
    def profile(self) -> NDArray[np.float64]:
        """Share of the images in which a cell is hit: (rows, columns)."""
        return self.pictures(self.place.reference).mean(axis=0)

    def row_at(self, share: float) -> int:
        """The row up to which this share of all hits lies."""
        reached = np.cumsum(self.profile.sum(axis=1))
        return min(int(np.searchsorted(reached, share * reached[-1])), self.shape[0] - 1)

    def column_at(self, share: float) -> int:
        """The column up to which this share of all columns lies."""
        return int(share * self.shape[1]) % self.shape[1]

    def distance(self, row: int, column: int) -> NDArray[np.float64]:
        """Of each cell from one of them, in cells: (rows, columns)."""
        steps = [np.abs(np.arange(size) - at) for size, at in zip(self.shape, (row, column), strict=True)]
        for axis in self.place.task.cyclic_axes:
            steps[axis] = np.minimum(steps[axis], self.shape[axis] - steps[axis])
        return np.hypot(steps[0][:, None], steps[1])


@dataclass(frozen=True)
class ResistiveLine(Mapped):
    """The line that reads one column has become resistive, and the signals fade on their way along it. The further a
    cell of this column lies from the amplifier, the more of its hits are lost.
    """

    name: ClassVar = "gain"
    source: ClassVar = "read-out line of a strip or wire detector"

    strength: float = strength(0.05, 3, sign=True)
    """Length of the column over the length on which the signals fade; its sign says at which end is the amplifier."""
    column: float = drawn(0, 1)
    """Where the column lies among the columns."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        way = (np.arange(self.shape[0]) + 0.5) / self.shape[0]
        survival = np.exp(-abs(self.strength) * (way if self.strength > 0 else way[::-1]))
        hits[:, :, self.column_at(self.column)] &= rng.random((len(hits), len(way))) < survival
        return hits


@dataclass(frozen=True)
class SharedCharge(Mapped):
    """The gain of one row is too high. The little charge that spills over from a hit in the row before or behind is
    then often enough to make its cell fire too.
    """

    name: ClassVar = "gain"
    source: ClassVar = "charge sharing in a silicon sensor"

    strength: float = strength(0.004, 0.7)
    """Probability that a hit next to the row makes the cell of the row fire."""
    row: float = drawn(0.1, 0.9)
    """Share of all hits up to the row."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        row = self.row_at(self.row)
        for beside in {max(row - 1, 0), min(row + 1, self.shape[0] - 1)} - {row}:
            event, column = np.nonzero(hits[:, beside])
            spills = rng.random(len(event)) < self.strength
            hits[event[spills], row, column[spills]] = True
        return hits


FAMILIES: tuple[type[Injection], ...] = (ResistiveLine, SharedCharge)
