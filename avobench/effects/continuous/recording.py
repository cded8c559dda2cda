"""Effects of how a value is recorded: in steps, cut at the end of the scale, as one that stands for others, or not."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.comb import Comb
from avobench.effects.continuous.ends import SIDES, Spike, spikes
from avobench.effects.continuous.feature import KNOWN, REPEATED, Change, FeatureEffect
from avobench.effects.contract import Parameter

LEAST_LEVELS = 4
"""Least number of repeated values that may be the middles of bins."""
MOST_LEVELS = 1000
"""Largest number of such values: more are a fine rounding."""
WITHIN = 5.0
"""Standard errors within which the step of a comb is known."""
MOSTLY = 0.98
"""The largest share of values in steps that a fit begins at: at one there is no slope to follow."""
NOISIEST = 0.3
"""Noise of a comb in steps, at most: beyond, its steps run into one another."""

ROUNDED = {"nearest": np.rint, "down": np.floor, "middle": lambda v: np.floor(v) + 0.5}
"""The function of each shape from values (n,), in steps, to recorded values."""


@dataclass(frozen=True)
class Quantisation(Change):
    """A share of the values is known only in steps, or by the bin that it falls in.

    In the shape `by_size` the steps may grow with the size of a value, as of floating-point numbers of few digits.
    """

    shape: str = "nearest"
    steps: tuple[float, float] | None = None
    """The steps that the data show, in the feature and in the angle; 0 for none."""
    levels: tuple[float, ...] = ()
    """Values of one feature that repeat in the data: they may be the middles of bins, even or not."""
    combs: tuple[Comb, ...] = ()
    """The blurred steps that the data show, of each feature; none where one shows none."""
    stage = 4
    name = "quantisation"
    position = 12
    sentence = "Values are recorded in coarse steps, as by a converter of few bits."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.9"
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        plain, angle = (self._step(in_angle) for in_angle in (False, True))
        shapes = {shape: (plain,) for shape in ROUNDED}
        if self.bounded:
            shapes["angle"] = (angle,)
        if len(self.levels) >= LEAST_LEVELS:
            border = Parameter("border", 0, 1, None, "of the middle step")
            shapes |= {"bins": (border,)} | ({"bins_in_angle": (border,)} if self.bounded else {})
            shapes["by_size"] = (replace(border, unit="of each step"),)
        if self.combs:
            noise = Parameter("noise", 0, NOISIEST, None, "steps")
            shapes |= {shape: (self._known_step(), noise) for shape in ("blurred", "blurred_down")}
        return shapes

    def _known_step(self) -> Parameter:
        step = float(np.median([comb.step for comb in self.combs]))
        off = WITHIN * min(comb.error for comb in self.combs)
        return Parameter("step", (1 - off) * step, (1 + off) * step, None, "of the feature")

    def _step(self, in_angle: bool) -> Parameter:
        unit = "rad" if in_angle else "of the feature"
        shown = self.steps[in_angle] if self.steps else 0
        if shown > 0:  # known exactly: no value of another step lies where the measured ones do
            return Parameter("step", (1 - KNOWN) * shown, (1 + KNOWN) * shown, None, unit, known=True)
        high = np.pi / 2 if in_angle else self.half
        return Parameter("step", 0.005 * high, high, None, unit)

    def adapted(self, x):
        adapted = super().adapted(x)
        steps = (adapted._shown(x, False), adapted._shown(x, True) if adapted.bounded else 0.0)
        columns = [np.unique(x[:, j], return_counts=True) for j in self.columns]
        levels = [values[counts >= REPEATED].tolist() for values, counts in columns]
        different = [values[counts < REPEATED] for values, counts in columns]
        combs = [Comb.shown(values) for values in different if len(values) > len(x) / 2]
        return replace(
            adapted,
            steps=steps,
            levels=tuple(levels[0]) if len(levels) == 1 and len(levels[0]) <= MOST_LEVELS else (),
            combs=tuple(comb for comb in combs if comb) if len(combs) == len(columns) and all(combs) else (),
        )

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
        if self.shape.startswith("bins") or self.shape == "by_size":
            return None
        if self.shape.startswith("blurred"):
            comb, (_, step, noise) = self.combs[0], self.parameters
            return np.array([[min(comb.share, MOSTLY), (step.low + step.high) / 2, min(comb.noise, noise.high)]])
        shown = (self.steps or self.adapted(x).steps)[self.shape == "angle"]
        return None if shown > 0 else np.empty((0, 2))

    def apply(self, simulate, theta, phi, rng):
        if not self.shape.startswith("blurred"):
            return super().apply(simulate, theta, phi, rng)
        x, parameter = simulate(theta, rng), self._known_step()
        for j, comb in zip(self.columns, self.combs, strict=True):
            step = comb.step * phi[:, 1] * 2 / (parameter.low + parameter.high)
            at = (x[:, j] - comb.origin) / step
            at = np.floor(at) if self.shape == "blurred_down" else np.rint(at)
            read = comb.origin + step * (at + phi[:, 2] * rng.standard_normal(len(x)))
            x[:, j] = np.where(rng.random(len(x)) < phi[:, 0], read, x[:, j])
        return x

    def changed(self, x, span, phi, rng):
        step = phi[:, 1]
        if self.shape.startswith("bins"):
            y = self._middle(x, span, phi[:, 1])
        elif self.shape == "by_size":
            y = self._nearest(x, phi[:, 1])
        elif self.shape == "angle":
            y = span.cosine(np.rint(span.angle(x) / step) * step)
        else:
            y = step * ROUNDED[self.shape](x / step)
        return np.where(rng.random(len(x)) < phi[:, 0], y, x)

    def _nearest(self, x, share):
        """The recorded value of each (n,), the border in each step being at a `share` (n,) of its size."""
        levels = np.array(self.levels)
        below = np.clip(np.searchsorted(levels, x), 1, len(levels) - 1) - 1
        low, high = levels[below], levels[below + 1]
        share = np.where(low * high < 0, 0.5, np.where(low + high > 0, share, 1 - share))
        return np.where(x > low + share * (high - low), high, low)

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

    Where they are if the middle one is at the level below it, and how they move with it, its step being a unit.
    """
    at_0, middle = levels[:-1].copy(), (len(levels) - 1) // 2
    for k in range(middle + 1, len(at_0)):
        at_0[k] = 2 * levels[k] - at_0[k - 1]
    for k in range(middle - 1, -1, -1):
        at_0[k] = 2 * levels[k + 1] - at_0[k + 1]
    sign = np.where((np.arange(len(at_0)) - middle) % 2, -1, 1)
    return at_0, sign * (levels[middle + 1] - levels[middle])


