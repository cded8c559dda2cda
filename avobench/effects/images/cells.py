"""Effects of faulty cells: dead, noisy or inefficient ones, random noise, and a row or column with a wrong gain."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.effects.contract import Effect, Parameter
from avobench.effects.images.grid import ImageEffect, odd_cells
from avobench.effects.images.particles import PARTICLES, ParticleEffect


@dataclass(frozen=True)
class FaultyCells(ImageEffect):
    """A fault of some cells: those that the data point to, or, without data, cells in a fixed order."""

    cells: tuple[int, ...] | None = None
    stage = 4
    few: ClassVar[bool]
    """Whether they fire less than others, rather than more."""
    where: ClassVar[str] = "{unit}, by {cell}"
    """The unit where one cell is at fault."""

    def adapted(self, x):
        return replace(self, cells=tuple(odd_cells(x, self.grid, few=self.few).tolist()))

    def unit(self, parameter, units=()):
        if self.cells is None or len(self.cells) != 1:
            return parameter.unit
        row, column = divmod(self.cells[0], self.grid[1])  # counted from 0
        return self.where.format(unit=parameter.unit, cell=f"the cell in row {row}, column {column}")

    def guess(self, x):
        return np.empty((0, 1)) if self.cells == () else None


@dataclass(frozen=True)
class DeadCells(FaultyCells):
    """Some cells lose what they should record: those that the data point to, or, without data, a fixed scatter."""

    few, where = True, "of what {cell} records"
    name = "dead_cells"
    position = 1
    sentence = "Some cells of the detector do not record."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"

    @property
    def parameters(self):
        if self.cells is None:
            return (Parameter("fraction", 0, 0.5, 0, "of the cells"),)
        return (Parameter("lost", 0, 1, 0, "1"),)

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
class NoisyCells(FaultyCells):
    """Some cells fire by themselves: those that the data point to, or, without data, eight of them."""

    few = False
    name = "noisy_cells"
    position = 2
    sentence = "Some cells of the detector fire without a particle."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.4"
    parameters = (Parameter("rate", 0, 1, 0, "an event"),)

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
    position = 3
    sentence = "Every cell misses a share of its hits."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"
    parameters = (Parameter("lost", 0, 0.95, 0, "1"),)

    @classmethod
    def entries(cls, site):
        """One entry; where the task generates particles it has the shape that knows their momenta, too."""
        family = TrackInefficiency if site.task.generates == PARTICLES else cls
        return [family(site.task.event_shape)]

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event, cell = np.nonzero(x)
        gone = rng.random(len(event)) < phi[event, 0]
        x[event[gone], cell[gone]] = 0
        return x


@dataclass(frozen=True)
class SoftInefficiency(ParticleEffect):
    """A particle is lost if its momentum is below a threshold, which differs from particle to particle."""

    shape: str = "soft"
    name, sentence, source = Inefficiency.name, "Particles of low momentum are missed.", Inefficiency.source
    parameters = (Parameter("threshold", 0, 3, 0, "GeV", soft=True), Parameter("width", 0.05, 0.5, None, "of it"))

    def altered(self, particles, theta, phi, rng):
        momentum = np.sqrt((particles.momentum**2).sum(axis=0))
        threshold, width = phi.T
        excess = (momentum / np.where(threshold > 0, threshold, 1) - 1) / width
        return particles.only((rng.random(len(momentum)) < ndtr(excess)) | (threshold == 0))


@dataclass(frozen=True)
class TrackInefficiency(Inefficiency):
    """Hits are lost everywhere alike, or those of particles of low momentum."""

    def shapes(self) -> tuple[Effect, ...]:
        return (self, SoftInefficiency(self.grid))


@dataclass(frozen=True)
class RandomNoise(ImageEffect):
    """Cells fire at random, `rate` of them in each event."""

    stage = 4
    name = "random_noise"
    position = 4
    sentence = "Cells fire at random, as from thermal noise."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.4"

    @property
    def parameters(self):
        return (Parameter("rate", 0, 0.1 * self.num_cells, 0, "cells per event"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event = np.repeat(np.arange(len(x)), rng.poisson(phi[:, 0]))
        cell = rng.integers(self.num_cells, size=len(event))
        x[event, cell] = np.maximum(x[event, cell], 1)
        return x


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
        line = self.odd[axis] if self.odd else None
        low, high = (0, self.grid[axis] - 1) if line is None else (line - PINNED, line + PINNED)
        return (Parameter("gain", 0, 1 if self.hits else 2, 1, "1"), Parameter(self.shape, low, high, None, self.shape))

    def shapes(self):
        return tuple(replace(self, shape=line) for line in LINES)

    def adapted(self, x):
        return replace(self, odd=tuple(odd_line(x, self.grid, axis) for axis in (0, 1)))

    def guess(self, x):
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
