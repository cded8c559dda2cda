"""Counts of an observation longer or shorter than the simulator's."""

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Simulate

LONGEST = 30.0
"""Times the simulator's own exposure; the tails of a distribution of rates are cut there."""


def exposed(
    simulate: Simulate, theta: NDArray[np.float64], g: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Counts over g times the exposure: whole exposures are added, a part of one is thinned: g (n,) -> (n, 1).

    For a Poisson count this is exactly the count at g times the rate, and it asks nothing about theta's meaning.
    """
    g = np.minimum(g, LONGEST)
    x = simulate(theta, rng)
    x[:, 0] = np.where(g < 1, rng.binomial(x[:, 0], np.minimum(g, 1)), x[:, 0])
    rows, left = np.flatnonzero(g > 1), g[g > 1] - 1
    while len(rows):
        x[rows, 0] += rng.binomial(simulate(theta[rows], rng)[:, 0], np.minimum(left, 1))
        rows, left = rows[left > 1], left[left > 1] - 1
    return x
