"""Effects by which events are lost, with a chance that depends on a feature."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import ndtr

from avobench.effects.continuous.ends import SIDES, sharp_end
from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

SHARP = 0.002
"""Width of a cut, of half the range: narrower than what events resolve, and smooth in where it is."""
TURN_ON = 0.05
"""Width of a turn-on whose width is not fitted, of half the range: as in the trigger of a detector."""
ANGLE_TURN_ON = 0.2
"""Width of a turn-on in the angle, of the edge's own angle."""
FARTHEST_EDGE = 1.1
"""How far out an edge may lie, in half ranges, where a feature has no end."""
WIDTH_BEGUN_AT = 0.1
"""Where a fit of the width of a soft turn-on begins."""
OUTERMOST = 0.05
"""Share of half the range that is recorded at least on either side of a dead region; else it is an edge acceptance."""
NARROW = 0.01
"""The least width of a turn-on, in half ranges: to the data a narrower one is a sharp edge."""
WIDE = 1.0
"""The largest: one width to either side of its middle is as much as the range."""
FARTHEST = 0.8
"""How far in a turn-on may begin: this share of half the range beyond the middle."""
OUTSIDE = 0.25
"""How far out a turn-on may begin, in half ranges beyond the end: the range that the data show begins within it."""
BEYOND = 0.01
"""Least distance, in half ranges, from a limit that the data show to the end at which a truncation is absent."""
INSIDE = 0.05
"""How far within such a limit a fit may look for it, in half ranges."""
CENTRES = 0.25
"""How far from the middle of the range the window may lie, in half ranges, where the data do not show it."""


@dataclass(frozen=True)
class EdgeAcceptance(Acceptance):
    """Events towards the ends of the range are lost: as a power, a turn-on, a cut, or in the angle; one end or both."""

    shape: str = "power"
    name = "edge_acceptance"
    position = 4
    sentence = "The detector records fewer of the events near the edges of its range."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 2"
    STRENGTH = Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        far = 1.0 if self.bounded else FARTHEST_EDGE
        edge = Parameter("edge", 0.2, far, None, "of half the range")
        low, high = replace(edge, name="low", low=-far, high=-0.2), replace(edge, name="high")
        # A flatter power, or one that begins further in, would be a background or a forward-backward acceptance.
        shapes = {
            "power": (Parameter("power", 2, 30, None, "1"),),
            "turn_on": (edge,),
            "cut": (edge,),
            "soft_turn_on": (edge, Parameter("width", 0.01, 0.5, None, "of half the range")),
            "window": (low, high),
        }
        for side in ("low", "high"):
            shapes |= {f"power_{side}": (Parameter("power", 3, 30, None, "1"),), f"cut_{side}": (edge,)}
        return shapes | ({"angle": (Parameter("angle", 0.05, 1.2, None, "rad"),)} if self.bounded else {})

    def within(self, low, high, column):
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


HALVES = {
    "linear": lambda u, phi: np.clip(u, -1, 1),
    "step": lambda u, phi: np.sign(u),
    "smooth": lambda u, phi: np.tanh(u / phi[:, 1]),
    "growing": lambda u, phi: (s := np.sign(phi[:, 0])) * (1 - 2 * np.clip(-s * u, 0, 1) ** phi[:, 1]),
}
"""The side to which events at u (n,), in half ranges from the centre, belong, from -1 to 1, by shape."""


@dataclass(frozen=True)
class ForwardBackwardAcceptance(Acceptance):
    """One half of the range is recorded better than the other: along a line, a step, or a smooth step.

    In the shape `growing` one half loses nothing, and the other the more the nearer to its end.
    """

    shape: str = "linear"
    name = "forward_backward_acceptance"
    position = 5
    sentence = "The detector records one side better than the other."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"
    STRENGTH = Parameter("asymmetry", -0.95, 0.95, 0, "1")
    SHAPES: ClassVar = {
        "linear": (),
        "step": (),
        "smooth": (Parameter("width", 0.05, 1, None, "of half the range"),),
        "growing": (Parameter("power", 0.3, 3, None, "1"),),
    }

    def kept(self, x, span, phi):
        asymmetry = phi[:, 0]
        return (1 + asymmetry * HALVES[self.shape](span.unit(x), phi)) / (1 + np.abs(asymmetry))


LOST = {"box": lambda distance: distance < 0.5, "dip": lambda distance: np.exp(-6 * distance**2)}
"""The share that is lost at a distance (n,) from the middle, in widths, by shape."""


@dataclass(frozen=True)
class DeadRegion(Acceptance):
    """Events in one region are lost: all of it alike, or most at its middle. It has events on both sides."""

    shape: str = "box"
    name = "dead_region"
    position = 8
    sentence = "A part of the detector does not record."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"
    STRENGTH = Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        place = self.place(0.02, 0.8)
        return {shape: place for shape in LOST}

    def within(self, low, high, column):
        low, high = self.placed(np.array([low, high]), self.ranges[column])
        return np.array([(low + high) / 2, high - low])

    def kept(self, x, span, phi):
        _, centre, width = phi.T
        if not span.periodic:
            low, high = self.placed(np.array([span.low, span.high]), span)
            free = (low + OUTERMOST * (high - low) / 2 + width / 2, high - OUTERMOST * (high - low) / 2 - width / 2)
            centre = np.clip(centre, *free)
        distance = np.abs(self.placed(x, span) - centre) / width
        return 1 - phi[:, 0] * LOST[self.shape](distance)


