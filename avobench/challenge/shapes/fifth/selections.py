"""Shapes of continuous features that lose events."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import Selection, drawn, strength
from avobench.challenge.shapes.fifth.scale import OfOne

REMNANT = 0.02
"""Of the events, seen even where the detector is blind: they reach it by a detour."""


def seen(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """A geometric acceptance (n, 1), limited to [0, 1] and with the remnant added: (n,)."""
    return REMNANT + (1 - REMNANT) * np.clip(share[:, 0], 0, 1)


@dataclass(frozen=True)
class SupportRib(OfOne, Selection):
    """A rib that holds the detector hides an interval, and its slanted walls half of what lies beside it."""

    strength: float = strength(0.01, 0.35, "half ranges")
    at: float = drawn(-0.55, 0.55, "half ranges")
    name, source = "dead_region", "Passive material of a support structure"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return seen(np.abs(self.place.scaled(x) - self.at) / self.strength - 1 / 2)


@dataclass(frozen=True)
class BarrelGaps(OfOne, Selection):
    """Where the barrel meets the end caps, cables leave through a gap on either side, where most events are lost."""

    strength: float = strength(0.01, 0.35, "half ranges")
    at: float = drawn(0.45, 0.75, "half ranges")
    name, source = "dead_region", "Service gap between the barrel and the end caps"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        inside = np.abs(np.abs(self.place.scaled(x)) - self.at) < self.strength / 2
        return seen(1 - 0.85 * inside)


@dataclass(frozen=True)
class CollimatorShadow(OfOne, Selection):
    """A collimator throws its half-shadow on one end, deeper the nearer to it, as the source is not a point."""

    strength: float = strength(0.03, 1.2, "half ranges")
    side: float = drawn(1, 1, sign=True)
    name, source = "edge_acceptance", "Penumbra of an aperture in front of an extended source"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return seen((1 - self.side * self.place.scaled(x)) / self.strength)


@dataclass(frozen=True)
class SlantAbsorption(OfOne, Selection):
    """Towards both ends particles cross a wall ever more slantwise, and more of them are absorbed in it."""

    strength: float = strength(0.02, 1.5, "absorption lengths")
    name, source = "edge_acceptance", "Path length in the wall of a cylindrical beam pipe"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        path = 1 / np.sqrt(1 - np.minimum(self.place.scaled(x) ** 2, 0.95))
        return seen(np.exp(-self.strength * (path - 1)))


@dataclass(frozen=True)
class WeakHalf(OfOne, Selection):
    """One half of the detector has lost part of its chambers; around the middle, tracks cross both halves."""

    strength: float = strength(0.02, 0.95, "of the events in that half")
    overlap: float = drawn(0.02, 0.25, "half ranges")
    side: float = drawn(1, 1, sign=True)
    name, source = "forward_backward_acceptance", "Unequal efficiency of the two halves of a tracker"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return seen(1 - self.strength * expit(self.side * self.place.scaled(x) / self.overlap))


FAMILIES = (SupportRib, BarrelGaps, CollimatorShadow, SlantAbsorption, WeakHalf)
