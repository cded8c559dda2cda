"""Faulty cells: dead, noisy, inefficient."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.contract import Parameter, accepted
from avobench.effects.images.grid import ImageEffect, odd_cells

LEO = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), "


@dataclass(frozen=True)
class DeadCells(ImageEffect):
    """Some cells lose what they should record: those that the data point to, or, without data, a fixed scatter."""

    cells: tuple[int, ...] | None = None
    stage = 4
    name = "dead_cells"
    sentence = "Some cells of the detector do not record."
    source = LEO + "Section 5.6"

    @property
    def parameters(self):
        if self.cells is None:
            return (Parameter("fraction", 0, 0.5, 0, "of the cells"),)
        return (Parameter("lost", 0, 1, 0, "1"),)

    def adapted(self, x):
        return replace(self, cells=tuple(odd_cells(x, self.grid, few=True).tolist()))

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


@dataclass(frozen=True)
class NoisyCells(ImageEffect):
    """Some cells fire by themselves: those that the data point to, or, without data, eight of them."""

    cells: tuple[int, ...] | None = None
    stage = 4
    name = "noisy_cells"
    sentence = "Some cells of the detector fire without a particle."
    source = LEO + "Section 14.4"
    parameters = (Parameter("rate", 0, 1, 0, "an event"),)

    def adapted(self, x):
        return replace(self, cells=tuple(odd_cells(x, self.grid, few=False).tolist()))

    def guess(self, x):
        return np.empty((0, 1)) if self.cells == () else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        cells = list(self.order()[:8] if self.cells is None else self.cells)
        fires = rng.random((len(x), len(cells))) < phi[:, [0]]
        x[:, cells] = np.where(fires, np.maximum(x[:, cells], 1), x[:, cells])
        return x


@dataclass(frozen=True)
class Inefficiency(ImageEffect):
    """Each hit is lost with a fixed probability."""

    stage = 4
    name = "inefficiency"
    sentence = "Every cell misses a share of its hits."
    source = LEO + "Section 5.6"
    parameters = (Parameter("lost", 0, 0.95, 0, "1"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event, cell = np.nonzero(x)
        gone = rng.random(len(event)) < phi[event, 0]
        x[event[gone], cell[gone]] = 0
        return x


@dataclass(frozen=True)
class RandomNoise(ImageEffect):
    """Cells fire at random, `rate` of them in each event."""

    stage = 4
    name = "random_noise"
    sentence = "Cells fire at random, as from thermal noise."
    source = LEO + "Section 14.4"

    @property
    def parameters(self):
        return (Parameter("rate", 0, 0.1 * self.num_cells, 0, "cells an event"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event = np.repeat(np.arange(len(x)), rng.poisson(phi[:, 0]))
        cell = rng.integers(self.num_cells, size=len(event))
        x[event, cell] = np.maximum(x[event, cell], 1)
        return x


@dataclass(frozen=True)
class PileUp(ImageEffect):
    """To a share of the events another one is added."""

    stage = 1
    name = "pile_up"
    sentence = "Some images show two events at once."
    source = "R. L. Workman et al. (Particle Data Group), Prog. Theor. Exp. Phys. 2022, 083C01, Section 34"
    parameters = (Parameter("fraction", 0, 1, 0, "1"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(rows):
            other = simulate(theta[rows], rng)
            x[rows] = np.maximum(x[rows], other) if x.dtype.kind in "iu" else x[rows] + other
        return x


@dataclass(frozen=True)
class Threshold(ImageEffect):
    """Events of few hits are not recorded: n of them with probability 1 - exp(-(n / threshold)^4)."""

    stage = 3
    name = "threshold"
    sentence = "Events with few hits do not start the readout."
    source = LEO + "Section 17.1"

    @property
    def parameters(self):
        return (Parameter("threshold", 0, 0.04 * self.num_cells, 0, "hits"),)

    def apply(self, simulate, theta, phi, rng):
        def keep(x, rows):
            t = phi[rows, 0]
            return np.where(t > 0, -np.expm1(-(((x > 0).sum(axis=1) / np.where(t > 0, t, 1)) ** 4)), 1)

        return accepted(simulate, theta, keep, rng)
