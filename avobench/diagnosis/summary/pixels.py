"""The summary of images: sums of rows, of columns and of blocks, how full they are, and how often neighbours fire."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.settings import SUMMARY
from avobench.diagnosis.summary.bins import Summary, View, closed, inner_edges, spans_of


@dataclass(frozen=True)
class Pixels(Summary):
    """The summary of images of `grid` rows and columns, flattened by rows; `fullness` are inner edges for the hits."""

    grid: tuple[int, int]
    fullness: NDArray[np.float64]
    filled: NDArray[np.bool_] | None = None
    """Which parts of the vector are filled often enough to be used (K,); the others are zero. All by default."""

    @cached_property
    def blocks(self) -> list[tuple[str, int]]:
        """(name, length) of each part of the vector, in order."""
        r, c = self.grid
        coarse = min(SUMMARY.image_blocks, r) * min(SUMMARY.image_blocks, c)
        return [("row", r), ("column", c), ("hits", len(self.fullness) + 1), ("block", coarse), ("neighbours", 2)]

    @cached_property
    def size(self) -> int:
        return sum(length for _, length in self.blocks)

    def vectors(self, x: NDArray) -> NDArray[np.float32]:
        """(n, d) -> (n, K). By what is not zero, since hits are few."""
        n, (r, c) = len(x), self.grid
        where = np.flatnonzero(x != 0)
        event, cell = np.divmod(where, r * c)
        row, column = np.divmod(cell, c)
        values = x.ravel()
        size = values[where].astype(np.float32)

        def sums(part: NDArray[np.intp], length: int, of: NDArray[np.float32] = size) -> NDArray[np.float32]:
            return np.bincount(event * length + part, of, n * length).reshape(n, length).astype(np.float32)

        blocks = [min(SUMMARY.image_blocks, length) for length in self.grid]
        coarse = [(row * blocks[0]) // r, (column * blocks[1]) // c]
        full = np.searchsorted(self.fullness, sums(0, 1, size > 0)[:, 0], side="right")
        inward, left = np.where(row > 0, where - c, where), where - column + (column - 1) % c
        parts = [
            sums(row, r),
            sums(column, c),
            np.eye(len(self.fullness) + 1, dtype=np.float32)[full],
            sums(coarse[0] * blocks[1] + coarse[1], blocks[0] * blocks[1]),
            sums(0, 1, size * values[inward] * (row > 0)),
            sums(0, 1, size * values[left]),
        ]
        return np.hstack(parts) if self.filled is None else np.hstack(parts) * self.filled

    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        return self.vectors(x).reshape(pieces, -1, self.size).mean(axis=1, dtype=np.float64)

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return weights.T @ self.vectors(x)

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.vectors(x) @ direction

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        # An image has no bins to change; what differs is compared with what two images of the same kind differ by.
        a, b = self.vectors(before), self.vectors(after)
        spread = a.var(axis=0)
        return ((a - b)[:, spread > 0] ** 2 / spread[spread > 0]).mean(axis=1)

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        return np.cov(self.vectors(x), rowvar=False, dtype=np.float64)

    def view(self, x: NDArray) -> View:
        ends = [(name, np.arange(length + 1) - 0.5) for name, length in self.blocks[:2]]
        ends.append(("hits", closed(self.fullness, (x > 0).sum(axis=1))))
        mean, error = x.mean(axis=0, dtype=float), np.sqrt(np.maximum(x.var(axis=0, dtype=float), 1 / len(x)) / len(x))
        return View(spans_of(ends), mean.reshape(self.grid), error.reshape(self.grid))


def pixels_of(x: NDArray, simulated: NDArray, event_shape: tuple[int, ...]) -> Pixels:
    """The summary for images of this shape; axes beyond the second are joined to it."""
    fullness = inner_edges((x > 0).sum(axis=1), (simulated > 0).sum(axis=1), SUMMARY.hit_bins)
    summary = Pixels((event_shape[0], int(np.prod(event_shape[1:]))), fullness)
    totals = [summary.vectors(y > 0).sum(axis=0, dtype=float) * len(x) / len(y) for y in (x, simulated)]
    return replace(summary, filled=np.maximum(*totals) >= SUMMARY.least_hits)