ENDS = {"above": (False, True), "both": (True, True), "below": (True, False)}
"""Whether values are cut at the lower and at the upper end, by shape."""
COMPRESSION = {"soft": 8, "knee": 50, "knee_below": 50}
"""The largest compression, in half ranges a limit, by shape."""
KNEE = Parameter("knee", 0, 1, None, "of half the range")
BOUNCE = Parameter("bounce", 0.01, 0.5, None, "of half the range")


@dataclass(frozen=True)
class Saturation(Change):
    """A share of the values ends at a limit on one side or both; or all bend, or those beyond a knee on one side.

    In the shape `rebound` those beyond a limit on either side come back from it a little, as a needle from its stop.
    """

    shape: str = "above"
    limits: tuple[float, float] | None = None
    """The limits that the data show below and above, in half ranges from the centre; 0 for none."""
    stage = 4
    name = "saturation"
    position = 13
    sentence = "Large values are cut at the end of the scale."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.1"

    def strength(self) -> Parameter:
        if self.shape in COMPRESSION:
            return Parameter("compression", 0, COMPRESSION[self.shape], 0, "half ranges a limit")
        return Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        bent = {
            "soft": (),
            "knee": (KNEE,),
            "knee_below": (KNEE,),
            "rebound": (Parameter("limit", 0.1, 1, None, "of half the range"), BOUNCE),
        }
        return {shape: (self._limit(shape),) for shape in ENDS} | bent

    def _limit(self, shape: str) -> Parameter:
        shown = [limit for limit, cut in zip(self.limits or (0, 0), ENDS[shape], strict=True) if cut and limit > 0]
        at = float(np.mean(shown)) if shown else 0
        low, high = (1 - KNOWN) * at, (1 + KNOWN) * at
        return Parameter("limit", *((low, high) if at else (0.1, 1)), None, "of half the range", known=at > 0)

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
        sides = (repeated & (values < span.centre), repeated & (values > span.centre))
        return tuple(float(values[side][counts[side].argmax()]) if side.any() else float("nan") for side in sides)

    def changed(self, x, span, phi, rng):
        u = span.unit(x)
        if self.shape == "soft":
            return span.centre + span.half * u / np.sqrt(1 + (phi[:, 0] * u) ** 2)
        if self.shape in ("knee", "knee_below"):
            sign = 1 if self.shape == "knee" else -1
            beyond = np.maximum(sign * u - phi[:, 1], 0)
            return span.centre + span.half * (u - sign * (beyond - beyond / (1 + phi[:, 0] * beyond)))
        below, above = ENDS["both" if self.shape == "rebound" else self.shape]
        low = -phi[:, 1] if below else -np.inf
        high = phi[:, 1] if above else np.inf
        cut = ((u < low) | (u > high)) & (rng.random(len(x)) < phi[:, 0])
        end = np.clip(u, low, high)
        if self.shape == "rebound":
            end = np.clip(end - np.sign(u) * phi[:, 2] * rng.standard_exponential(len(x)), low, high)
        return np.where(cut, span.centre + span.half * end, x)


