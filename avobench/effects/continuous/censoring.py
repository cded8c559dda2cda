"""Censoring: values beyond a limit are recorded as one value."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.ends import SIDES, Spike, spikes
from avobench.effects.continuous.feature import KNOWN, Change
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class Censoring(Change):
    """Values beyond a limit are recorded as one value: the limit itself, or what stands for such values.

    It is tried where the data have a spike, which tells the value, and, if they end sharply beside it, the limit. With
    the spike at the limit another shape of `saturation` has a parameter less. In the shapes `two_limits` a share of the
    events has the outer of two limits, as where two converters take turns; the data show both as spikes.
    """

    shape: str = "censored_below"
    spikes: tuple[float | None, float | None] = (None, None)
    """Values at which the data gather, of what lies below and above a limit."""
    limits: tuple[float | None, float | None] = (None, None)
    """Those that the data show."""
    two: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    """Two spikes at the lower end, and two at the upper, the inner one first; none where the data show no two."""
    stage = 4
    on_all = False
    name = "saturation"
    position = 22
    sentence = "Values beyond a limit are recorded as one value, as where nothing smaller can be measured."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        one = {
            f"censored_{side}": (self._known("limit", limit), self._known("value", spike))
            for side, limit, spike in zip(SIDES, self.limits, self.spikes, strict=True)
        }
        outer = Parameter("outer", 0, 1, None, "of the events")
        return one | {f"two_limits_{side}": (outer,) for side, two in zip(SIDES, self.two, strict=True) if two}

    def _known(self, name: str, at: float | None) -> Parameter:
        low, high = (self.low, self.high) if at is None else (at - KNOWN * self.half, at + KNOWN * self.half)
        return Parameter(name, low, high, None, "of the feature")

    @property
    def above(self) -> bool:
        return self.shape.endswith("above")

    def adapted(self, x):
        """With the spikes and limits that the data show; the range stays, since they do not tell what lies beyond."""
        column = x[:, self.feature]
        shown = [Spike.shown(column, side) for side in SIDES]
        middle, found = np.median(column), spikes(column)
        low, high = found[found < middle], found[found > middle]
        return replace(
            self,
            spikes=tuple(spike and spike.value for spike in shown),
            limits=tuple(spike and spike.limit for spike in shown),
            two=(tuple(low[::-1].tolist()) if len(low) == 2 else (), tuple(high.tolist()) if len(high) == 2 else ()),
        )

    def guess(self, x):
        """Nothing where the data have no spike."""
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
