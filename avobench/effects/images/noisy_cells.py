"""Noisy cells: some cells fire by themselves."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect, odd_cells, told


@dataclass(frozen=True)
class NoisyCells(ImageEffect):
    """Some cells fire by themselves: those that the data point to, or, without data, eight of them."""

    cells: tuple[int, ...] | None = None
    stage = 4
    name = "noisy_cells"
    position = 2
    sentence = "Some cells of the detector fire without a particle."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.4"
    parameters = (Parameter("rate", 0, 1, 0, "an event"),)

    def adapted(self, x):
        return replace(self, cells=tuple(odd_cells(x, self.grid, few=False).tolist()))

    def unit(self, parameter, units=()):
        """That, and which cell it is."""
        cell = told(self.cells, self.grid)
        return f"{parameter.unit}, by {cell}" if cell else parameter.unit

    def guess(self, x):
        return np.empty((0, 1)) if self.cells == () else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        cells = list(self.order()[:8] if self.cells is None else self.cells)
        fires = rng.random((len(x), len(cells))) < phi[:, [0]]
        x[:, cells] = np.where(fires, np.maximum(x[:, cells], 1), x[:, cells])
        return x
