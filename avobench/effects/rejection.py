"""Events that a detector does not record: others are drawn in their place."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Simulate

MAX_ROUNDS = 200
"""Rounds of rejection: of a detector that records one event in ten, all but 1e-9 have been recorded by then."""
DRAWN = 12
"""Draws for one recorded event, at most and on average: enough where one in ten is recorded."""
FEW = 100
"""What fewer events count as in that average."""


def accepted(
    simulate: Simulate,
    theta: NDArray[np.float64],
    keep: Callable[[NDArray, NDArray[np.intp]], NDArray[np.float64]],
    rng: np.random.Generator,
) -> NDArray:
    """Events that a detector records: drawn anew, row by row, until recorded: theta (n, p) -> (n, d).

    `keep(x, rows)` is the chance that the events x, of these rows of theta, are recorded. Where a value is missing,
    and it is NaN, it is that of the others on average: a selection does not change how often values are missing. What a
    detector never records cannot be waited for: the event of the last round stays, recorded or not.
    """
    x = simulate(theta, rng)
    rows, left = np.arange(len(theta)), DRAWN * max(len(theta), FEW)
    for _ in range(MAX_ROUNDS):
        chance = keep(x[rows], rows)
        if (missing := np.isnan(chance)).any():
            chance = np.where(missing, chance[~missing].mean() if not missing.all() else 1.0, chance)
        rows = rows[rng.random(len(rows)) >= chance]
        left -= len(rows)
        if len(rows) == 0 or left < 0:
            break
        x[rows] = simulate(theta[rows], rng)
    return x
