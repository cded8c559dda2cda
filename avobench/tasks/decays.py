"""Decay times: a task whose feature has no negative values, on which effects on such features are shown and checked.

It is no part of the benchmark, and so has no entry point.
"""

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.function import task


def _decays(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    return theta[:, 0] * rng.standard_exponential(len(theta))


DECAYS = task(
    _decays,
    prior={"lifetime": (1, 4)},
    units={"lifetime": "us"},
    features=("time",),
    feature_units={"time": "us"},
    name="decays",
)
