"""The posterior of an observation of many independent rows: the prior times a factor a row, learned by a network.

The rows are events, or summaries of parts of the observation. The posterior of all of them is narrow beside the prior,
so its sample is drawn in steps, each with more of the rows and from a mixture fitted to the sample of the one before:
population Monte Carlo (Cappé et al., Journal of Computational and Graphical Statistics 13 (2004) 907).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, qmc

from avobench.methods.contract import WeightedSample
from avobench.tasks import Box

if TYPE_CHECKING:
    from torch import Tensor

GROWTH = 4
"""Factor by which the number of rows grows from step to step: the posterior then has half the width."""
FIRST_POINTS = 512
"""Points of a Sobol sequence over the prior box in the first step; a power of two."""
POINTS = 64
"""Points of each later step, whose mixture is near the posterior already."""
WIDER = 1.2
"""Width of the kernels in that of Silverman's rule: the next posterior must lie within the mixture that its sample is
drawn from."""
EVALUATIONS = 2**17
"""Pairs of a row and a theta in one pass through the network: 50 MiB with 100 hidden nodes."""
LEAST_WIDTH = 1e-6
"""Least width of the mixture's kernels in widths of the box, so that its covariance stays regular."""
SEARCH_STEPS = 30
"""Steps of the search for the mode, which begins at the best point of the last sample: a few suffice."""

LogFactors = "Callable[[Tensor, Tensor], Tensor]"
"""A function that gives the logarithm of each row's factor at a theta: (p,), (n, k) -> (n,), differentiable in theta.
"""


@dataclass(frozen=True)
class Posterior:
    """The mode, mean and standard deviation of a posterior, each (p,), in raw units, and points of it."""

    mode: NDArray[np.float64]
    mean: NDArray[np.float64]
    std: NDArray[np.float64]
    sample: WeightedSample


def posterior(
    log_factors: LogFactors, rows: NDArray[np.float32], box: Box, rng: np.random.Generator, first_rows: int
) -> Posterior:
    """The posterior of theta in a box with a uniform prior, given rows (n, k).

    The first step uses `first_rows` of the rows: its posterior should be about a tenth as wide as the box, which the
    points of that step resolve.
    """
    sums = _Sums(log_factors, box)
    theta = qmc.Sobol(box.dim, rng=rng).random(FIRST_POINTS)
    log_q = np.zeros(len(theta))
    order = rng.permutation(len(rows))
    used = min(first_rows, len(rows))
    while True:
        kept = rows[order[:used]]
        log_p = sums(theta, kept)
        weights = np.exp(log_p - log_q - logsumexp(log_p - log_q))
        if used == len(rows):
            break
        used = min(GROWTH * used, len(rows))
        theta, log_q = _drawn(theta, weights, rng)
    mean = weights @ theta
    std = np.sqrt(weights @ (theta - mean) ** 2)
    mode = sums.mode(theta[log_p.argmax()], kept)
    sample = WeightedSample(sums.raw(theta), weights)
    return Posterior(sums.raw(mode), sums.raw(mean), std * box.width, sample)


def _drawn(
    theta: NDArray[np.float64], weights: NDArray[np.float64], rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Draws from a Gaussian kernel density of a weighted sample within the unit box, and its log density there.

    The kernels are those of the whole sample's covariance: (m, p), (m,) -> (n, p), (n,). The density is not normalised.
    """
    dim, size = theta.shape[1], 1 / (weights**2).sum()
    centred = theta - weights @ theta
    covariance = (weights[:, None] * centred).T @ centred + LEAST_WIDTH**2 * np.eye(dim)
    kernel = (WIDER * (size * (dim + 2) / 4) ** (-1 / (dim + 4))) ** 2 * covariance
    drawn = np.empty((0, dim))
    while len(drawn) < POINTS:
        centres = theta[rng.choice(len(theta), 4 * POINTS, p=weights)]
        new = centres + rng.multivariate_normal(np.zeros(dim), kernel, len(centres))
        drawn = np.concatenate([drawn, new[((new >= 0) & (new <= 1)).all(axis=1)]])[:POINTS]
    near = weights > weights.max() * np.finfo(float).eps
    log_kernels = multivariate_normal(np.zeros(dim), kernel).logpdf(drawn[:, None] - theta[near])
    return drawn, logsumexp(log_kernels.reshape(POINTS, -1), b=weights[near], axis=1)


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
