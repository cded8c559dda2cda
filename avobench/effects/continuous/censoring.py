"""Censoring: values beyond a limit are recorded as one value."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.ends import Spike
from avobench.effects.continuous.feature import KNOWN, Change
from avobench.effects.continuous.limited import SIDES, Limited
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class Censoring(Limited, Change):
    """Every value beyond a limit is recorded as one value: the limit itself, or what stands for such values.

    It is tried where the data have a spike. Where it is at the limit, this is a `saturation` of all values; where only
    a share of them is cut, it is that and not this.
    """

    spikes: tuple[float | None, float | None] = (None, None)
    """Values at which the data gather, of what lies below and above a limit."""
    stage = 4
    name = "censoring"
    position = 22
    sentence = "Values beyond a limit are recorded as one value, as where nothing smaller can be measured."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def variants(self):
        return {side: (self._value(spike),) for side, spike in zip(SIDES, self.spikes, strict=True)}

    def _value(self, spike: float | None) -> Parameter:
        low, high = (self.low, self.high) if spike is None else (spike - KNOWN * self.half, spike + KNOWN * self.half)
        return Parameter("value", low, high, None, "of the feature")

    def shown(self, x, side):
        spike = Spike.shown(x, side)
        return None if spike is None else spike.limit

    def adapted(self, x):
        spikes = [Spike.shown(x[:, self.feature], side) for side in SIDES]
        return replace(super().adapted(x), spikes=tuple(spike and spike.value for spike in spikes))

    def guess(self, x):
        """Nothing where the data have no spike."""
        known = self.known(x)
        if known.limit is None:
            return np.empty((0, 2))
        return np.array([[known.limit, known.spikes[SIDES.index(self.shape)]]])

    def changed(self, x, span, phi, rng):
        return np.where(self.beyond(x, phi[:, 0]), phi[:, 1], x)
