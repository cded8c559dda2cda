"""Calibration: a value is recorded shifted, stretched, mixed with others, in steps, or cut."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effects.base import Parameter
from avobench.diagnosis.effects.continuous.base import Change

LEO = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), "
REPEATED = 5
"""So many equal values of a continuous feature are no chance."""
LEAST_LEVELS, MOST_LEVELS = 4, 1000
"""Fewer repeated values are no bins, more are a fine rounding."""
KNOWN = 1e-9
"""Relative error of a step that is read off the data."""
ENDS = {"above": (False, True), "both": (True, True), "below": (True, False)}
"""Whether values are cut at the lower and at the upper end."""


CALIBRATED = 0.03
"""A scale is known to some per cent as a rule; where the far ends of a range seem squeezed by more, they may be cut."""


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted."""

    shape: str = "plain"
    name = "offset"
    sentence = "The zero of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        high = 0.7 if self.shape == "angle" else 0.7 * self.half
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]


@dataclass(frozen=True)
class Scale(Change):
    """Every value is stretched: about zero, about the centre of the angle, or more the larger it is."""

    shape: str = "linear"
    name = "scale"
    sentence = "The unit of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        return Parameter("stretch", -0.5, 0.5, 0, "1", usual=CALIBRATED)

    def variants(self):
        return {"linear": (), "cubic": ()} | ({"angle": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(np.pi / 2 + (1 + phi[:, 0]) * (span.angle(x) - np.pi / 2))
        growth = span.unit(x) ** 2 if self.shape == "cubic" else 1
        return x * (1 + phi[:, 0] * growth)


@dataclass(frozen=True)
class Crosstalk(Change):
    """A part of another feature is added: of the next one, of a given one, or of the mean of all others.

    Or of what a given one exceeds a level by.
    """

    shape: str = "mean"
    name = "crosstalk"
    sentence = "A part of the signal of other channels leaks into this one."
    source = LEO + "Chapter 13"

    def strength(self) -> Parameter:
        return Parameter("coupling", -0.5, 0.5, 0, "1")

    def variants(self):
        if self.feature == "all":
            return {"mean": (), "next": (), "neighbours": ()}
        others = [j for j in range(len(self.ranges)) if j != self.feature]
        above = {f"x{j + 1} above": (self._level(j),) for j in others}
        return {"mean": ()} | {f"x{j + 1}": () for j in others} | above

    def _level(self, j: int) -> Parameter:
        return Parameter("level", self.ranges[j].low, self.ranges[j].high, None, f"of x{j + 1}")

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        d = x.shape[1]
        if self.shape == "mean":
            other = (x.sum(axis=1, keepdims=True) - x) / (d - 1)
        elif self.shape == "next":
            other = np.roll(x, -1, axis=1)
        elif self.shape == "neighbours":
            other = np.roll(x, -1, axis=1) + np.roll(x, 1, axis=1)
        else:
            other = np.repeat(x[:, [int(self.shape.split()[0][1:]) - 1]], d, axis=1)
            if self.shape.endswith("above"):
                other = np.maximum(other - phi[:, [1]], 0)
        columns = list(self.columns)
        x[:, columns] += phi[:, [0]] * other[:, columns]
        return x


@dataclass(frozen=True)
class Quantisation(Change):
    """A share of the values is known only in steps, or by the bin that it falls in."""

    shape: str = "nearest"
    steps: tuple[float, float] | None = None
    """Those that the data show, in the feature and in the angle; 0 for none."""
    levels: tuple[float, ...] = ()
    """Values of one feature that repeat in the data: they may be the middles of bins, even or not."""
    stage = 4
    name = "quantisation"
    sentence = "Values are recorded in coarse steps, as by a converter of few bits."
    source = LEO + "Section 14.9"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        plain, angle = (self._step(in_angle) for in_angle in (False, True))
        shapes = {"nearest": (plain,), "down": (plain,), "middle": (plain,)}
        if self.bounded:
            shapes["angle"] = (angle,)
        if len(self.levels) >= LEAST_LEVELS:
            border = Parameter("border", 0, 1, None, "of the middle step")
            shapes |= {"bins": (border,)} | ({"bins_in_angle": (border,)} if self.bounded else {})
        return shapes

    def _step(self, in_angle: bool) -> Parameter:
        unit = "rad" if in_angle else "of the feature"
        shown = self.steps[in_angle] if self.steps else 0
        if shown > 0:  # known exactly: no value of another step lies where the measured ones do
            return Parameter("step", (1 - KNOWN) * shown, (1 + KNOWN) * shown, None, unit)
        high = np.pi / 2 if in_angle else self.half
        return Parameter("step", 0.005 * high, high, None, unit)

    def adapted(self, x):
        adapted = super().adapted(x)
        steps = (adapted._shown(x, False), adapted._shown(x, True) if adapted.bounded else 0.0)
        levels: NDArray[np.float64] = np.empty(0)
        if len(self.columns) == 1:
            values, counts = np.unique(x[:, self.columns[0]], return_counts=True)
            levels = values[counts >= REPEATED]
        return replace(adapted, steps=steps, levels=tuple(levels.tolist()) if len(levels) <= MOST_LEVELS else ())

    def _shown(self, x, in_angle: bool) -> float:
        """The typical distance of neighbouring values that repeat; 0 where none do."""
        gaps = []
        for j in self.columns:
            values, counts = np.unique(self.ranges[j].angle(x[:, j]) if in_angle else x[:, j], return_counts=True)
            apart = np.diff(values[counts >= REPEATED])
            apart = apart[apart > 1e-6 * self.half]
            gaps += [np.median(apart)] if len(apart) else []
        step = float(np.median(gaps)) if gaps else 0.0
        return step if step < self.half else 0.0

    def guess(self, x):
        """Nothing where no values repeat."""
        if self.shape.startswith("bins"):
            return None
        shown = (self.steps or self.adapted(x).steps)[self.shape == "angle"]
        return None if shown > 0 else np.empty((0, 2))

    def changed(self, x, span, phi, rng):
        step = phi[:, 1]
        if self.shape.startswith("bins"):
            y = self._middle(x, span, phi[:, 1])
        elif self.shape == "angle":
            y = span.cosine(np.rint(span.angle(x) / step) * step)
        else:
            y = step * {"nearest": np.rint, "down": np.floor, "middle": lambda v: np.floor(v) + 0.5}[self.shape](
                x / step
            )
        return np.where(rng.random(len(x)) < phi[:, 0], y, x)

    def _middle(self, x, span, share):
        """The middle of the bin of each value (n,), the border at the middle being a `share` (n,) of the step on."""
        levels, y = np.array(self.levels), x
        if self.shape == "bins_in_angle":
            levels, y = np.sort(span.angle(levels)), span.angle(x)
        at_0, per_share = _chain(levels)
        below = np.clip(np.searchsorted(levels, y), 1, len(levels) - 1) - 1
        border = np.clip(at_0[below] + per_share[below] * share, levels[below], levels[below + 1])
        middle = levels[below + (y > border)]
        return span.cosine(middle) if self.shape == "bins_in_angle" else middle


def _chain(levels: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Borders (m - 1,) between bins whose middles are `levels` (m,): each follows from its neighbour, hence from one.

    Where they are if the one at the middle is at the level below it, and how they move with it, its step being a unit.
    From the middle, since bins at the ends of a range may be cut off.
    """
    at_0, middle = levels[:-1].copy(), (len(levels) - 1) // 2
    for k in range(middle + 1, len(at_0)):
        at_0[k] = 2 * levels[k] - at_0[k - 1]
    for k in range(middle - 1, -1, -1):
        at_0[k] = 2 * levels[k + 1] - at_0[k + 1]
    sign = np.where((np.arange(len(at_0)) - middle) % 2, -1, 1)
    return at_0, sign * (levels[middle + 1] - levels[middle])


@dataclass(frozen=True)
class Saturation(Change):
    """A share of the values ends at a limit, above, below, or on both sides; or all bend, or those beyond a knee."""

    shape: str = "above"
    limits: tuple[float, float] | None = None
    """Those that the data show below and above, in half ranges from the centre; 0 for none."""
    stage = 4
    name = "saturation"
    sentence = "Large values are cut at the end of the scale."
    source = LEO + "Section 14.1"

    def strength(self) -> Parameter:
        if self.shape == "soft":
            return Parameter("compression", 0, 8, 0, "half ranges a limit")
        if self.shape == "knee":
            return Parameter("compression", 0, 50, 0, "half ranges a limit")
        return Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        knee = Parameter("knee", 0, 1, None, "of half the range")
        return {shape: (self._limit(shape),) for shape in ENDS} | {"soft": (), "knee": (knee,)}

    def _limit(self, shape: str) -> Parameter:
        shown = [limit for limit, cut in zip(self.limits or (0, 0), ENDS[shape], strict=True) if cut and limit > 0]
        at = float(np.mean(shown)) if shown else 0
        low, high = (1 - KNOWN) * at, (1 + KNOWN) * at
        return Parameter("limit", *((low, high) if at else (0.1, 1)), None, "of half the range")

    def adapted(self, x):
        adapted = super().adapted(x)
        shown = [self._shown(x[:, j], adapted.ranges[j]) for j in self.columns]
        if self.feature == "all":  # each has its own limits: where they are shown, they end its range
            spans = [
                replace(span, low=low if np.isfinite(low) else span.low, high=high if np.isfinite(high) else span.high)
                for span, (low, high) in zip(adapted.ranges, shown, strict=True)
            ]
            adapted = replace(adapted, ranges=tuple(spans))
        units = np.abs([adapted.ranges[j].unit(np.array(ends)) for j, ends in zip(self.columns, shown, strict=True)])
        return replace(adapted, limits=tuple(np.where(np.isfinite(units), units, 0).max(axis=0).tolist()))

    def _shown(self, column, span) -> tuple[float, float]:
        """The value below the middle of the range, and the one above, at which most events are; NaN if none repeat."""
        values, counts = np.unique(column, return_counts=True)
        repeated = counts >= REPEATED
        found = [float("nan")] * 2
        for side, own in enumerate((repeated & (values < span.centre), repeated & (values > span.centre))):
            if own.any():
                found[side] = float(values[own][counts[own].argmax()])
        return found[0], found[1]

    def changed(self, x, span, phi, rng):
        u = span.unit(x)
        if self.shape == "soft":
            return span.centre + span.half * u / np.sqrt(1 + (phi[:, 0] * u) ** 2)
        if self.shape == "knee":
            beyond = np.maximum(u - phi[:, 1], 0)
            return span.centre + span.half * (u - beyond + beyond / (1 + phi[:, 0] * beyond))
        below, above = ENDS[self.shape]
        low = -phi[:, 1] if below else -np.inf
        high = phi[:, 1] if above else np.inf
        cut = ((u < low) | (u > high)) & (rng.random(len(x)) < phi[:, 0])
        return np.where(cut, span.centre + span.half * np.clip(u, low, high), x)


@dataclass(frozen=True)
class ChargeMisid(Change):
    """The sign is taken wrongly with a fixed chance, or with one that grows towards the ends."""

    shape: str = "constant"
    name = "charge_misid"
    sentence = "The charge, hence the sign, of some events is taken wrongly."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        return {"constant": (), "growing": (Parameter("power", 0.5, 10, None, "1"),)}

    def changed(self, x, span, phi, rng):
        chance = phi[:, 0]
        if self.shape == "growing":
            chance = chance * np.minimum(np.abs(span.unit(x)), 1) ** phi[:, 1]
        return np.where(rng.random(len(x)) < chance, -x, x)
