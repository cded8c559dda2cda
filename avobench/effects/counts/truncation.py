"""Truncation: events of more counts than a limit are not recorded."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import expit

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect
from avobench.effects.rejection import accepted


@dataclass(frozen=True)
class Truncation(CountEffect):
    """Events of more counts than `limit` are lost.

    Between two whole numbers the limit is a share of the upper one; in the shape `soft` ever more are lost about it, as
    where events of many counts take longer than there is time for. Events of few counts are lost by `threshold_loss`:
    the zeros that a truncated count lacks are its shape `step` below one count.
    """

    limits: tuple[float, float] = (1.0, 100.0)
    """Of the limit: below the median of the measured counts it would lose what was measured."""

    stage = 3
    name = "truncation"
    position = 34
    STRENGTH = Parameter("lost", 0, 1, 0, "1")
    SHAPES: ClassVar = {"": (), "soft": ()}
    sentence: ClassVar = (
        "Events with more counts than a limit are not recorded. That those with few are lost is threshold_loss."
    )
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        limit = Parameter("limit", *self.limits, None, "counts")
        width = Parameter("width", 0.3, max(1.0, (self.limits[1] - self.limits[0]) / 2), None, "counts")
        return (self.STRENGTH, limit, *((width,) if self.shape == "soft" else ()))

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
