"""Images that lose hits, and images that are lost."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Injection, Selection, drawn, strength
from avobench.challenge.shapes.ninth.images_lines import Mapped
from avobench.challenge.shapes.places import Image, Picture


def thinned(hits: NDArray[np.bool_], survival: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.bool_]:
    """Each hit survives with the probability of its image, (n,). It writes into `hits`."""
    cells = np.flatnonzero(hits)
    event = cells // (hits.shape[1] * hits.shape[2])
    hits.reshape(-1)[cells[rng.random(len(cells)) >= survival[event]]] = False
    return hits


@dataclass(frozen=True)
class BrokenBonds(Mapped):
    """The sensor has come off its chip around one point, and the bonds of the cells there are broken. These cells,
    which lie together in a round patch, never record a hit.
    """

    name: ClassVar = "dead_cells"
    source: ClassVar = "bump bonds of a hybrid pixel detector"

    strength: float = strength(0.001, 0.08)
    """Share of the cells that lie in the patch."""
    row: float = drawn(0.05, 0.95)
    """Share of all hits up to the row of the point."""
    column: float = drawn(0, 1)
    """Where the point lies among the columns."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        distance = self.distance(self.row_at(self.row), self.column_at(self.column)).ravel()
        dead = np.argsort(distance, kind="stable")[: round(self.strength * len(distance))]
        hits.reshape(len(hits), self.place.task.num_features)[:, dead] = False
        return hits


@dataclass(frozen=True)
class RadiationDeaths(Mapped):
    """Cells die from the radiation that they have taken, one here and one there. A cell is the more likely to be dead
    the more particles usually cross it, and a dead cell records nothing.
    """

    name: ClassVar = "dead_cells"
    source: ClassVar = "radiation damage of pixel electronics"

    strength: float = strength(0.001, 0.1)
    """Share of the cells that are dead."""
    arrangement: float = drawn(0, 1e6)
    """A number that tells which of the cells have died."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        dose = self.profile.ravel() + 1e-6
        lifetime = np.random.default_rng(int(self.arrangement)).standard_exponential(len(dose)) / dose
        dead = np.argsort(lifetime)[: round(self.strength * len(lifetime))]
        hits.reshape(len(hits), self.place.task.num_features)[:, dead] = False
        return hits


@dataclass(frozen=True)
class AirPressure(Picture):
    """The gain of the gas falls when the air pressure rises, and hits below the discriminator's threshold are missed.
    All cells miss the same share of their hits at a time, but that share changes with the weather.
    """

    name: ClassVar = "inefficiency"
    source: ClassVar = "gas detector with exponential avalanches"

    strength: float = strength(0.005, 0.7)
    """The threshold, in mean avalanches at the usual pressure."""
    weather: float = drawn(0.1, 0.8)
    """Standard deviation of the logarithm of the gain."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        gain = np.exp(self.weather * rng.standard_normal(len(hits)))
        return thinned(hits, np.exp(-self.strength / gain), rng)


@dataclass(frozen=True)
class BusyReadout(Picture):
    """Each hit keeps the read-out of the detector busy for a moment, and what comes meanwhile is missed. Any hit may be
    missed, but the more hits an image has, the larger a share of them.
    """

    name: ClassVar = "inefficiency"
    source: ClassVar = "common read-out bus of a pixel detector"

    strength: float = strength(0.005, 0.8)
    """Time that the read-out is busy with an image of average size, over the time that it is given."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        load = hits.sum(axis=(1, 2)) / max(self.pictures(self.place.reference).sum(axis=(1, 2)).mean(), 1)
        return thinned(hits, 1 / (1 + self.strength * load), rng)


@dataclass(frozen=True)
class AnalogueSum(Image, Selection):
    """The trigger adds up the signals of all cells and starts the read-out if the sum passes a threshold. The sum is
    noisy, so that images with few hits fade out over some range around the threshold.
    """

    name: ClassVar = "threshold"
    source: ClassVar = "energy sum trigger of a calorimeter"

    strength: float = strength(0.006, 0.6)
    """Share of the images with fewer hits than the threshold."""
    noise: float = drawn(0.02, 0.5)
    """Standard deviation of the noise of the sum, in that of the number of hits."""

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        hits = self.pictures(self.place.reference).sum(axis=(1, 2))
        threshold = np.quantile(hits, self.strength)
        width = self.noise * max(hits.std(), 1)
        return ndtr((self.pictures(x).sum(axis=(1, 2)) - threshold) / width)


@dataclass(frozen=True)
class SectorMajority(Image, Selection):
    """The detector is divided into square sectors, and the read-out starts only if enough of them have a hit. Images
    with few hits, or whose hits all lie close together, are never read.
    """

    name: ClassVar = "threshold"
    source: ClassVar = "multiplicity trigger of a scintillator hodoscope"

    strength: float = strength(0.01, 0.6)
    """Share of the images that have too few sectors with a hit, or just as few."""
    side: float = drawn(2, 6, "cells")
    """Of a sector; whole cells count."""

    @cached_property
    def required(self) -> float:
        """Number of sectors that is not yet enough."""
        return float(np.quantile(self.sectors(self.place.reference), self.strength))

    def sectors(self, x: NDArray) -> NDArray[np.int64]:
        """Number of sectors that have a hit: (n, d) -> (n,)."""
        rows, columns = self.shape
        side = int(self.side)
        across = -(-columns // side)
        event, cell = np.divmod(np.flatnonzero(self.pictures(x)), rows * columns)
        touched = np.zeros((len(x), -(-rows // side) * across), bool)
        touched[event, cell // columns // side * across + cell % columns // side] = True
        return touched.sum(axis=1)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return (self.sectors(x) > self.required).astype(float)


FAMILIES: tuple[type[Injection], ...] = (
    BrokenBonds,
    RadiationDeaths,
    AirPressure,
    BusyReadout,
    AnalogueSum,
    SectorMajority,
)
