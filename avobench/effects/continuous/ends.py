"""Where measured values end: at a sharp end, as a cut leaves it, or in a spike of equal values."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.feature import REPEATED

SIDES = ("below", "above")
OUTERMOST = 200
"""The end of one in so many values is looked at: narrow enough that the density hardly changes in it."""
MOST = 4
"""Spikes: two at either end."""
FEWEST = 20
"""Values there at least: of fewer the scatter hides whether an end is sharp."""
SHARP = 0.6
"""Length of the next stretch with as many values in that of the outermost one. It is as long where the density
ends in a step, 0.41 of it where it rises evenly from nothing, and a fifth in the tail of an exponential or a normal."""


def sharp_end(x: NDArray[np.float64], side: str) -> float | None:
    """The outermost of values (n,) `below` or `above`; None unless they end there in a step, and are enough to tell."""
    sign = 1 if side == "below" else -1
    k = max(len(x) // OUTERMOST, FEWEST)
    if 2 * k >= len(x):
        return None
    outermost = np.sort(np.partition(sign * x, 2 * k)[: 2 * k + 1])
    end, first, then = outermost[[0, k, 2 * k]]
    sharp = len(np.unique(outermost)) > k and SHARP * (first - end) < then - first
    return float(sign * end) if sharp else None


def spikes(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (k,) that repeat among others (n,), in order; none where more than MOST do, as steps."""
    values, counts = np.unique(x, return_counts=True)
    repeated = values[counts >= REPEATED]
    return repeated if len(repeated) <= MOST else repeated[:0]


@dataclass(frozen=True)
class Spike:
    """A value at which measured ones gather, at an end of the others or beyond it."""

    value: float
    limit: float | None
    """The end of the others, if it is sharp."""

    @classmethod
    def shown(cls, x: NDArray[np.float64], side: str) -> Self | None:
        """The spike of values (n,) at the end `below` or `above`; None where more than two repeat, as steps do."""
        values, counts = np.unique(x, return_counts=True)
        repeated, others = values[counts >= REPEATED], values[counts < REPEATED]
        if len(others) == 0 or len(repeated) not in (1, 2):
            return None
        below = side == "below"
        value, end = (repeated[0], others[0]) if below else (repeated[-1], others[-1])
        return cls(float(value), sharp_end(others, side)) if (value <= end if below else value >= end) else None
