"""Where events of continuous features are lost: edges, one half, a region."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc, expit, ndtr

from avobench.challenge.shapes.contract import Place, Selection, drawn, strength


@dataclass(frozen=True)
class ErfTurnOn(Selection):
    """Events near both ends of the range are lost, with the error function of a resolution at the detector's rim."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "the usual erf turn-on of trigger and acceptance efficiencies"
    strength: float = strength(0.05, 0.95, "share lost at the edge")
    begin: float = drawn(0.7, 0.95, "half ranges")
    width: float = drawn(0.03, 0.12, "half ranges")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        distance = (self.begin - np.abs(self.place.scaled(x))) / self.width
        return (1 - self.strength * erfc(distance / np.sqrt(2)) / 2).prod(axis=1)


@dataclass(frozen=True)
class BeamPipe(Selection):
    """Particles at small angles to the beam escape through the beam pipe; the turn-on is logistic in the angle."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "acceptance of collider detectors, given in the polar angle"
    strength: float = strength(0.05, 0.6, "rad")
    width: float = drawn(0.01, 0.1, "rad")

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.cosine

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        angle = np.arccos(np.clip(np.abs(x[:, self.place.columns]), 0, 1))
        return expit((angle - self.strength) / self.width).prod(axis=1)


@dataclass(frozen=True)
class RimLoss(Selection):
    """Events are lost near both ends of the range, ever fewer away from them: showers that leak out at the rim."""

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "lateral leakage of showers, exponential in the distance from the rim"
    strength: float = strength(0.05, 0.95, "share lost at the edge")
    depth: float = drawn(0.05, 0.2, "half ranges")

    @classmethod
    def suits(cls, place: Place) -> bool:
        return not place.cosine

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        distance = np.clip(1 - np.abs(self.place.scaled(x)), 0, None)
        return (1 - self.strength * np.exp(-distance / self.depth)).prod(axis=1)


@dataclass(frozen=True)
class TwoHalves(Selection):
    """One half of the detector is less efficient than the other, with a soft passage between them."""

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "detectors built as two half shells"
    strength: float = strength(0.02, 0.6, "share lost", sign=True)
    width: float = drawn(0.02, 0.15, "half ranges")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return (1 - abs(self.strength) * ndtr(np.sign(self.strength) * self.place.scaled(x) / self.width)).prod(axis=1)


@dataclass(frozen=True)
class FadingSide(Selection):
    """The efficiency falls from one end of the range to the other, most steeply in the middle."""

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "radiation damage and attenuation that grow along a detector"
    strength: float = strength(0.02, 0.6, "share lost", sign=True)
    width: float = drawn(0.4, 1.5, "half ranges")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return (1 - abs(self.strength) * expit(4 * np.sign(self.strength) * self.place.scaled(x) / self.width)).prod(
            axis=1
        )


@dataclass(frozen=True)
class SoftGap(Selection):
    """A gap in the range where most events are lost, with washed-out sides and something left at its bottom."""

    name: ClassVar = "dead_region"
    source: ClassVar = "cracks between detector modules"
    strength: float = strength(0.01, 0.25, "half ranges, half the gap's width")
    location: float = drawn(-0.8, 0.8, "half ranges")
    side: float = drawn(0.1, 0.5, "half the gap's width")
    residual: float = drawn(0, 0.4)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        u = (self.place.scaled(x) - self.location) / self.strength
        inside = ndtr((u + 1) / self.side) * ndtr((1 - u) / self.side)
        return (1 - (1 - self.residual) * inside).prod(axis=1)
