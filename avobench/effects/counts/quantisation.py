"""Quantisation: counts are known only in steps, or one bit of them sticks."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole

ONE_VALUE = 0.95
"""Share of the counts that a rounding may make the same, at most."""

ROUNDINGS = {
    "down": lambda step: (0, 0),
    "up": lambda step: (step - 1, 0),
    "nearest": lambda step: (step // 2, 0),
    "middle": lambda step: (0, step // 2),
}
"""What is added to a count before it is rounded down to a step, and after."""
STEPS = {
    f"{step} {to}": (step, *added(step))
    for step in (2, 3, 4, 5, 6, 7, 8, 10, 12, 16)
    for to, added in ROUNDINGS.items()
    if step > 2 or to in ("down", "up")  # of two counts there is no middle
}
"""By shape: a step, and what is added."""
BITS = {
    f"bit {bit} {at}": (1 << bit, at == "high")
    for bit in range(4)
    for at in ("low", "high")
    if (bit, at) != (0, "low")  # that is rounding down to even counts
}
"""By shape: a bit of the counter that sticks, and whether it is set."""


@dataclass(frozen=True)
class Quantisation(CountEffect):
    """A share of the readings is known only in steps of `shape` counts, rounded as it says; or one bit sticks."""

    shape: str = "2 down"

    stage = 4
    name = "quantisation"
    position = 8
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {shape: () for shape in (*STEPS, *BITS)}
    sentence: ClassVar = "Readings are rounded to a coarser step than one count."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.V"

    def guess(self, x):
        """Nothing where the step is so wide that nearly all counts become the same: that is no rounding."""
        same = max(np.unique(self._rounded(x[:, j]), return_counts=True)[1].max() for j in self.columns)
        return np.empty((0, 1)) if same > ONE_VALUE * len(x) else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        for j in self.columns:
            rows = rng.random(len(x)) < phi[:, 0]
            x[rows, j] = self._rounded(x[rows, j])
        return x

    def _rounded(self, x):
        if self.shape in BITS:
            bit, high = BITS[self.shape]
            return whole(x) | bit if high else whole(x) & ~bit
        step, before, after = STEPS[self.shape]
        return (x + before) // step * step + after
