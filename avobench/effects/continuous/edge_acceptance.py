"""Acceptance at the edges: events towards the ends of a range are lost."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

SHARP = 0.002
"""Width of a cut, of half the range: narrower than what events resolve, and smooth in where it is."""
TURN_ON = 0.05
"""Width of a turn-on whose width is not fitted, of half the range: as in the trigger of a detector."""
ANGLE_TURN_ON = 0.2
"""Width of a turn-on in the angle, of the edge's own angle."""
BEYOND = 1.1
"""How far out an edge may lie, in half ranges, where a feature has no end: a cut lies just beyond the range of all but
one in a hundred of what is left."""
# Flatter, or beginning further in, it would be a background, or a forward-backward acceptance, in disguise.
POWER = Parameter("power", 2, 30, None, "1")
STEEP = Parameter("power", 3, 30, None, "1")
ANGLE = Parameter("angle", 0.05, 1.2, None, "rad")
WIDTH = Parameter("width", 0.01, 0.5, None, "of half the range")
WIDTH_BEGUN_AT = 0.1
"""Where a fit of the width begins."""


@dataclass(frozen=True)
class EdgeAcceptance(Acceptance):
    """Events towards the ends of the range are lost: as a power, a turn-on, a cut, or in the angle; one end or both."""

    shape: str = "power"
    name = "edge_acceptance"
    position = 4
    sentence = "The detector records fewer of the events near the edges of its range."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 2"

    def strength(self) -> Parameter:
        return Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        far = 1.0 if self.bounded else BEYOND
        edge = Parameter("edge", 0.2, far, None, "of half the range")
        low, high = replace(edge, name="low", low=-far, high=-0.2), replace(edge, name="high")
        shapes = {
            "power": (POWER,),
            "turn_on": (edge,),
            "cut": (edge,),
            "soft_turn_on": (edge, WIDTH),
            "window": (low, high),
        }
        for side in ("low", "high"):
            shapes |= {f"power_{side}": (STEEP,), f"cut_{side}": (edge,)}
        return shapes | ({"angle": (ANGLE,)} if self.bounded else {})

    def within(self, low, high, column):
        """An interval at one end is taken for what is lost, one about the middle for what is left."""
        ends = self.ranges[column].unit(np.array([low, high]))
        at_end = ends.prod() > 0
        if self.shape == "window":
            return ends if not at_end else np.array([-np.inf, ends[0]] if ends[0] > 0 else [ends[1], np.inf])
        _, edge, *width = self.parameters
        if edge.name != "edge":
            return None
        side = self.shape.rpartition("_")[2]
        inner, outer = np.sort({"low": -ends, "high": ends}.get(side, np.abs(ends)))
        return np.array([inner if at_end and inner > 0 else outer, *[WIDTH_BEGUN_AT for _ in width]])

    def kept(self, x, span, phi):
        return 1 - phi[:, 0] * self._outside(span.unit(x), phi)

    def _outside(self, u, phi):
        """How far beyond the edge events at u (n,) are, from 0 inside to 1, in half ranges from the centre."""
        if self.shape == "window":
            return 1 - ndtr((u - phi[:, 1]) / SHARP) * ndtr((phi[:, 2] - u) / SHARP)
        kind, _, side = self.shape.partition("_")
        if side in ("low", "high"):
            u = u if side == "high" else -u
            at = (1 + np.clip(u, -1, 1)) / 2
        else:
            u = np.abs(u)
            at = np.minimum(u, 1)
        if kind == "power":
            return at ** phi[:, 1]
        if kind == "angle":  # the angle to the nearer pole
            return ndtr((phi[:, 1] - np.arccos(at)) / (ANGLE_TURN_ON * phi[:, 1]))
        width = phi[:, 2] if kind == "soft" else {"cut": SHARP, "turn": TURN_ON}[kind]
        return ndtr((u - phi[:, 1]) / width)
