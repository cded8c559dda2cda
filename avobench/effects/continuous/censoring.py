"""Censoring: values beyond a limit are recorded as one value."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.ends import SIDES, Spike
from avobench.effects.continuous.feature import KNOWN, Change
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class Censoring(Change):
    """Values beyond a limit are recorded as one value: the limit itself, or what stands for such values.

    It is tried where the data have a spike, which tells the value, and, if they end sharply beside it, the limit. With
    the spike at the limit it is a `saturation`, which has a parameter less.
    """

    shape: str = "below"
    spikes: tuple[float | None, float | None] = (None, None)
    """Values at which the data gather, of what lies below and above a limit."""
    limits: tuple[float | None, float | None] = (None, None)
    """Those that the data show."""
    stage = 4
    on_all = False
    name = "censoring"
    position = 22
    sentence = "Values beyond a limit are recorded as one value, as where nothing smaller can be measured."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1, 0, "1")

    def variants(self):
        return {
            side: (self._known("limit", limit), self._known("value", spike))
            for side, limit, spike in zip(SIDES, self.limits, self.spikes, strict=True)
        }

    def _known(self, name: str, at: float | None) -> Parameter:
        low, high = (self.low, self.high) if at is None else (at - KNOWN * self.half, at + KNOWN * self.half)
        return Parameter(name, low, high, None, "of the feature")

    def adapted(self, x):
        """With the spikes and limits that the data show; the range stays, since they do not tell what lies beyond."""
        shown = [Spike.shown(x[:, self.feature], side) for side in SIDES]
        return replace(
            self,
            spikes=tuple(spike and spike.value for spike in shown),
            limits=tuple(spike and spike.limit for spike in shown),
        )

    def guess(self, x):
        """Nothing where the data have no spike."""
        spikes = (self if self.spikes != (None, None) else self.adapted(x)).spikes
        return np.empty((0, 3)) if spikes[SIDES.index(self.shape)] is None else None

    def changed(self, x, span, phi, rng):
        fraction, limit, value = phi.T
        beyond = x < limit if self.shape == "below" else x > limit
        return np.where(beyond & (rng.random(len(x)) < fraction), value, x)
