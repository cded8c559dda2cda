"""Events lost by where in the range of a real feature they lie."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import drawn, strength
from avobench.challenge.shapes.places import Along


@dataclass(frozen=True)
class SurfaceLoss(Along):
    """Close to either face of the crystal the charge recombines before it is collected. Events near both edges of the
    range are lost, the more the closer.

    The loss falls exponentially with the depth below the face.
    """

    strength: float = strength(0.1, 1)
    """Probability to be lost at the face."""
    depth: float = drawn(0.08, 0.3, "half range", log=True)

    name = "edge_acceptance"
    source = "surface recombination in a semiconductor detector"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * np.exp(-np.maximum(1 - np.abs(s), 0) / self.depth)


@dataclass(frozen=True)
class Horizon(Along):
    """One end of the range is at the horizon, where light crosses much air. Few of the events there are bright enough
    to be recorded, while overhead nothing changes.

    The loss is exponential in the air mass, the inverse sine of the altitude.
    """

    strength: float = strength(0.01, 0.4, "optical depth")
    """Of the air overhead."""
    end: float = drawn(1, 1, sign=True)
    """Which end of the range is at the horizon."""

    name = "edge_acceptance"
    source = "atmospheric extinction in a sky survey"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        altitude = np.pi / 4 * np.clip(1 - self.end * s, 0.03, 2)
        return np.exp(-self.strength * (1 / np.sin(altitude) - 1))


@dataclass(frozen=True)
class TiredHalf(Along):
    """The chambers of one half of the detector run at a lower voltage and miss a share of the events. In the zone where
    the halves overlap, the loss sets in gradually."""

    strength: float = strength(0.03, 0.6)
    """Share lost in the tired half."""
    overlap: float = drawn(0.02, 0.25, "half range", log=True)
    """Half of the width of the zone where the halves overlap."""
    half: float = drawn(1, 1, sign=True)

    name = "forward_backward_acceptance"
    source = "two half-shells of a muon spectrometer"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * np.clip((self.half * s / self.overlap + 1) / 2, 0, 1)


@dataclass(frozen=True)
class OneEndReadout(Along):
    """A long scintillator bar is read out at one end only, and its light is absorbed on the way. The half far from the
    readout records fewer events than the near half.

    The efficiency falls exponentially along the whole bar.
    """

    strength: float = strength(0.08, 1.2, "absorption lengths")
    """Length of the bar."""
    far: float = drawn(1, 1, sign=True)
    """Which end of the range is far from the readout."""

    name = "forward_backward_acceptance"
    source = "light attenuation in scintillator bars"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(-self.strength * np.clip(1 + self.far * s, 0, 2) / 2)


@dataclass(frozen=True)
class PillarShadow(Along):
    """A pillar stands between the source and a part of the detector. Nothing is recorded in its full shadow, and less
    than usual in the half-shadow at both sides."""

    strength: float = strength(0.004, 0.15, "half range")
    """Half of the width of the full shadow."""
    position: float = drawn(-0.55, 0.55, "half range")
    penumbra: float = drawn(0.2, 1)
    """Width of the half-shadow on each side over `strength`."""

    name = "dead_region"
    source = "support structure in front of a detector"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip((np.abs(s - self.position) / self.strength - 1) / self.penumbra, 0, 1)


@dataclass(frozen=True)
class AbsorptionLine(Along):
    """A gas in the light path absorbs around one wavelength. Events there are lost, in the middle of a strong line all
    of them.

    The absorption follows the law of Beer and Lambert with a Lorentzian line.
    """

    strength: float = strength(0.07, 4, "optical depth")
    """In the middle of the line."""
    position: float = drawn(-0.55, 0.55, "half range")
    width: float = drawn(0.03, 0.1, "half range", log=True)
    """Half width at half maximum of the optical depth."""

    name = "dead_region"
    source = "telluric lines in spectra"

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(-self.strength / (1 + ((s - self.position) / self.width) ** 2))
