"""ABC by rejection from events that were simulated before; nothing is simulated.

Thetas are drawn from the prior, and for each a set of the events around it. Kept are the thetas whose sets are nearest
to the observed events, by the linear regression of theta on the summaries (Fearnhead and Prangle, J. R. Stat. Soc. B 74
(2012) 419). A local linear regression moves them to where their summaries would be the observed one (Beaumont, Zhang,
Balding, Genetics 162 (2002) 2025). The next round does the same in a box around what this one has found.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, logit

from avobench.methods.contract import Estimate, TracePoint, WeightedSample
from avobench.methods.regression import STRENGTHS
from avobench.tasks import Box, Task
from avobench.tasks.prior import Distributed
from avobench.tasks.sample import SampleTask

ROUNDS = 3
"""The third box hardly differs from the second."""
SETS = 1000
"""Sets of events of a round, each at a theta of its own."""
KEPT = 250
"""So many of them, those nearest to the observed events, are kept."""
SPREADS = 4.0
"""The next round's box reaches so many standard deviations from the mean."""
AROUND = 2.0
"""It reaches so many distances between thetas of the sample at least: what is learnt from too few is their noise."""


def rejection(
    sample: SampleTask, task: Task, x_observed: NDArray, rng: np.random.Generator, tell: Callable[[int], None]
) -> Estimate:
    """The posterior behind observed events (N, d) of a `task` whose events are those of a sample.

    The noise of the sample is that of M events at a theta. So a set has N M / (N + M) events, whose noise is that of
    both. `tell` is told the sets so far.
    """
    box, observed, trace = sample.prior, task.summary(x_observed), []
    for begun in range(0, ROUNDS * SETS, SETS):
        theta, summaries = drawn(sample.prior, box, rng), []
        for made, one in enumerate(theta, start=begun + 1):
            noise = sample.around(one) @ (1 / sample.sizes) / sample.worth
            size = max(1, round(1 / (1 / len(x_observed) + noise)))
            summaries.append(task.summary(task.simulate(np.tile(one, (size, 1)), rng)))
            tell(made)
        points, weights = adjusted(theta, np.array(summaries), observed, sample.prior)
        mean = weights @ points
        std = np.sqrt(weights @ (points - mean) ** 2)
        trace.append(TracePoint(len(sample.events), mean, std))
        half = np.maximum(SPREADS * std, AROUND * sample.spacing * sample.prior.width)
        low, high = np.maximum(mean - half, sample.prior.low), np.minimum(mean + half, sample.prior.high)
        box = Box(tuple(low), tuple(high))
    return Estimate(
        mean, "mean of the posterior", "posterior", mean, std, trace, sample=WeightedSample(points, weights)
    )


def drawn(prior: Box, box: Box, rng: np.random.Generator) -> NDArray[np.float64]:
    """SETS draws from what a prior has within a box (SETS, p)."""
    if not isinstance(prior, Distributed):
        return box.sample(SETS, rng)
    return prior.at(rng.uniform(*prior.shares(np.array([box.low, box.high])), (SETS, prior.dim)))


def adjusted(
    theta: NDArray[np.float64], summaries: NDArray[np.float64], observed: NDArray[np.float64], prior: Box
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The KEPT of theta (n, p) with summaries (n, k) nearest to the observed one (k,), adjusted: (m, p), (m,).

    The second are their weights, of sum 1, by the kernel of Epanechnikov. The regression is of the logit of theta in
    the prior, so that none leaves it.
    """
    from sklearn.linear_model import RidgeCV

    u = logit(np.clip((theta - prior.low) / prior.width, 1e-12, 1 - 1e-12))
    spread = summaries.std(axis=0)
    away = (summaries - observed) / np.where(spread > 0, spread, 1)
    away = away @ np.atleast_2d(RidgeCV(STRENGTHS).fit(away, u).coef_).T
    distance = np.sqrt((away**2 / away.var(axis=0)).sum(axis=1))
    *nearest, next_one = np.argsort(distance)[: KEPT + 1]
    weights = 1 - (distance[nearest] / distance[next_one]) ** 2
    root, lines = np.sqrt(weights)[:, None], np.column_stack([np.ones(KEPT), away[nearest]])
    slope = np.linalg.lstsq(root * lines, root * u[nearest], rcond=None)[0][1:]
    moved = prior.low + prior.width * expit(u[nearest] - away[nearest] @ slope)
    return moved, weights / weights.sum()
