"""The regression adjustment of ABC moves accepted parameters to where their summaries would be the observed one.

It is that of Beaumont, Zhang, Balding, Genetics 162 (2002) 2025. A summary has more components than parameters were
tried, so the regression is a ridge regression, whose strength leave-one-out errors choose.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Box

STRENGTHS = np.geomspace(1e-4, 1e4, 25)
"""Strengths of the ridge to choose from, for standardised summaries: from next to no ridge to next to no slope."""


class Evaluation(NamedTuple):
    """The summary of the events that were simulated at one theta."""

    theta: NDArray[np.float64]
    summary: NDArray[np.float64]
    simulations: int
    """Number of events simulated until then, those of this theta included."""


def regressed(
    theta: NDArray[np.float64],
    weights: NDArray[np.float64],
    tried: Sequence[Evaluation],
    observed: NDArray[np.float64],
    box: Box,
) -> NDArray[np.float64]:
    """The weighted mean (p,) of adjusted parameters, within the box.

    The accepted parameters are theta (n, p), with weights (n,) that sum to 1. The slope is learned from all that was
    tried, since what was refused tells of it as well.
    """
    from sklearn.linear_model import RidgeCV

    tried_theta = np.array([one.theta for one in tried])
    summaries = np.array([one.summary for one in tried])
    scale = summaries.std(axis=0)
    kept = scale > 0
    standard = (summaries[:, kept] - summaries[:, kept].mean(axis=0)) / scale[kept]
    target = (observed[kept] - summaries[:, kept].mean(axis=0)) / scale[kept]
    ridge = RidgeCV(STRENGTHS).fit(standard, tried_theta / box.width)
    slope = np.atleast_2d(ridge.coef_)
    place = {point.tobytes(): i for i, point in enumerate(tried_theta)}
    accepted = np.array([standard[place[point.tobytes()]] for point in np.ascontiguousarray(theta)])
    adjusted = theta + (target - accepted) @ slope.T * box.width
    return np.clip(weights @ adjusted, box.low, box.high)
