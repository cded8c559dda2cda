"""Censoring: counts beyond a limit are recorded as that limit, where they form a spike."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect

CLEAR = 5.0
"""Standard deviations by which the events at a limit stand out from those of the counts next to it."""
KNOWN = 1e-9
"""Relative error of a limit that is read off the data."""
MOSTLY = 0.98
"""The share that a fit begins at: at one there is no slope to follow."""


@dataclass(frozen=True)
class Censoring(CountEffect):
    """A share of the counts beyond a limit is recorded as the limit, which the data show."""

    shape: str = "above"
    limits: tuple[int, int] = (0, 0)
    """Those that the data show, below their median and above it; 0 for none."""

    stage = 4
    name = "censoring"
    position = 35
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {"above": (), "below": ()}
    sentence: ClassVar = "Counts beyond the end of the scale are recorded as its end, where they form a spike."
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        shown = self.limits[self.shape == "above"]
        ends = ((1 - KNOWN) * shown, (1 + KNOWN) * shown) if shown else (1.0, 100.0)
        return (self.STRENGTH, Parameter("limit", *ends, None, "counts"))

    def adapted(self, x):
        """With the limits that stand out most, of all the counts that it acts on."""
        spikes = [_spike(x[:, j], above) for above in (False, True) for j in self.columns]
        below, above = spikes[: len(self.columns)], spikes[len(self.columns) :]
        return replace(self, limits=(max(below)[1], max(above)[1]))

    def guess(self, x):
        """Nothing where no count stands out."""
        shown = self.adapted(x).limits[self.shape == "above"]
        return np.array([[MOSTLY, shown], [MOSTLY / 2, shown]]) if shown else np.empty((0, 2))

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        limit, counts = np.rint(phi[:, 1:]), x[:, self.columns]
        beyond = counts > limit if self.shape == "above" else counts < limit
        x[:, self.columns] = np.where(beyond & (rng.random(counts.shape) < phi[:, :1]), limit, counts)
        return x


def _spike(x: NDArray, above: bool) -> tuple[float, int]:
    """The count from the median of x (N,) on, up or down, that most stands out from those next to it.

    By how many standard deviations, and the count; 0 for none. Zero is none: nothing is below it.
    """
    values, numbers = np.unique(np.maximum(x, 0).astype(np.int64), return_counts=True)
    next_to = np.zeros(len(values))
    for step in (-1, 1):
        at = np.minimum(np.searchsorted(values, values + step), len(values) - 1)
        next_to = np.maximum(next_to, np.where(values[at] == values + step, numbers[at], 0))
    z = (numbers - next_to) / np.sqrt(numbers + next_to)
    z[(values < np.median(x)) if above else (values > np.median(x)) | (values == 0)] = -np.inf
    z[values == 0] = -np.inf
    best = int(z.argmax())
    return (float(z[best]), int(values[best])) if z[best] > CLEAR else (0.0, 0)
