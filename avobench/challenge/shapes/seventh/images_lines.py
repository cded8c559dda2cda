"""Images of hits in which one row or one column of cells is read out by an amplifier of a wrong gain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, drawn, strength
from avobench.challenge.shapes.places import Picture


@dataclass(frozen=True)
class AgedFibre(Picture):
    """The fibre that carries the light of one column has gone cloudy, and a part of the column's hits is lost.

    The light fades along the fibre, so the cells farthest from the end that is read out lose most.
    """

    strength: float = strength(0.04, 5)
    """Length of the fibre, in attenuation lengths beyond what is expected."""
    column: float = drawn(0, 1)
    """Which one, where the columns run from 0 to 1."""
    end: float = drawn(1, 1, sign=True)
    """Its sign says which end is read out."""

    name, source = "gain", "ageing of wavelength-shifting fibres"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        column = min(int(self.column * columns), columns - 1)
        path = (np.arange(rows) + 0.5) / rows
        passes = np.exp(-self.strength * (path if self.end > 0 else 1 - path))
        hits[:, :, column] &= rng.random((len(hits), rows)) < passes
        return hits


@dataclass(frozen=True)
class HotAmplifier(Picture):
    """The amplifiers of one row have too high a gain, so that it has too many hits.

    The little charge that spreads from a cell with a hit to the next ones in the row is then taken for hits of theirs.
    """

    strength: float = strength(0.005, 0.6)
    """Probability that a hit makes a hit of a given next cell."""
    row: float = drawn(0.1, 0.9)
    """Which one: the row up to which this share of all hits lies."""

    name, source = "gain", "charge sharing in strip and pixel detectors"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        profile = self.place.reference.reshape(-1, *self.shape).sum(axis=(0, 2))
        row = int(np.searchsorted(np.cumsum(profile), self.row * profile.sum()))
        line = hits[:, row].copy()
        for step in (1, -1):
            hits[:, row] |= np.roll(line, step, axis=1) & (rng.random(line.shape) < self.strength)
        return hits


FAMILIES: tuple[type[Injection], ...] = (AgedFibre, HotAmplifier)
