"""A turn-on: to one side of a feature the efficiency rises gradually, over a width of its own."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

CURVES = {
    "erf": lambda beyond, phi: ndtr(beyond / phi[:, 2]),
    "exponential": lambda beyond, phi: -np.expm1(-np.maximum(beyond, 0) / phi[:, 2]),
    "rise": lambda beyond, phi: np.clip(beyond / phi[:, 1], 0, 1) ** phi[:, 2],
}
"""By shape: the efficiency, from 0 to 1, so far (n,) beyond where it begins, or of `erf` is half."""
POWER = Parameter("power", 0.3, 5, None, "1")
NARROW = 0.01
"""The least width, in half ranges: to the data a narrower turn-on is a sharp edge."""
WIDE = 1.0
"""The largest: one width to either side of its middle is as much as the range."""
FARTHEST = 0.8
"""Of half the range, beyond the middle: how far in a turn-on may begin."""
OUTSIDE = 0.25
"""The same beyond the end: the range that the data show begins within a turn-on."""


@dataclass(frozen=True)
class TurnOn(Acceptance):
    """Fewer events are recorded towards one end: as an error function, an exponential, or a power from the end on.

    The other shapes of an edge acceptance are sharp or act at both ends; these have one side and a free width.
    """

    shape: str = "erf_low"
    on_all = False
    name = "edge_acceptance"
    position = 20
    sentence = "The efficiency rises gradually along a feature, as that of a trigger above its threshold."
    source = "ATLAS Collaboration, Eur. Phys. J. C 77 (2017) 317, Section 6"

    def strength(self) -> Parameter:
        return Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        shapes = {}
        width = Parameter("width", NARROW * self.half, WIDE * self.half, None, "of the feature")
        length = Parameter("length", NARROW * self.half, 2 * self.half, None, "of the feature")
        for side in ("low", "high"):
            ends = np.array([-1 - OUTSIDE, FARTHEST]) if side == "low" else np.array([-FARTHEST, 1 + OUTSIDE])
            at = Parameter("at", *((self.low + self.high) / 2 + self.half * ends).tolist(), None, "of the feature")
            shapes |= {f"{curve}_{side}": (at, width) for curve in ("erf", "exponential")}
            shapes[f"rise_{side}"] = (length, POWER)
        return shapes

    def within(self, low, high, column):
        curve, _, side = self.shape.partition("_")
        if curve == "rise":
            return np.array([high - self.low if side == "low" else self.high - low, 1.0])
        if curve == "erf":
            return np.array([(low + high) / 2, (high - low) / 2])
        return np.array([low if side == "low" else high, high - low])

    def kept(self, x, span, phi):
        curve, _, side = self.shape.partition("_")
        begins = phi[:, 1] if curve != "rise" else span.low if side == "low" else span.high
        beyond = x - begins if side == "low" else begins - x
        return 1 - phi[:, 0] * (1 - CURVES[curve](beyond, phi))