@dataclass(frozen=True)
class Censoring(Change):
    """Values beyond a limit are recorded as one value: the limit itself, or what stands for such values.

    It is tried where the data have a spike. In the shapes `two_limits` a share of the events has the outer of two
    limits, as where two converters take turns.
    """

    shape: str = "censored_below"
    spikes: tuple[float | None, float | None] = (None, None)
    """Values at which the data gather, of what lies below and above a limit."""
    limits: tuple[float | None, float | None] = (None, None)
    """The limits that the data show."""
    two: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    """Two spikes at the lower end, and two at the upper, the inner one first; none where the data show no two."""
    stage = 4
    on_all = False
    name = "saturation"
    position = 22
    sentence = "Values beyond a limit are recorded as one value, as where nothing smaller can be measured."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        one = {
            f"censored_{side}": (self._parameter("limit", limit), self._parameter("value", spike))
            for side, limit, spike in zip(SIDES, self.limits, self.spikes, strict=True)
        }
        outer = Parameter("outer", 0, 1, None, "of the events")
        return one | {f"two_limits_{side}": (outer,) for side, two in zip(SIDES, self.two, strict=True) if two}

    def _parameter(self, name: str, at: float | None) -> Parameter:
        low, high = (self.low, self.high) if at is None else (at - KNOWN * self.half, at + KNOWN * self.half)
        return Parameter(name, low, high, None, "of the feature", known=at is not None)

    @property
    def above(self) -> bool:
        return self.shape.endswith("above")

    def adapted(self, x):
        column = x[:, self.feature]
        shown = [Spike.shown(column, side) for side in SIDES]
        middle, values = np.median(column), spikes(column)
        low, high = values[values < middle], values[values > middle]
        return replace(
            self,
            spikes=tuple(spike and spike.value for spike in shown),
            limits=tuple(spike and spike.limit for spike in shown),
            two=(tuple(low[::-1].tolist()) if len(low) == 2 else (), tuple(high.tolist()) if len(high) == 2 else ()),
        )

    def guess(self, x):
        adapted = self if self.spikes != (None, None) or any(self.two) else self.adapted(x)
        if self.shape.startswith("two_limits"):
            return None
        return np.empty((0, 3)) if adapted.spikes[self.above] is None else None

    def changed(self, x, span, phi, rng):
        recorded = rng.random(len(x)) < phi[:, 0]
        if self.shape.startswith("two_limits"):
            inner, outer = self.two[self.above]
            limit = np.where(rng.random(len(x)) < phi[:, 1], outer, inner)
            value = limit
        else:
            limit, value = phi[:, 1], phi[:, 2]
        beyond = x > limit if self.above else x < limit
        return np.where(beyond & recorded, value, x)


LOST = {"low": np.less, "high": np.greater}
"""On which side of a value it is lost, by shape."""


@dataclass(frozen=True)
class LostValue(FeatureEffect):
    """Events lack a feature more often than simulated: anywhere, or where its value is on one side of another."""

    stage = 4
    name = "lost_value"
    sentence = "The value of a feature is missing in more events: the detector did not fire, or nobody answered."
    source = "D. B. Rubin, Biometrika 63 (1976) 581"
    STRENGTH = Parameter("lost", 0, 1, 0, "1")

    @classmethod
    def entries(cls, site):
        return [cls(j, site.ranges) for j in site.task.missing]

    def variants(self):
        at = (Parameter("at", self.low, self.high, None, "of the feature"),)
        return {"": (), **dict.fromkeys(LOST, at)}

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        lost = rng.random(len(x)) < phi[:, 0]
        if self.shape:
            lost &= LOST[self.shape](x[:, self.feature], phi[:, 1])
        x[lost, self.feature] = np.nan
        return x
