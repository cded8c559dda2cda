"""Effects by which events or all of their counts are lost: a threshold, a truncation, or a channel that is off."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import expit

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole
from avobench.effects.rejection import accepted


@dataclass(frozen=True)
class ZeroInflation(CountEffect):
    """A share of the events reads nothing, or, in the shape `weak`, a fraction of its counts."""

    shape: str = "dead"

    name = "zero_inflation"
    position = 1
    STRENGTH = Parameter("fraction", 0, 0.98, 0, "1")
    SHAPES: ClassVar = {"dead": (), "weak": (Parameter("left", 0.001, 0.3, None, "1"),)}
    sentence: ClassVar = "Some events read zero whatever happened, as from a channel that is sometimes off."
    source: ClassVar = "D. Lambert, Technometrics 34 (1992) 1"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        off = rng.random(len(x)) < phi[:, 0]
        cells = self.cells(off)
        x[cells] = rng.binomial(whole(x[cells]), phi[off, 1:]) if self.shape == "weak" else 0
        return x


def _turn_on(strength, x, threshold, width):
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
"""The chance that counts x (n,) are lost, phi (n, q) -> (n,), by shape."""


@dataclass(frozen=True)
class ThresholdLoss(CountEffect):
    """Events of few counts are not recorded: below a threshold, or the fewer the less.

    In the shape `suppressed` they are recorded, as empty.
    """

    shape: str = "step"
    highest: float = 100.0
    """Largest threshold: beyond nearly all counts it would lose events whatever they hold."""

    stage = 3
    name = "threshold_loss"
    position = 4
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    sentence: ClassVar = "Events with few counts fall below a threshold and are lost."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.IV"

    def variants(self):
        threshold = Parameter("threshold", 0.3, self.highest, None, "counts")
        width = Parameter("width", 0.3, max(1.0, 0.3 * self.highest), None, "counts")
        return {shape: (threshold, width) if shape == "free_turn_on" else (threshold,) for shape in LOST}

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


@dataclass(frozen=True)
class Truncation(CountEffect):
    """Events of more counts than `limit` are lost.

    Between two whole numbers the limit is a share of the upper one; in the shape `soft` ever more are lost about it, as
    where events of many counts take longer than there is time for. Events of few counts are lost by `threshold_loss`:
    the zeros that a truncated count lacks are its shape `step` below one count.
    """

    limits: tuple[float, float] = (1.0, 100.0)
    """Bounds of the limit: below the median of the measured counts it would lose what was measured."""

    stage = 3
    name = "truncation"
    position = 34
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    sentence: ClassVar = (
        "Events with more counts than a limit are not recorded. That those with few are lost is threshold_loss."
    )
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def variants(self):
        limit = Parameter("limit", *self.limits, None, "counts")
        width = Parameter("width", 0.3, max(1.0, (self.limits[1] - self.limits[0]) / 2), None, "counts")
        return {"": (limit,), "soft": (limit, width)}

    def adapted(self, x):
        columns = x[:, self.columns]
        return replace(self, limits=(float(np.median(columns, axis=0).min()), float(columns.max()) + 1))

    def within(self, low, high, column):
        return np.array([low, *((high - low,) if self.shape == "soft" else ())])

    def apply(self, simulate, theta, phi, rng):
        def kept(x, rows):
            beyond = x[:, self.columns] - phi[rows, 1:2]
            share = expit(beyond / phi[rows, 2:]) if self.shape == "soft" else np.clip(beyond, 0, 1)
            return np.prod(1 - phi[rows, :1] * share, axis=1)

        return accepted(simulate, theta, kept, rng)
