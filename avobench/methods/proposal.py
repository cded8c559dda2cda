"""The proposal q(theta | psi) of AVO: a Gaussian with a diagonal covariance, truncated to the support."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfcx, log_ndtr, ndtr, ndtri, ndtri_exp

from avobench.tasks import Box
from avobench.tasks.prior import Distributed

SQRT_2PI = np.sqrt(2 * np.pi)


class TruncatedGaussian:
    """q(theta | psi) with psi = (mean, log std) of shape (2, p), in standardised coordinates.

    The coordinates are u = (theta - mean of the prior) / (standard deviation of the prior): the box of a uniform prior
    becomes [-sqrt 3, sqrt 3], so that the paper's "zero mean and unit variance" has the moments of the prior.
    Every parameter is truncated to the support, where the simulator is defined; score and entropy contain the
    normalisation Z, so they are those of the distribution that is sampled.
    """

    def __init__(self, prior: Box, support: Box) -> None:
        self.center, self.scale, self.support = prior.mean, prior.std, support
        self.low, self.high = self.to_standard(np.array(support.low)), self.to_standard(np.array(support.high))
        self.bounds = self.low, self.high
        # A uniform prior is searched as wide as it is; another may be as narrow as what the events tell, or narrower.
        self.widest = (self.high - self.low) / np.sqrt(12) if isinstance(prior, Distributed) else None

    def to_standard(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return (theta - self.center) / self.scale

    def to_raw(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip(u * self.scale + self.center, self.support.low, self.support.high)  # rounding at the edge

    def sample(self, psi: NDArray[np.float64], n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draws by inversion of the distribution function, exact far in both tails: psi (2, p) -> u (n, p)."""
        mean, std, a, b = self._standard_bounds(psi)
        uniform, (near, far) = rng.uniform(size=(n, len(mean))), _distances(a, b)
        ratio = np.exp(log_ndtr(-far) - log_ndtr(-near))
        in_tail = ndtri_exp(log_ndtr(-near) + np.log(ratio + uniform * (1 - ratio)))  # as a logarithm: ndtr underflows
        z = np.where(near > 0, np.where(a > 0, -in_tail, in_tail), ndtri(ndtr(a) + uniform * (ndtr(b) - ndtr(a))))
        return np.clip(mean + std * z, self.low, self.high)

    def around(
        self, mean: NDArray[np.float64], root: NDArray[np.float64], n: int, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Draws within the support from a Gaussian of this mean (p,) and root (p, p) of its covariance: (n, p)."""
        u = np.empty((0, len(mean)))
        while len(u) < n:
            more = mean + rng.standard_normal((n, len(mean))) @ root.T
            u = np.concatenate([u, more[((more >= self.low) & (more <= self.high)).all(axis=1)]])
        return u[:n]

    def score(self, psi: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient of log q(u | psi) with respect to psi: u (n, p) -> (n, 2, p)."""
        mean, std, a, b = self._standard_bounds(psi)
        z = (u - mean) / std
        first, second = _moments(a, b)
        return np.stack([(z - first) / std, z**2 - second], axis=1)

    def log_density(self, psi: NDArray[np.float64], u: NDArray[np.float64]) -> NDArray[np.float64]:
        """log q(u | psi) per parameter: u (n, p) within the support -> (n, p)."""
        mean, std, a, b = self._standard_bounds(psi)
        near, _ = _distances(a, b)
        return (near**2 - ((u - mean) / std) ** 2) / 2 - np.log(std * SQRT_2PI * _scaled(a, b)[0])

    def entropy_gradient(self, psi: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient of the entropy H = log(std Z sqrt(2 pi)) + E[z^2] / 2, summed over parameters: (2, p).

        With m_k = E[z^k] of the truncated z, dH/d mean = (m_3 - m_1 m_2) / (2 std) and
        dH/d log std = (m_4 - m_2^2) / 2: both are the covariance of the score with z^2 / 2.
        """
        _, std, a, b = self._standard_bounds(psi)
        (m1, m2), (z, density_a, density_b) = _moments(a, b), _scaled(a, b)
        m3 = 2 * m1 + (a**2 * density_a - b**2 * density_b) / z
        m4 = 3 * m2 + (a**3 * density_a - b**3 * density_b) / z
        return np.stack([(m3 - m1 * m2) / (2 * std), (m4 - m2**2) / 2])

    def mode(self, psi: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip(psi[0], self.low, self.high)

    def mean_and_std(self, psi: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean and standard deviation of the truncated density: psi (2, p) -> u (p,), (p,)."""
        mean, std, a, b = self._standard_bounds(psi)
        m1, m2 = _moments(a, b)
        return mean + std * m1, std * np.sqrt(m2 - m1**2)

    def _standard_bounds(self, psi: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        mean, std = psi[0], np.exp(psi[1])
        return mean, std, (self.low - mean) / std, (self.high - mean) / std


def _distances(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The distances of the nearest and the farthest point of [a, b] from the mean, in standard deviations."""
    return np.maximum(np.maximum(a, -b), 0), np.maximum(-a, b)


def _scaled(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """The standard Gaussian's probability Z of [a, b] and its density at a and at b, times exp(near^2 / 2).

    With the mean outside, all three underflow from 38 standard deviations on; their ratios do not.
    """
    near, far = _distances(a, b)
    density_a, density_b = (np.exp((near**2 - bound**2) / 2) / SQRT_2PI for bound in (a, b))
    tail = (erfcx(near / np.sqrt(2)) - np.exp((near**2 - far**2) / 2) * erfcx(far / np.sqrt(2))) / 2
    return np.where(near > 0, tail, ndtr(b) - ndtr(a)), density_a, density_b


def _moments(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """E[z] and E[z^2] of a standard Gaussian truncated to [a, b]."""
    z, density_a, density_b = _scaled(a, b)
    return (density_a - density_b) / z, 1 + (a * density_a - b * density_b) / z
