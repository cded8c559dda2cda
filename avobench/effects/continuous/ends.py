"""Where measured values end: at a sharp end, as a cut leaves it, or in a spike of equal values."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.feature import REPEATED

OUTERMOST = 200
"""The end of one in so many values is looked at: narrow enough that the density hardly changes in it."""
FEWEST = 20
"""Values there at least: of fewer the scatter hides whether an end is sharp."""
SHARP = 0.6
"""Of the stretch that holds the outermost values, the length of the next with as many. It is as long where the density
ends in a step, 0.41 of it where it rises evenly from nothing, and a fifth in the tail of an exponential or a normal."""


def sharp_end(x: NDArray[np.float64], side: str) -> float | None:
    """The outermost of values (n,) `below` or `above`, if they end there in a step; None if they thin out."""
    sign = 1 if side == "below" else -1
    k = max(len(x) // OUTERMOST, FEWEST)
    if 2 * k >= len(x):
        return None
    end, first, then = np.partition(sign * x, [0, k, 2 * k])[[0, k, 2 * k]]
    return float(sign * end) if 0 < SHARP * (first - end) < then - first else None


@dataclass(frozen=True)
class Spike:
    """A value at which measured ones gather, and the end of the others."""

    value: float
    limit: float

    @classmethod
    def shown(cls, x: NDArray[np.float64], side: str) -> "Spike | None":
        """That for what lies `below` or `above` a limit, of values (n,).

        None where no value repeats, or more than two do: those are steps. Of two, each is for its own side.
        """
        values, counts = np.unique(x, return_counts=True)
        repeated = values[counts >= REPEATED]
        if len(repeated) not in (1, 2) or len(repeated) == len(values):
            return None
        others = values[counts < REPEATED]
        below = side == "below"
        return cls(float(repeated[0 if below else -1]), float(others[0 if below else -1]))
