"""Counts of an observation longer or shorter than the simulator's."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Simulate
from avobench.effects.counts.feature import whole

LONGEST = 30.0
"""Times the simulator's own exposure; the tails of a distribution of rates are cut there."""


def exposed(
    simulate: Simulate,
    theta: NDArray[np.float64],
    g: NDArray[np.float64],
    rng: np.random.Generator,
    columns: Sequence[int] = (0,),
) -> NDArray:
    """Events whose counts in `columns` are over g times the exposure: g (n,) -> (n, d).

    Whole exposures are added, a part of one is thinned. For a Poisson count this is exactly the count at g times the
    rate, and it asks nothing about theta's meaning.
    """
    g, at = np.minimum(g, LONGEST), list(columns)
    x = simulate(theta, rng)
    x[:, at] = np.where(g[:, None] < 1, rng.binomial(whole(x[:, at]), np.minimum(g, 1)[:, None]), x[:, at])
    rows, left = np.flatnonzero(g > 1), g[g > 1] - 1
    while len(rows):
        more = whole(simulate(theta[rows], rng)[:, at])
        x[np.ix_(rows, at)] += rng.binomial(more, np.minimum(left, 1)[:, None])
        rows, left = rows[left > 1], left[left > 1] - 1
    return x
