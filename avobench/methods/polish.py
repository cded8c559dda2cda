"""The polish, a phase of `avo`: discriminator and proposal brought to rest on the events already simulated."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

WIDTH = 1.25
"""Of the kernel over theta, in standard deviations of the proposal. A wider one takes in more events, which a quadratic
describes less well: on poisson the answer moves by less than 0.1 standard errors up to 1.5, by several at 2."""
REACH = 3.0
"""Events beyond so many kernel widths are left out: their weight is below 1.2 % of that of an event at the mean."""
CONSTANT = 1e-6
"""A feature that varies by less than this share of the one that varies most is constant to single precision."""
RIDGE = 1e-4
"""Share of its variance that is added to each feature's, for features that are nearly copies of each other."""
SIGNIFICANT = 3.0
"""Information along a combination of parameters counts where it is so many times what mere noise would show: noise
itself is a chi-squared over its degrees of freedom, one a feature, and stays well below."""
MAX_STEPS = 50
"""Several times what it takes where it converges; where it does not, the estimate's message says so."""
STANDS_STILL = 1e-3
"""The polish ends with a step below this share of the standard error, in 3 to 10 steps as a rule."""


@dataclass(frozen=True)
class Polished:
    mean: NDArray[np.float64]
    """(p,)"""
    covariance: NDArray[np.float64]
    """Of the mean (p, p), of the prior's order along a direction that the events leave open."""
    num_steps: int
    converged: bool

    @property
    def error(self) -> NDArray[np.float64]:
        """Standard error of the mean (p,)."""
        return np.sqrt(np.diag(self.covariance))


class Fold:
    """Events on which a discriminator was not trained, as its last layer sees them.

    real (N, k) of the observed events and synthetic (n, k) of those simulated at u (n, p); see `polish`.
    """

    def __init__(self, real: NDArray[np.float32], synthetic: NDArray[np.float32], u: NDArray[np.float64]) -> None:
        scale = real.std(axis=0, dtype=float)
        kept = scale > CONSTANT * scale.max()
        self.kept, self.shift, self.scale = kept, real.mean(axis=0, dtype=float)[kept], scale[kept]
        real = self._standardised(real)
        covariance = (real.T @ real).astype(float) / len(real)
        self.inverse = np.linalg.inv(covariance + RIDGE * np.eye(len(covariance)))
        self.num_observations = len(real)
        self.synthetic, self.u = self._standardised(synthetic), u

    def _standardised(self, phi: NDArray[np.float32]) -> NDArray[np.float32]:
        return ((phi[:, self.kept] - self.shift) / self.scale).astype(np.float32)

    def add(self, synthetic: NDArray[np.float32], u: NDArray[np.float64]) -> None:
        """Take in more simulated events."""
        self.synthetic = np.concatenate([self.synthetic, self._standardised(synthetic)])
        self.u = np.concatenate([self.u, u])

    def at(
        self, mean: NDArray[np.float64], width: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Gradient (p,) in the proposal's mean (p,), information (p, p), and what information mere noise would show.

        They are those of all events of the fold together; width (p,) is that of the kernel.
        """
        z = (self.u - mean) / width
        distance = (z**2).sum(axis=1)
        near = np.flatnonzero(distance < REACH**2)
        terms = quadratic(z[near])
        weighted = terms * np.exp(-distance[near] / 2)[:, None]
        rows = (np.linalg.pinv(terms.T @ weighted, hermitian=True) @ weighted.T)[: 1 + len(mean)]  # value and slopes
        fit = (rows.astype(np.float32) @ self.synthetic[near]).astype(float)
        difference, jacobian, slopes = -fit[0], fit[1:] / width[:, None], rows[1:] / width[:, None]  # observed mean: 0
        num_effective = 1 / (1 / self.num_observations + (rows[0] ** 2).sum())
        gradient, information = np.split(
            jacobian @ self.inverse @ np.column_stack([difference, jacobian.T]), [1], axis=1
        )
        noise = len(difference) * slopes @ slopes.T
        return num_effective * gradient[:, 0], num_effective * information, num_effective * noise


def polish(
    folds: list[Fold],
    mean: NDArray[np.float64],
    std: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> Polished:
    """Where the last layer of d and the mean of q stand still together.

    What the last layer of d sees is phi. The proposal's mean and std (p,) are where to begin and how far to look; the
    answer lies within low and high (p,). The prior has mean 0 and variance 1. Each fold has its own d, and events on
    which the layers before the last were not trained: those know the events they were trained on too well.

    Near the solution d is close to 1/2, where the cross-entropy over the last layer is quadratic: its optimum is
    Fisher's linear discriminant w = C^-1 (E[phi | real] - E[phi | mean]) with C the covariance of phi, and
    f = log(1 - d) is a constant minus w . phi / 2. The score-function gradient of E[f] in the mean is then -J w / 2,
    with J (p, k) the gradient of E[phi | mean]. Divided by the information J C^-1 J^T it is a natural gradient (Amari
    1998), and one step of it goes all the way if E[phi] is linear.

    E[phi | mean] and J are a least-squares fit of phi by a quadratic in u - mean, weighted by a Gaussian kernel: the
    score-function estimate with a baseline that also removes what the proposal's width adds. The prior, as a Gaussian
    of its moments, moves theta by far less than a standard error where it is identified, and decides where it is not.
    """
    width = WIDTH * std
    for step in range(1, MAX_STEPS + 1):
        parts = zip(*(fold.at(mean, width) for fold in folds), strict=True)
        gradient, information = significant(*(sum(part) for part in parts))
        precision = information + np.eye(len(mean))
        move = np.linalg.solve(precision, gradient - mean)
        covariance = np.linalg.inv(precision)
        mean = np.clip(mean + move / max(1, np.abs(move / width).max()), low, high)
        if (np.abs(move) < STANDS_STILL * np.sqrt(np.diag(covariance))).all():
            return Polished(mean, covariance, step, converged=True)
    return Polished(mean, covariance, MAX_STEPS, converged=False)


def significant(
    gradient: NDArray[np.float64], information: NDArray[np.float64], noise: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The parts of gradient (p,) and information (p, p) along what is more than noise (p, p).

    Where E[phi] does not depend on a combination of the parameters, its Jacobian is noise, and so is the information
    that it seems to hold; left in, this would outweigh the prior and send the mean anywhere along a degeneracy.
    """
    value, axes = eigh(information, noise + np.finfo(float).tiny * np.eye(len(noise)))  # axes.T @ noise @ axes = 1
    value, axes = value[value > SIGNIFICANT], axes[:, value > SIGNIFICANT]
    back = noise @ axes
    return back @ (axes.T @ gradient), back * value @ back.T


def quadratic(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """1, z_i, and z_i z_j for i <= j: (n, p) -> (n, (p + 1)(p + 2) / 2)."""
    i, j = np.triu_indices(z.shape[1])
    return np.hstack([np.ones((len(z), 1)), z, z[:, i] * z[:, j]])
