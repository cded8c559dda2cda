"""The posterior of an observation of many independent rows: the prior times a factor a row, learned by a network.

The rows are events, or summaries of parts of the observation. The posterior of all of them is narrow beside the prior,
so its sample is drawn in steps, each from a mixture fitted to the sample of the one before: population Monte Carlo
(Cappé et al., Journal of Computational and Graphical Statistics 13 (2004) 907). A step is to no more than its points
can carry: part of the geometric way to the posterior (Neal, Statistics and Computing 11 (2001) 125), such that a third
of the points count. Where a step arrives, the next one has more of the rows.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize
from scipy.spatial.distance import cdist
from scipy.special import logsumexp
from scipy.stats import qmc

from avobench.methods.contract import WeightedSample
from avobench.tasks import Box

if TYPE_CHECKING:
    from torch import Tensor

GROWTH = 4
"""Factor by which the number of rows grows from step to step: the posterior then has half the width."""
FIRST_POINTS = 512
"""Points of a Sobol sequence over the prior box in the first step; a power of two."""
ROWS_OF_A_STEP = 2**23
"""Points times rows of a later step: it has as many points as the first one, or fewer where that were more."""
LEAST_POINTS = 128
"""Points of a step, however many rows there are: of fewer no kernels are told."""
LEAST_SHARE = 1 / 3
"""Least effective number of points of a step in its points: some forty then tell the mixture of the next one."""
MOST_STEPS = 100
"""Steps after which the sample is told with a doubt; five parameters take twenty or thirty."""
NEIGHBOURS = 4
"""Effective number of neighbours of which a kernel has the covariance, for each element of that and one more."""
SHARPER = 0.5
"""Factor of that covariance: the density is then not much wider than the sample, in ten dimensions too."""
EVALUATIONS = 2**17
"""Pairs of a row and a theta in one pass through the network: 50 MiB with 100 hidden nodes."""
LEAST_WIDTH = 1e-6
"""Least width of the sample in widths of the box, so that its covariance stays regular."""
LEAST_VARIANCE = 1e-6
"""Least variance of a kernel in that of the sample, likewise."""
SEARCH_STEPS = 30
"""Steps of the search for the mode, which begins at the best point of the last sample: a few suffice."""

LogFactors = "Callable[[Tensor, Tensor], Tensor]"
"""The logarithm of each row's factor at a theta, differentiable in it: (p,), (n, k) -> (n,)."""


@dataclass(frozen=True)
class Posterior:
    """The mode, mean and standard deviation of a posterior, each (p,), in raw units, and points of it."""

    mode: NDArray[np.float64]
    mean: NDArray[np.float64]
    std: NDArray[np.float64]
    sample: WeightedSample
    doubt: str = ""
    """What is wrong with the sample, where something is."""


