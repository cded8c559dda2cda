"""Readout: a value is recorded in steps, or cut at the end of the scale."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from avobench.effects.continuous.calibration import LEO
from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

REPEATED = 5
"""So many equal values of a continuous feature are no chance."""
LEAST_LEVELS, MOST_LEVELS = 4, 1000
"""Fewer repeated values are no bins, more are a fine rounding."""
KNOWN = 1e-9
"""Relative error of a step that is read off the data."""
ENDS = {"above": (False, True), "both": (True, True), "below": (True, False)}
"""Whether values are cut at the lower and at the upper end."""
FINE, FINER, STEPS = 8192, 4, (4, 1000)
"""Bins of a histogram whose spectrum is taken; its frequencies a cycle over the range; steps that a range may have."""
PLAIN, CHANCE, LINE = 0.1, 5.0, 3.0
"""The least amplitude of a comb, since a range that ends sharply has lines nearly as high, and so many standard errors
more; how far its line stands above frequencies beside it."""
FIRST = 0.9
"""Of the highest line, that the first of a comb has at least."""
WITHIN, MOSTLY = 5.0, 0.98
"""Standard errors within which a comb's step is known; the largest share of values in steps that a fit begins at."""


@dataclass(frozen=True)
class Comb:
    """Even steps, each blurred, in which values of a feature lie."""

    step: float
    error: float
    """Of the step, relative."""
    origin: float
    """One of the values, near the middle."""
    share: float
    """Of the values that lie in steps, about."""
    noise: float
    """Of each, in steps, about."""

    @classmethod
    def shown(cls, x: NDArray[np.float64]) -> Self | None:
        """The comb of values (n,) that are all different: a line in their spectrum, if there is one.

        With its harmonic it also tells the noise: the spectrum of a comb falls as that of the blur.
        """
        low, high = np.quantile(x, [0.005, 0.995])
        if not high > low:
            return None
        counts = np.histogram(x, FINE, (low, high))[0]
        spectrum = np.abs(np.fft.rfft(counts, FINER * FINE)) / counts.sum()
        cycles = np.arange(len(spectrum)) / FINER
        heights = np.where((cycles >= STEPS[0]) & (cycles <= STEPS[1]), spectrum, 0)
        found = cycles[np.argmax(heights > FIRST * heights.max())]  # sharp steps have harmonics as high
        beside = spectrum[(np.abs(cycles - found) < found / 2) & (np.abs(cycles - found) > 1.5)]

        def amplitude(cycles: float) -> complex:
            return complex(np.exp(2j * np.pi * cycles * (x - low) / (high - low)).mean())

        ends = (found - 3 / FINER, found + 3 / FINER)
        found = float(minimize_scalar(lambda c: -abs(amplitude(c)), bounds=ends, method="bounded").x)
        first, second = amplitude(found), max(abs(amplitude(2 * found)), 1 / np.sqrt(len(x)))
        if abs(first) < max(PLAIN + CHANCE / np.sqrt(len(x)), LINE * float(np.median(beside))):
            return None
        variance = max(np.log(abs(first) / second), 0) / (6 * np.pi**2)
        step = float(high - low) / found
        found *= 1 + float(variance * step**2 / x.var())  # the fall moves the line
        first, step = amplitude(found), float(high - low) / found
        origin = float(low + step * (np.angle(first) / (2 * np.pi) + found // 2))
        share = min(abs(first) * float(np.exp(2 * np.pi**2 * variance)), 1.0)
        error = 1 / (abs(first) * np.sqrt(len(x)) * found)
        return cls(step, float(error), origin, share, float(np.sqrt(variance)))


@dataclass(frozen=True)
class Quantisation(Change):
    """A share of the values is known only in steps, or by the bin that it falls in."""

    shape: str = "nearest"
    steps: tuple[float, float] | None = None
    """Those that the data show, in the feature and in the angle; 0 for none."""
    levels: tuple[float, ...] = ()
    """Values of one feature that repeat in the data: they may be the middles of bins, even or not."""
    combs: tuple[Comb, ...] = ()
    """The blurred steps that the data show, of each feature; none where one shows none."""
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
        if self.combs:
            noise = Parameter("noise", 0, 0.3, None, "steps")
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
            return Parameter("step", (1 - KNOWN) * shown, (1 + KNOWN) * shown, None, unit)
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
        """Nothing where no values repeat."""
        if self.shape.startswith("bins"):
            return None
        if self.shape.startswith("blurred"):
            comb, (_, step, noise) = self.combs[0], self.parameters
            return np.array([[min(comb.share, MOSTLY), (step.low + step.high) / 2, min(comb.noise, noise.high)]])
        shown = (self.steps or self.adapted(x).steps)[self.shape == "angle"]
        return None if shown > 0 else np.empty((0, 2))

    def apply(self, simulate, theta, phi, rng):
        if not self.shape.startswith("blurred"):
            return super().apply(simulate, theta, phi, rng)
        x, known = simulate(theta, rng), self._known_step()
        for j, comb in zip(self.columns, self.combs, strict=True):
            step = comb.step * phi[:, 1] * 2 / (known.low + known.high)
            at = (x[:, j] - comb.origin) / step
            at = np.floor(at) if self.shape == "blurred_down" else np.rint(at)
            read = comb.origin + step * (at + phi[:, 2] * rng.standard_normal(len(x)))
            x[:, j] = np.where(rng.random(len(x)) < phi[:, 0], read, x[:, j])
        return x

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
