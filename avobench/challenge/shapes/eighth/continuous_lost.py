"""Events that are lost by where in the range of a real feature they lie."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, drawn, strength
from avobench.challenge.shapes.places import Along


@dataclass(frozen=True)
class NaturalVignetting(Along):
    """Light that comes in aslant meets a smaller opening and a farther screen, so less of it arrives. Events towards
    both ends of the range are lost by the fourth power of the cosine of the slant.
    """

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "cosine-fourth law of wide-angle optics"

    strength: float = strength(0.12, 1.2)
    """Tangent of the slant at the ends of the range."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return (1 + (self.strength * s) ** 2) ** -2.0


@dataclass(frozen=True)
class CollimatorJaw(Along):
    """A jaw of the collimator stands too far in and covers one end of the range. Beyond the full shadow there is a half
    shadow in which the recorded share rises linearly to all.
    """

    name: ClassVar = "edge_acceptance"
    source: ClassVar = "collimator of an X-ray beam line"

    strength: float = strength(0.008, 0.6, "half_range")
    """How far into the range full and half shadow reach."""
    half_shadow: float = drawn(0.1, 0.8)
    """Share of that which is half shadow."""
    side: float = drawn(1, 1, sign=True)

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        free = (1 - np.sign(self.side) * s) / self.strength
        return np.clip(1 - (1 - free) / self.half_shadow, 0, 1)


@dataclass(frozen=True)
class LowVoltageHalf(Along):
    """The chambers of one half of the detector run at a lower voltage than those of the other and miss a part of the
    particles. Where the halves overlap, the efficiency goes over from one to the other.
    """

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "end caps of a muon spectrometer"

    strength: float = strength(0.02, 0.6)
    """Share that the worse half misses."""
    overlap: float = drawn(0.03, 0.3, "half_range", log=True)
    side: float = drawn(1, 1, sign=True)

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * (1 - np.tanh(np.sign(self.side) * s / self.overlap)) / 2


@dataclass(frozen=True)
class WedgeAbsorber(Along):
    """A wedge of material lies before the detector, thin on one side and thick on the other. Particles are absorbed
    exponentially in its thickness, so that one half of the range is recorded better than the other.
    """

    name: ClassVar = "forward_backward_acceptance"
    source: ClassVar = "heel effect of an X-ray tube"

    strength: float = strength(0.04, 1.2)
    """Absorption lengths at the thick end."""
    side: float = drawn(1, 1, sign=True)

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(-self.strength * np.clip((1 - np.sign(self.side) * s) / 2, 0, 1))


@dataclass(frozen=True)
class BurnedSpot(Along):
    """The direct beam once hit the detector and damaged it around one spot. Fewer events are recorded there, the fewest
    at the middle of the spot.
    """

    name: ClassVar = "dead_region"
    source: ClassVar = "photocathode after an exposure to the direct beam"

    strength: float = strength(0.06, 1)
    """Share lost at the middle of the spot."""
    spot: float = drawn(-0.6, 0.6, "half_range")
    width: float = drawn(0.06, 0.15, "half_range", log=True)

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * np.exp(-(((s - self.spot) / self.width) ** 2) / 2)


@dataclass(frozen=True)
class CracksBetweenModules(Along):
    """The detector consists of three modules in a row, and nothing is sensitive in the cracks between them. Events that
    fall into one of the two cracks are not recorded.
    """

    name: ClassVar = "dead_region"
    source: ClassVar = "cracks between barrel and end caps of a calorimeter"

    strength: float = strength(0.004, 0.2, "half_range")
    """Width of a crack."""
    module: float = drawn(0.2, 0.7, "half_range")
    """Half of the length of the middle module."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return (np.abs(np.abs(s) - self.module) > self.strength / 2).astype(float)


FAMILIES: tuple[type[Injection], ...] = (
    NaturalVignetting,
    CollimatorJaw,
    LowVoltageHalf,
    WedgeAbsorber,
    BurnedSpot,
    CracksBetweenModules,
)
