"""What effects on images share: their grid, a fixed order of its cells, and which of them stand out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Effect
from avobench.effects.site import Site

PATTERN = 20190417
"""Seed of the order in which cells are taken where no measurement says which are faulty."""


@dataclass(frozen=True)
class ImageEffect(Effect):
    """An effect on images of `grid` rows and columns, flattened row by row."""

    grid: tuple[int, int] = (32, 32)

    domains = ("images",)

    @classmethod
    def entries(cls, site: Site) -> list[Effect]:
        return [cls(site.task.event_shape)]

    @property
    def num_cells(self) -> int:
        return self.grid[0] * self.grid[1]

    def order(self) -> NDArray[np.intp]:
        return np.random.default_rng(PATTERN).permutation(self.num_cells)


def odd_cells(x: NDArray, grid: tuple[int, int], *, few: bool) -> NDArray[np.intp]:
    """Cells that fire much less, or more, often than the median of their row, five standard errors at least.

    Rows are along the first axis; the second is taken for an azimuth, along which nothing changes. The root of a count
    has the same standard error whatever is expected, down to one or two (F. J. Anscombe, Biometrika 35 (1948) 246).
    """
    fires = (x > 0).sum(axis=0).reshape(grid)
    usual = np.median(fires, axis=1, keepdims=True)
    z = 2 * (np.sqrt(fires + 3 / 8) - np.sqrt(usual + 3 / 8))
    return np.flatnonzero((z < -5) & (fires < 0.7 * usual) if few else (z > 5) & (fires > 1.4 * usual))
