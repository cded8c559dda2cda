"""Acceptance: events are lost depending on where they lie."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

LEP = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, "
LOSS = Parameter("lost", 0, 1, 0, "1")
SHARP = 0.002
"""Width of a cut, of half the range: narrower than what events resolve, and smooth in where it is."""


@dataclass(frozen=True)
class EdgeAcceptance(Acceptance):
    """Events towards the ends of the range are lost: as a power, a turn-on, a cut, or in the angle; one end or both."""

    shape: str = "power"
    name = "edge_acceptance"
    sentence = "The detector records fewer of the events near the edges of its range."
    source = LEP + "Section 2"

    def strength(self) -> Parameter:
        return LOSS

    def variants(self):
        # Flatter, or beginning further in, it would be a background, or a forward-backward acceptance, in disguise.
        power = Parameter("power", 2, 30, None, "1")
        steep = Parameter("power", 3, 30, None, "1")
        # A cut in a feature without an end lies just beyond the range of all but one in a hundred of what is left.
        far = 1.0 if self.bounded else 1.1
        edge = Parameter("edge", 0.2, far, None, "of half the range")
        low, high = replace(edge, name="low", low=-far, high=-0.2), replace(edge, name="high")
        width = Parameter("width", 0.01, 0.5, None, "of half the range")
        shapes = {
            "power": (power,),
            "turn_on": (edge,),
            "cut": (edge,),
            "soft_turn_on": (edge, width),
            "window": (low, high),
        }
        for side in ("low", "high"):
            shapes |= {f"power_{side}": (steep,), f"turn_on_{side}": (edge,), f"cut_{side}": (edge,)}
        if self.bounded:
            shapes["angle"] = (Parameter("angle", 0.05, 1.2, None, "rad"),)
        return shapes

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
        return np.array([inner if at_end and inner > 0 else outer, *[0.1 for _ in width]])

    def kept(self, x, span, phi):
        u, loss = span.unit(x), phi[:, 0]
        if self.shape == "window":
            return 1 - loss * (1 - ndtr((u - phi[:, 1]) / SHARP) * ndtr((phi[:, 2] - u) / SHARP))
        kind, _, side = self.shape.partition("_")
        if side in ("low", "high"):
            u = u if side == "high" else -u
            at = (1 + np.clip(u, -1, 1)) / 2
        else:
            u = np.abs(u)
            at = np.minimum(u, 1)
        if kind == "power":
            return 1 - loss * at ** phi[:, 1]
        if kind == "angle":  # the angle to the nearer pole, with a turn-on of a fifth of the edge's own angle
            return 1 - loss * ndtr((phi[:, 1] - np.arccos(at)) / (0.2 * phi[:, 1]))
        width = phi[:, 2] if kind == "soft" else {"cut": SHARP, "turn": 0.05}[kind]
        return 1 - loss * ndtr((u - phi[:, 1]) / width)


@dataclass(frozen=True)
class ForwardBackwardAcceptance(Acceptance):
    """One half of the range is recorded better than the other: along a line, a step, or a smooth step."""

    shape: str = "linear"
    name = "forward_backward_acceptance"
    sentence = "The detector records one side better than the other."
    source = LEP + "Section 5"

    def strength(self) -> Parameter:
        return Parameter("asymmetry", -0.95, 0.95, 0, "1")

    def variants(self):
        return {"linear": (), "step": (), "smooth": (Parameter("width", 0.05, 1, None, "of half the range"),)}

    def kept(self, x, span, phi):
        u, a = span.unit(x), phi[:, 0]
        side = {
            "linear": lambda: np.clip(u, -1, 1),
            "step": lambda: np.sign(u),
            "smooth": lambda: np.tanh(u / phi[:, 1]),
        }[self.shape]()
        return (1 + a * side) / (1 + np.abs(a))


@dataclass(frozen=True)
class DeadRegion(Acceptance):
    """Events in one region are lost: all of it alike, or most at its middle."""

    shape: str = "box"
    name = "dead_region"
    sentence = "A part of the detector does not record."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"

    def strength(self) -> Parameter:
        return LOSS

    def variants(self):
        place = self.place(0.02, 0.8)
        return {"box": place, "dip": place}

    def within(self, low, high, column):
        low, high = self.placed(np.array([low, high]), self.ranges[column])
        return np.array([(low + high) / 2, high - low])

    def kept(self, x, span, phi):
        distance = np.abs(self.placed(x, span) - phi[:, 1]) / phi[:, 2]
        return 1 - phi[:, 0] * (distance < 0.5 if self.shape == "box" else np.exp(-6 * distance**2))
