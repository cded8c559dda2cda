"""Events that are lost by where in its range a feature lies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from avobench.challenge.shapes.contract import drawn, strength
from avobench.challenge.shapes.places import Along


@dataclass(frozen=True)
class Vignetting(Along):
    """The tube of a telescope shades its mirror from what comes in at an angle. Both ends of the field lose light as
    two circles move apart.
    """

    name = "edge_acceptance"
    source = "vignetting of wide-field telescopes"

    strength: float = strength(0.05, 1.0)
    """Share of the light that is shaded at the ends."""
    clear: float = drawn(0.2, 0.8)
    """Half width of the field that is not shaded."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        apart = np.clip((np.abs(s) - self.clear) / (1 - self.clear), 0, 1)
        overlap = 2 / np.pi * (np.arccos(apart) - apart * np.sqrt(1 - apart**2))
        return 1 - self.strength * (1 - overlap)


@dataclass(frozen=True)
class HorizonExtinction(Along):
    """Light from near the horizon crosses much more air than light from above. At that end of the range events are
    absorbed.
    """

    name = "edge_acceptance"
    source = "atmospheric extinction at large air mass"

    strength: float = strength(0.01, 0.6)
    """Optical depth of one air mass."""
    haze: float = drawn(0.05, 0.2, sign=True)
    """At which end the horizon lies, and the height up to which the air mass stays finite."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        height, haze = np.clip((1 + np.sign(self.haze) * s) / 2, 0, 1), abs(self.haze)
        return np.exp(-self.strength * ((1 + haze) / (height + haze) - 1))


@dataclass(frozen=True)
class OneEndReadout(Along):
    """Long bars are read out at one end only. From their far half too little light arrives for some of the events to
    be seen, and the step between the halves is smooth.
    """

    name = "forward_backward_acceptance"
    source = "attenuation in single-ended scintillator bars"

    strength: float = strength(0.02, 0.8)
    """Share lost in the far half."""
    width: float = drawn(0.03, 0.25, "half ranges", sign=True)
    """Of the step; its sign says which half is far."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 - self.strength * expit(s / self.width)


@dataclass(frozen=True)
class WindwardDust(Along):
    """Dust settles on the windward half of a dome and takes light away there, little at the ridge and more towards the
    rim; the other half stays clean.
    """

    name = "forward_backward_acceptance"
    source = "soiling of fluorescence telescopes and glass domes"

    strength: float = strength(0.03, 0.9)
    """Share lost at the rim."""
    rise: float = drawn(0.1, 0.6, sign=True)
    """Power with which the loss rises from the ridge; its sign says which half is windward."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        windward = np.clip(np.sign(self.rise) * s, 0, 1)
        return 1 - self.strength * windward ** abs(self.rise)


@dataclass(frozen=True)
class DustLane(Along):
    """A lane of dust crosses the field and absorbs what lies behind it, most along its middle and ever less to both
    sides.
    """

    name = "dead_region"
    source = "absorption in the plane of the Galaxy"

    strength: float = strength(0.1, 4.0)
    """Optical depth along the middle."""
    at: float = drawn(-0.6, 0.6, "half ranges")
    width: float = drawn(0.04, 0.15, "half ranges")
    """Scale height of the dust."""

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        height = np.clip((s - self.at) / self.width, -20, 20)
        return np.exp(-self.strength / np.cosh(height) ** 2)


@dataclass(frozen=True)
class RoundBeamStop(Along):
    """A round stop catches the direct beam before it burns the detector. Seen from the side its shadow is deepest in
    the middle and vanishes at its rim as a chord of a circle does.
    """

    name = "dead_region"
    source = "beam stops in small-angle scattering"

    strength: float = strength(0.1, 1.0)
    """Share lost in the middle."""
    at: float = drawn(-0.5, 0.5, "half ranges")
    radius: float = drawn(0.06, 0.25, "half ranges")

    def transmission(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        chord = np.sqrt(np.maximum(1 - ((s - self.at) / self.radius) ** 2, 0))
        return 1 - self.strength * chord
