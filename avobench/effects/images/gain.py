"""A wrong gain: one row or one column of an image records another share than the rest."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect

PINNED = 1e-6
"""Half the range of a row or column that is read off the data: it is a whole number."""
ODD = 5.0
"""Standard errors by which a line differs from its neighbours to be looked at. What such differences are as a rule is
taken from all of them, so that a profile that bends is no fault."""
LEAST = 1e-3
"""What a line records at least, of the median: one that is dead has a logarithm too."""
LINES = ("row", "column")


@dataclass(frozen=True)
class Gain(ImageEffect):
    """One row, or one column, records a share of its energies; of hits it loses the rest. Both are counted from 0."""

    shape: str = "row"
    hits: bool = True
    """Whether cells record whole numbers, of which there cannot be more."""
    odd: tuple[int | None, int | None] | None = None
    """The row and the column that stand out in the data, if one does."""
    stage = 4
    name = "gain"
    position = 9
    sentence = "One row or column of cells has another gain, or misses a part of its hits."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 14"

    @classmethod
    def entries(cls, site):
        return [cls(site.task.event_shape, hits=np.dtype(site.task.dtype).kind in "iu")]

    @property
    def parameters(self):
        axis = LINES.index(self.shape)
        found = self.odd[axis] if self.odd else None
        low, high = (0, self.grid[axis] - 1) if found is None else (found - PINNED, found + PINNED)
        return (Parameter("gain", 0, 1 if self.hits else 2, 1, "1"), Parameter(self.shape, low, high, None, self.shape))

    def shapes(self):
        return tuple(replace(self, shape=line) for line in LINES)

    def adapted(self, x):
        return replace(self, odd=tuple(odd_line(x, self.grid, axis) for axis in (0, 1)))

    def guess(self, x):
        """Nothing where no line stands out."""
        return np.empty((0, 2)) if self.odd and self.odd[LINES.index(self.shape)] is None else None

    def apply(self, simulate, theta, phi, rng):
        x, (gain, line) = simulate(theta, rng), phi.T
        cells = np.moveaxis(np.arange(self.num_cells).reshape(self.grid), LINES.index(self.shape), 0)
        at = np.arange(len(x))[:, None], cells[np.rint(line).astype(int)]
        x[at] = rng.binomial(x[at], gain[:, None]) if self.hits else x[at] * gain[:, None]
        return x


def odd_line(x: NDArray, grid: tuple[int, int], axis: int) -> int | None:
    """The row (axis 0) or column (1) of images (N, d) that differs most from its neighbours; None if none is odd."""
    total, fires = (np.sum(v.reshape(-1, *grid), axis=(0, 2 - axis), dtype=float) for v in (x, x > 0))
    usual = np.median(total)
    if len(total) < 5 or not usual > 0:
        return None
    y = np.log(np.maximum(total, LEAST * usual))
    off = y - _beside(y)
    scatter = np.median(np.abs(off)) / 0.6745  # as of a normal distribution
    z = np.abs(off) / np.sqrt(scatter**2 + 1.5 / np.maximum(_beside(fires), 1))
    worst = int(z.argmax())
    return worst if z[worst] > ODD else None


def _beside(y: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each of y (n,) is by its two neighbours on a straight line, or at the ends by the next two."""
    return np.r_[2 * y[1] - y[2], (y[:-2] + y[2:]) / 2, 2 * y[-2] - y[-3]]
