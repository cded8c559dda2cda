"""Truncation: events of more counts than a limit are not recorded."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect
from avobench.effects.rejection import accepted


@dataclass(frozen=True)
class Truncation(CountEffect):
    """Events of more counts than `limit` are lost.

    Between two whole numbers the limit is a share of the upper one. Events of few counts are lost by `threshold_loss`:
    the zeros that a truncated count lacks are its shape `step` below one count.
    """

    limits: tuple[float, float] = (1.0, 100.0)
    """Of the limit: below the median of the measured counts it would lose what was measured."""

    stage = 3
    name = "truncation"
    position = 34
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    SHAPES: ClassVar = {"": ()}
    sentence: ClassVar = (
        "Events with more counts than a limit are not recorded. That those with few are lost is threshold_loss."
    )
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (self.STRENGTH, Parameter("limit", *self.limits, None, "counts"))

    def adapted(self, x):
        columns = x[:, self.columns]
        return replace(self, limits=(float(np.median(columns, axis=0).min()), float(columns.max()) + 1))

    def within(self, low, high, column):
        return np.array([low])

    def apply(self, simulate, theta, phi, rng):
        def kept(x, rows):
            lost = phi[rows, :1] * np.clip(x[:, self.columns] - phi[rows, 1:], 0, 1)
            return np.prod(1 - lost, axis=1)

        return accepted(simulate, theta, kept, rng)