def posterior(
    log_factors: LogFactors, rows: NDArray[np.float32], box: Box, rng: np.random.Generator, first_rows: int
) -> Posterior:
    """The posterior of theta in a box with a uniform prior, given rows (n, k); the first steps use `first_rows`."""
    sums = _Sums(log_factors, box)
    theta = qmc.Sobol(box.dim, rng=rng).random(FIRST_POINTS)
    log_q, doubt = np.zeros(len(theta)), ""
    order = rng.permutation(len(rows))
    used = min(first_rows, len(rows))
    for step in range(MOST_STEPS):
        kept = rows[order[:used]]
        log_p = sums(theta, kept)
        carried, weights = _carried(log_p, log_q)
        if carried == 1 and used == len(rows):
            break
        if step + 1 == MOST_STEPS:
            doubt = f"the sample of the posterior did not come to rest in {MOST_STEPS} steps"
            break
        used = min(GROWTH * used, len(rows)) if carried == 1 else used
        theta, log_q = _drawn(theta, weights, min(FIRST_POINTS, max(LEAST_POINTS, ROWS_OF_A_STEP // used)), rng)
    mean = weights @ theta
    std = np.sqrt(weights @ (theta - mean) ** 2)
    mode = sums.mode(theta[log_p.argmax()], rows)
    sample = WeightedSample(sums.raw(theta), weights)
    return Posterior(sums.raw(mode), sums.raw(mean), std * box.width, sample, doubt)


def _carried(log_p: NDArray[np.float64], log_q: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """The largest a up to 1 at which LEAST_SHARE of the points (n,) of q count in p^a q^(1-a), and their weights."""

    def weights(a: float) -> NDArray[np.float64]:
        log_weights = a * (log_p - log_q)
        return np.exp(log_weights - logsumexp(log_weights))

    def surplus(a: float) -> float:
        return 1 / (weights(a) ** 2).sum() - LEAST_SHARE * len(log_p)

    a = 1.0 if surplus(1.0) >= 0 else brentq(surplus, 0, 1, xtol=1e-12)
    return a, weights(a)


def _drawn(
    theta: NDArray[np.float64], weights: NDArray[np.float64], number: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Draws within the unit box from a kernel density of a weighted sample, and its log density there.

    (m, p), (m,) -> (number, p), (number,). Each kernel has the covariance of its own neighbours, so that a bent ridge
    and modes apart are followed (Givens and Raftery, JASA 91 (1996) 132). The box does not enter its norm.
    """
    dim = theta.shape[1]
    centred = theta - weights @ theta
    covariance = (weights[:, None] * centred).T @ centred + LEAST_WIDTH**2 * np.eye(dim)
    centres = np.flatnonzero(weights > weights.max() * np.finfo(float).eps)
    theta, weights = theta[centres], weights[centres]
    unit = np.linalg.solve(np.linalg.cholesky(covariance), theta.T).T
    nearest = cdist(unit, unit).argsort(axis=1)
    sums, squares = weights[nearest].cumsum(axis=1), (weights[nearest] ** 2).cumsum(axis=1)
    local = np.where(sums**2 / squares <= NEIGHBOURS * (1 + dim * (dim + 1) / 2), weights[nearest], 0)
    local /= local.sum(axis=1, keepdims=True)
    away = theta[nearest] - (local[:, :, None] * theta[nearest]).sum(axis=1, keepdims=True)
    kernels = np.einsum("mk,mki,mkj->mij", SHARPER * local, away, away)
    roots = np.linalg.cholesky(kernels + LEAST_VARIANCE * covariance)
    drawn = np.empty((0, dim))
    while len(drawn) < number:
        even = (np.arange(4 * number) + rng.random()) / (4 * number)
        chosen = rng.permutation(np.searchsorted(weights.cumsum() / weights.sum(), even).clip(max=len(theta) - 1))
        new = theta[chosen] + np.einsum("nij,nj->ni", roots[chosen], rng.standard_normal((len(chosen), dim)))
        drawn = np.concatenate([drawn, new[((new >= 0) & (new <= 1)).all(axis=1)]])[:number]
    scaled = np.einsum("mij,nmj->nmi", np.linalg.inv(roots), drawn[:, None] - theta)
    log_kernels = -(scaled**2).sum(axis=2) / 2 - np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    return drawn, logsumexp(log_kernels, b=weights, axis=1)


class _Sums:
    """The sum over rows of their log factors, as a function of theta in the unit box."""

    def __init__(self, log_factors: LogFactors, box: Box) -> None:
        self._log_factors, self._box = log_factors, box

    def raw(self, theta):
        return theta * self._box.width + np.array(self._box.low)

    def __call__(self, theta: NDArray[np.float64], rows: NDArray[np.float32]) -> NDArray[np.float64]:
        """theta (m, p), rows (n, k) -> (m,)."""
        import torch

        distinct, counts = _distinct(rows)
        with torch.no_grad():
            return np.array([float(self._sum(torch.as_tensor(one), distinct, counts)) for one in theta])

    def mode(self, theta: NDArray[np.float64], rows: NDArray[np.float32]) -> NDArray[np.float64]:
        """Where the sum is largest, searched from theta (p,)."""
        import torch

        distinct, counts = _distinct(rows)

        def descent(theta: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
            point = torch.tensor(theta, requires_grad=True)
            value = -self._sum(point, distinct, counts, backward=True) / len(rows)
            return float(value), -point.grad.numpy() / len(rows)

        options = {"maxiter": SEARCH_STEPS, "ftol": 1e-14, "gtol": 1e-8}  # of the mean over rows: far below its error
        return minimize(descent, theta, jac=True, bounds=[(0, 1)] * len(theta), method="L-BFGS-B", options=options).x

    def _sum(self, theta: "Tensor", rows: "Tensor", counts: "Tensor", backward: bool = False) -> float:
        """The sum at one theta (p,) in float64; with `backward` its gradient is added to that of theta."""
        import torch

        total = 0.0
        low, width = torch.tensor(self._box.low), torch.tensor(self._box.width)
        for part, number in zip(rows.split(EVALUATIONS), counts.split(EVALUATIONS), strict=True):
            raw = (theta * width + low).float()
            value = (self._log_factors(raw, part).double() * number).sum()
            if backward:
                value.backward()
            total += float(value.detach())
        return total


def _distinct(rows: NDArray[np.float32]) -> tuple["Tensor", "Tensor"]:
    """The distinct rows and how often each occurs, since counts repeat and need not be evaluated again."""
    import torch

    distinct, counts = np.unique(rows, axis=0, return_counts=True)
    if len(distinct) > len(rows) / 2:
        distinct, counts = rows, np.ones(len(rows))
    return torch.as_tensor(distinct), torch.as_tensor(counts, dtype=torch.float64)
