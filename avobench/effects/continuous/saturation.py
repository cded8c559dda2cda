"""Saturation: large values are cut at the end of the scale, or bend towards it."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.feature import KNOWN, REPEATED, Change
from avobench.effects.contract import Parameter

ENDS = {"above": (False, True), "both": (True, True), "below": (True, False)}
"""By shape: whether values are cut at the lower and at the upper end."""
COMPRESSION = {"soft": 8, "knee": 50, "knee_below": 50}
"""By shape: the largest compression, in half ranges a limit."""
KNEE = Parameter("knee", 0, 1, None, "of half the range")
BOUNCE = Parameter("bounce", 0.01, 0.5, None, "of half the range")


@dataclass(frozen=True)
class Saturation(Change):
    """A share of the values ends at a limit on one side or both; or all bend, or those beyond a knee on one side.

    In the shape `rebound` those beyond a limit on either side come back from it a little, as a needle from its stop.
    """

    shape: str = "above"
    limits: tuple[float, float] | None = None
    """Those that the data show below and above, in half ranges from the centre; 0 for none."""
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
