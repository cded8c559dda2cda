"""The summary of images: sums of rows, of columns and of blocks, how full they are, and how often neighbours fire."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.summary import Summary, inner_edges

BLOCKS = 8
"""Along each axis, at most."""
FULLNESS_BINS = 12
LEAST_HITS = 40
"""In all images together, for a part of the summary to count: fewer scatter unlike a Gaussian."""


@dataclass(frozen=True)
class Pixels(Summary):
    """Of images of `grid` rows and columns, flattened row by row; `fullness` are inner edges for the number of hits."""

    grid: tuple[int, int]
    fullness: NDArray[np.float64]
    filled: NDArray[np.bool_] | None = None
    """Which parts of the vector are filled often enough to be used (K,); the others are zero. All by default."""

    @cached_property
    def blocks(self) -> list[tuple[str, int]]:
        """(name, length) of each part of the vector, in order."""
        r, c = self.grid
        coarse = min(BLOCKS, r) * min(BLOCKS, c)
        return [("row", r), ("column", c), ("hits", len(self.fullness) + 1), ("block", coarse), ("neighbours", 2)]

    @cached_property
    def size(self) -> int:
        return sum(length for _, length in self.blocks)

    def vectors(self, x: NDArray) -> NDArray[np.float32]:
        """(n, d) -> (n, K)."""
        n, (r, c) = len(x), self.grid
        image = x.reshape(n, r, c)
        rows, columns = image.sum(axis=2, dtype=np.float32), image.sum(axis=1, dtype=np.float32)
        full = np.searchsorted(self.fullness, (x > 0).sum(axis=1), side="right")
        edges = [np.linspace(0, length, min(BLOCKS, length) + 1).astype(int)[:-1] for length in self.grid]
        coarse = np.add.reduceat(np.add.reduceat(image, edges[0], axis=1, dtype=np.float32), edges[1], axis=2)
        along = (image[:, 1:] * image[:, :-1]).sum(axis=(1, 2), dtype=np.float32)
        around = (image * np.roll(image, 1, axis=2)).sum(axis=(1, 2), dtype=np.float32)
        hits = np.eye(len(self.fullness) + 1, dtype=np.float32)[full]
        blocks = coarse.reshape(n, len(edges[0]) * len(edges[1]))
        all_parts = np.hstack([rows, columns, hits, blocks, along[:, None], around[:, None]])
        return all_parts if self.filled is None else all_parts * self.filled

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


def pixels_of(x: NDArray, simulated: NDArray, event_shape: tuple[int, ...]) -> Pixels:
    """The summary for images of this shape; axes beyond the second are joined to it."""
    fullness = inner_edges((x > 0).sum(axis=1), (simulated > 0).sum(axis=1), FULLNESS_BINS)
    summary = Pixels((event_shape[0], int(np.prod(event_shape[1:]))), fullness)
    totals = [summary.vectors(y > 0).sum(axis=0, dtype=float) * len(x) / len(y) for y in (x, simulated)]
    return replace(summary, filled=np.minimum(*totals) >= LEAST_HITS)
