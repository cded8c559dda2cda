"""A threshold: events of few counts are not recorded, or recorded as empty."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect
from avobench.effects.rejection import accepted


def _turn_on(strength, x, threshold, width):
    """A logistic that falls through half the strength at the threshold: (n,)."""
    return strength / (1 + np.exp(np.clip((x - threshold) / width, -50, 50)))


LOST = {
    # between two whole numbers the threshold is a share of the lower one
    "step": lambda x, phi: phi[:, 0] * np.clip(phi[:, 1] - x, 0, 1),
    "exponential": lambda x, phi: phi[:, 0] * np.exp(-x / phi[:, 1]),
    # counts at the threshold scatter by its root, a logistic by 1.8 widths
    "turn_on": lambda x, phi: _turn_on(phi[:, 0], x, phi[:, 1], 0.3 * np.sqrt(phi[:, 1])),
    "free_turn_on": lambda x, phi: _turn_on(phi[:, 0], x, phi[:, 1], phi[:, 2]),
}
LOST["suppressed"] = LOST["turn_on"]
"""By shape: the chance that counts x (n,) are lost, phi (n, q) -> (n,)."""


@dataclass(frozen=True)
class ThresholdLoss(CountEffect):
    """Events of few counts are not recorded: below a threshold, or the fewer the less.

    In the shape `suppressed` they are recorded, as empty.
    """

    shape: str = "step"
    highest: float = 100.0
    """Of the threshold; beyond nearly all counts it would lose events whatever they hold."""

    stage = 3
    name = "threshold_loss"
    position = 4
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    SHAPES: ClassVar = {shape: () for shape in LOST}
    sentence: ClassVar = "Events with few counts fall below a threshold and are lost."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.IV"

    @property
    def parameters(self):
        threshold = Parameter("threshold", 0.3, self.highest, None, "counts")
        width = Parameter("width", 0.3, max(1.0, 0.3 * self.highest), None, "counts")
        return (self.STRENGTH, threshold, *((width,) if self.shape == "free_turn_on" else ()))

    def adapted(self, x):
        return replace(self, highest=max(1.0, float(np.quantile(x[:, self.columns], 0.99, axis=0).max())))

    def apply(self, simulate, theta, phi, rng):
        if self.shape == "suppressed":
            x = simulate(theta, rng)
            counts = x[:, self.columns]
            lost = np.stack([LOST[self.shape](counts[:, j], phi) for j in range(counts.shape[1])], axis=1)
            x[:, self.columns] = np.where(rng.random(counts.shape) < lost, 0, counts)
            return x

        def kept(x, rows):
            return np.prod([1 - LOST[self.shape](x[:, j], phi[rows]) for j in self.columns], axis=0)

        return accepted(simulate, theta, kept, rng)
