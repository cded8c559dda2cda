"""Censoring: counts beyond a limit are recorded as that limit, where they gather."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect

CLEAR = 5.0
"""Standard deviations by which the events at a limit stand out from those of the counts next to it."""
SHARES = (0.98, 0.4, 0.1)
"""That a fit may begin at: at one there is no slope to follow."""
LOWEST = 0.1
"""Share of the events that a limit above has below it, at least, and one below above it: most may be at the limit."""
OUTERMOST = 3
"""Counts at the end of the data that may be the limit, though none of them stands out."""


@dataclass(frozen=True)
class Censoring(CountEffect):
    """A share of the counts beyond a limit is recorded as the limit.

    Between two whole numbers the limit is, in so large a share of the events, the upper one: as where several counters
    take turns of which one stops later.
    """

    shape: str = "above"
    least: tuple[float, float] = (1.0, 1.0)
    """Of the measured counts: a limit above lies at the first or higher, one below at the second or lower."""
    ends: tuple[float, float] = (0.0, 100.0)
    """Of the measured counts."""

    stage = 4
    name = "censoring"
    position = 35
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {"above": (), "below": ()}
    sentence: ClassVar = "Counts beyond the end of the scale are recorded as its end, where they gather."
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        low, high = (self.least[0], self.ends[1]) if self.shape == "above" else (self.ends[0], self.least[1])
        return (self.STRENGTH, Parameter("limit", low, max(high, low + 1), None, "counts"))

    def adapted(self, x):
        columns = x[:, self.columns]
        ends = float(columns.min()), float(columns.max())
        least = tuple(float(value) for value in np.quantile(columns, [LOWEST, 1 - LOWEST]))
        return replace(self, least=least, ends=ends)

    def guess(self, x):
        """The count that stands out most, and the outermost ones."""
        adapted, above = self.adapted(x), self.shape == "above"
        _, limit = adapted.parameters
        outermost = limit.high - np.arange(OUTERMOST) if above else max(limit.low, 1.0) + np.arange(OUTERMOST)
        spikes = [_spike(x[:, j], above) for j in self.columns]
        limits = np.unique([*outermost, *(spike for spike in spikes if spike is not None)])
        return np.array([[share, at] for at in limits if limit.low <= at <= limit.high for share in SHARES])

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        counts = x[:, self.columns]
        limit = np.floor(phi[:, 1:] + rng.random(counts.shape))
        beyond = counts > limit if self.shape == "above" else counts < limit
        x[:, self.columns] = np.where(beyond & (rng.random(counts.shape) < phi[:, :1]), limit, counts)
        return x


def _spike(x: NDArray, above: bool) -> int | None:
    """The count of x (N,) that most stands out from those next to it, no end of the other side; None for none.

    Zero is none: nothing is below it.
    """
    values, numbers = np.unique(np.maximum(x, 0).astype(np.int64), return_counts=True)
    next_to = np.zeros(len(values))
    for step in (-1, 1):
        at = np.minimum(np.searchsorted(values, values + step), len(values) - 1)
        next_to = np.maximum(next_to, np.where(values[at] == values + step, numbers[at], 0))
    z = (numbers - next_to) / np.sqrt(numbers + next_to)
    low, high = np.quantile(x, [LOWEST, 1 - LOWEST])
    z[(values < low) if above else (values > high)] = -np.inf
    z[values == 0] = -np.inf
    best = int(z.argmax())
    return int(values[best]) if z[best] > CLEAR else None
