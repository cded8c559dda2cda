"""Dead cells: some cells lose what they should record."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect, odd_cells, told


@dataclass(frozen=True)
class DeadCells(ImageEffect):
    """Some cells lose what they should record: those that the data point to, or, without data, a fixed scatter."""

    cells: tuple[int, ...] | None = None
    stage = 4
    name = "dead_cells"
    position = 1
    sentence = "Some cells of the detector do not record."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"

    @property
    def parameters(self):
        if self.cells is None:
            return (Parameter("fraction", 0, 0.5, 0, "of the cells"),)
        return (Parameter("lost", 0, 1, 0, "1"),)

    def adapted(self, x):
        return replace(self, cells=tuple(odd_cells(x, self.grid, few=True).tolist()))

    def unit(self, parameter, units=()):
        """That, and which cell it is."""
        cell = told(self.cells, self.grid)
        return f"of what {cell} records" if cell else parameter.unit

    def guess(self, x):
        return np.empty((0, 1)) if self.cells == () else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.cells is None:
            rank = np.empty(self.num_cells, int)
            rank[self.order()] = np.arange(self.num_cells)
            x[rank < phi[:, [0]] * self.num_cells] = 0
            return x
        cells = list(self.cells)
        x[:, cells] *= rng.random((len(x), len(cells))) >= phi[:, [0]]
        return x
