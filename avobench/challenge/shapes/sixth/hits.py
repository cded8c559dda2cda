"""Hits and images that are lost, and hits that do not belong to the event."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Selection, Simulate, drawn, strength
from avobench.challenge.shapes.places import Image, Picture


class Overlay(Image):
    """Some images are two exposures on one frame."""

    stage = 4
    strength: float

    @property
    def shifted(self) -> int:
        """Columns by which the other exposure lies beside the first."""
        return 0

    @property
    def left(self) -> float:
        """Share of the hits of the other exposure that is left."""
        return 1.0

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        double = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(double):
            other = np.roll(self.pictures(simulate(theta[double], rng)), self.shifted, axis=2)
            other &= rng.random(other.shape, dtype=np.float32) < self.left
            x[double] = np.maximum(x[double], other.reshape(len(double), -1))
        return x


@dataclass(frozen=True)
class UnwoundFilm(Overlay):
    """The film of a bubble chamber was not always wound on. Two events are then on one picture, beside each other
    as far as the film had slipped.
    """

    name = "pile_up"
    source = "double exposures in bubble-chamber films"

    strength: float = strength(0.005, 0.4)
    slip: float = drawn(0, 12, "columns")

    @property
    def shifted(self) -> int:
        return round(self.slip)


@dataclass(frozen=True)
class SlowPixels(Overlay):
    """The pixels are read more slowly than the bunches cross. An image then also holds the hits of an earlier crossing,
    except those that have faded.
    """

    name = "pile_up"
    source = "out-of-time pile-up in slow pixel sensors"

    strength: float = strength(0.005, 0.4)
    remaining: float = drawn(0.5, 1.0)
    """Share of the earlier hits that has not faded."""

    @property
    def left(self) -> float:
        return self.remaining


@dataclass(frozen=True)
class OxygenLeak(Picture):
    """Oxygen leaks into the gas and swallows electrons, so that hits are lost at random all over the detector. At each
    change of the gas it starts from new.
    """

    name = "inefficiency"
    source = "electron attachment in drift chambers"

    strength: float = strength(0.005, 0.35)
    """Share of the hits that is lost on average."""
    refills: float = drawn(1, 8)
    """Changes of the gas during the data taking."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        at = np.nonzero(hits)
        loss = 2 * self.strength * (at[0] / len(hits) * self.refills % 1)
        lost = rng.random(len(loss)) < loss
        hits[tuple(index[lost] for index in at)] = False
        return hits


@dataclass(frozen=True)
class LostPackets(Picture):
    """The hits leave the detector in packets, one for several cells beside each other. Some packets are lost on the
    network, whichever cells they come from.
    """

    name = "inefficiency"
    source = "packet loss in triggerless readout networks"

    strength: float = strength(0.005, 0.35)
    """Share of the packets that is lost."""
    size: float = drawn(2, 9, "columns")
    """Of a packet, rounded down."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        packet = np.arange(self.shape[1]) // int(self.size)
        arrives = rng.random((*hits.shape[:2], packet[-1] + 1), dtype=np.float32) >= self.strength
        return hits & arrives[:, :, packet]


@dataclass(frozen=True)
class DewarTemperature(Picture):
    """Charge set free by heat makes cells fire anywhere on the sensor. How many differs with its temperature, which is
    not the same from image to image.
    """

    name = "random_noise"
    source = "dark current of cooled image sensors"
    stage = 4

    strength: float = strength(0.05, 5.0, "hits")
    """Mean number of such hits."""
    spread: float = drawn(0.1, 0.8)
    """Of its logarithm."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        factor = np.exp(self.spread * rng.standard_normal(len(hits)) - self.spread**2 / 2)
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength * factor))
        rows, columns = (rng.integers(size, size=len(event)) for size in self.shape)
        hits[event, rows, columns] = True
        return hits


@dataclass(frozen=True)
class RadonProgeny(Picture):
    """Radon in the air leaves its decay products on the detector. Each alpha particle lights a random cell, and often
    some of the four cells beside it.
    """

    name = "random_noise"
    source = "alpha particles of radon progeny in track detectors"
    stage = 4

    strength: float = strength(0.03, 2.5)
    """Mean number of alpha particles in an image."""
    halo: float = drawn(0.1, 0.6)
    """Probability of a cell beside to be lit too."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength, len(hits)))
        row, column = rng.integers(rows, size=len(event)), rng.integers(columns, size=len(event))
        hits[event, row, column] = True
        for up, across in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            lit = (rng.random(len(event)) < self.halo) & (row + up >= 0) & (row + up < rows)
            hits[event[lit], row[lit] + up, (column[lit] + across) % columns] = True
        return hits


@dataclass(frozen=True)
class ClusterCleaning(Picture):
    """The readout drops small clusters as probable noise: a hit with no other one beside it is often thrown away, and a
    hit with a single neighbour sometimes.
    """

    name = "threshold"
    source = "minimum cluster size in pixel readout"
    stage = 3

    strength: float = strength(0.01, 1.0)
    """Share of the single hits that is dropped."""
    pairs: float = drawn(0.0, 0.5)
    """Of hits with one neighbour, relative to that."""

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        near = np.pad(hits.astype(np.uint8), ((0, 0), (1, 1), (0, 0)))
        near = near[:, :-2] + near[:, 1:-1] + near[:, 2:]
        near = near + np.roll(near, 1, axis=2) + np.roll(near, -1, axis=2)
        at = np.nonzero(hits)
        dropped = rng.random(len(at[0])) < self.strength * np.array([0, 1, self.pairs, *[0] * 7])[near[at]]
        hits[tuple(index[dropped] for index in at)] = False
        return hits


@dataclass(frozen=True)
class OppositeSectors(Image, Selection):
    """The trigger wants enough hits in both of two opposite halves of the detector. Images with little in either half
    are lost.
    """

    name = "threshold"
    source = "back-to-back sector triggers at electron-positron colliders"

    strength: float = strength(0.5, 6.0, "hits")
    """In a half, where the trigger comes to fire."""
    sharpness: float = drawn(2, 6)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        halves = self.pictures(x).reshape(len(x), self.shape[0], 2, -1).sum(axis=(1, 3))
        return (-np.expm1(-((halves / self.strength) ** self.sharpness))).prod(axis=1)