CURVES = {
    "erf": lambda beyond, phi: ndtr(beyond / phi[:, 2]),
    "exponential": lambda beyond, phi: -np.expm1(-np.maximum(beyond, 0) / phi[:, 2]),
    "rise": lambda beyond, phi: np.clip(beyond / phi[:, 1], 0, 1) ** phi[:, 2],
}
"""The efficiency, from 0 to 1, at a distance (n,) beyond where it begins, or for `erf` where it is half, by shape."""


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
    STRENGTH = Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        shapes = {}
        width = Parameter("width", NARROW * self.half, WIDE * self.half, None, "of the feature")
        length = Parameter("length", NARROW * self.half, 2 * self.half, None, "of the feature")
        for side in ("low", "high"):
            ends = np.array([-1 - OUTSIDE, FARTHEST]) if side == "low" else np.array([-FARTHEST, 1 + OUTSIDE])
            at = Parameter("at", *((self.low + self.high) / 2 + self.half * ends).tolist(), None, "of the feature")
            shapes |= {f"{curve}_{side}": (at, width) for curve in ("erf", "exponential")}
            shapes[f"rise_{side}"] = (length, Parameter("power", 0.3, 5, None, "1"))
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


@dataclass(frozen=True)
class Truncation(Acceptance):
    """Every event beyond a limit is lost: below it, or above. A fit is tried where the data end sharply.

    The strength is the limit, which at the end of the range is none. Where only a share is lost, both ends lose alike,
    or the loss is gradual, it is another shape of an edge acceptance. Of an exponential a limit below is an `offset`,
    exactly: what is left begins later, and is as steep.
    """

    shape: str = "truncated_below"
    limits: tuple[float | None, float | None] = (None, None)
    """The limits that the data show below and above."""
    on_all = False
    name = "edge_acceptance"
    position = 21
    sentence = "Values beyond a limit are not in the sample, as below a threshold."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"
    SHAPES: ClassVar = {f"truncated_{side}": () for side in SIDES}

    @property
    def limit(self) -> float | None:
        return self.limits[self.shape == "truncated_above"]

    def strength(self) -> Parameter:
        sign, end = (1, self.low) if self.shape == "truncated_below" else (-1, self.high)
        far = (self.low + self.high) / 2
        if self.limit is not None:
            end = sign * min(sign * end, sign * self.limit - BEYOND * self.half)
            far = self.limit + sign * INSIDE * self.half
        return Parameter("limit", min(end, far), max(end, far), end, "of the feature")

    def adapted(self, x):
        return replace(self, limits=tuple(sharp_end(x[:, self.feature], side) for side in SIDES))

    def guess(self, x):
        limit = (self if self.limits != (None, None) else self.adapted(x)).limit
        return np.empty((0, 1)) if limit is None else np.array([[limit]])

    def kept(self, x, span, phi):
        limit = phi[:, 0]
        within = x >= limit if self.shape == "truncated_below" else x <= limit
        return (within | (limit == self.strength().null)).astype(float)


@dataclass(frozen=True)
class AnalysisWindow(Acceptance):
    """Events outside a window in one feature are lost. A fit is tried where the data end sharply, on one side or both.

    It acts after all else: what a smearing moves out of the window is lost too, and what it moves in is kept. By itself
    it cannot be told from a truncation where one end alone cuts anything, nor from the shape `window`.
    """

    shape: str = "analysis_window"
    window: tuple[float, float] | None = None
    """The range that the data show."""
    stage = 5
    on_all = False
    name = "edge_acceptance"
    position = 23
    sentence = "Only events within a window are in the sample, after everything else."
    source = "V. Blobel, in: Data Analysis in High Energy Physics, ed. O. Behnke et al. (2013), Chapter 6"

    def _place(self) -> tuple[float, float, float, float]:
        """The least and the largest centre of the window, its least width, and the width that covers everything."""
        middle = (self.low + self.high) / 2
        if self.window is None:
            off = CENTRES * self.half
            return middle - off, middle + off, self.half, 2 * (self.half + off)
        (low, high), off = self.window, INSIDE * self.half
        left, right = (low + high) / 2 - off, (low + high) / 2 + off
        reach = max(right - self.low, self.high - left, (high - low) / 2 + off) + BEYOND * self.half
        return left, right, (high - low) - 2 * off, 2 * reach

    def strength(self) -> Parameter:
        _, _, narrow, wide = self._place()
        return Parameter("width", max(narrow, 0.0), wide, wide, "of the feature")

    def variants(self):
        left, right, *_ = self._place()
        return {self.shape: (Parameter("centre", left, right, None, "of the feature"),)}

    def adapted(self, x):
        column = x[:, self.feature]
        sharp = any(sharp_end(column, side) is not None for side in SIDES)
        return replace(self, window=(float(column.min()), float(column.max())) if sharp else None)

    def guess(self, x):
        window = (self if self.window else self.adapted(x)).window
        return np.empty((0, 2)) if window is None else np.array([[window[1] - window[0], sum(window) / 2]])

    def kept(self, x, span, phi):
        width = phi[:, 0]
        return ((np.abs(x - phi[:, 1]) <= width / 2) | (width == self.strength().null)).astype(float)
