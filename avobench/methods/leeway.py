"""The parameters that the events leave open, and the best estimate there: the posterior over the whole prior box.

The polish finds one point where the simulated means agree with the observed ones. Where a combination of parameters is
open there are many, on a curve or a surface through the box, and the polish ends at the one nearest to the prior's
centre. Best on average is the mean of the posterior; among the points that agree, the one nearest to that mean.

Nothing is simulated for it: the means as functions of theta are fitted over the box to the events that there are. That
is coarser than the polish, so it says which of the points that agree is best, and the polish from there where exactly
they are.
"""

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import qmc

from avobench.methods.polish import SIGNIFICANT, Fold, Polished, ridged_inverse
from avobench.tasks import Box
from avobench.tasks.prior import Distributed

OPEN = 0.5
"""Standard error of a combination of parameters, in standard deviations of the prior, above which it is open."""
MOST_PARAMETERS = 3
"""Largest number of parameters. With more, the points of the box lie too far apart to locate the posterior."""
LOG_POINTS = 16
"""Logarithm to base 2 of the number of points in the box: a Sobol sequence needs a power of two."""
LEAST_POINTS = 200
"""Least effective number of points in the posterior, which is widened to hold them by a power of the likelihood."""
DEGREE = 4
"""Degree of the polynomial in theta that describes the means over the box; 2 to 5 do alike on weinberg."""
EDGE = np.sqrt(3)
"""Half the width of the prior box, in its standard deviations."""
FAR = 20.0
"""Squared standard errors for each combination of features, beyond those of the best point, that rule a point out."""
STANDARD_ERROR = np.exp(-0.5)
"""Value of a Gaussian at one standard deviation, in units of its maximum."""


def is_open(answer: Polished, prior: Box | None = None) -> bool:
    """Tell whether a combination of parameters is open: nearly as uncertain as the prior, which is uniform where None.

    Where another prior is as narrow as what the events tell, that alone does not make it open.
    """
    wide = bool(np.linalg.eigvalsh(answer.covariance)[-1] > OPEN**2)
    return wide and not (isinstance(prior, Distributed) and answer.significance > SIGNIFICANT)


def leaves_open(answer: Polished, prior: Box | None = None) -> bool:
    """Tell whether a combination is open of so few parameters that the best of all answers can be looked for."""
    return len(answer.mean) <= MOST_PARAMETERS and is_open(answer, prior)


def doubt_of(answer: Polished, prior: Box) -> str:
    """Say why the answer may be wrong, or "": no convergence, no information, or events that may tell unseen things.

    The last is where they may tell more than a quarter of what a prior does that is not uniform.
    """
    if not answer.converged:
        return "the fit did not converge, so the estimate is its last step"
    if is_open(answer, prior) and not leaves_open(answer):
        return "the events determine almost nothing about one combination of the parameters"
    if not isinstance(prior, Distributed) or answer.hidden < OPEN**2:
        return ""
    return (
        "over so narrow a prior it is not seen how the events depend on theta, so that what they tell may be missing: "
        "give the task a support that is wider than the prior, or allow more simulated events"
    )


class Leeway:
    """The posterior of theta in standardised coordinates, given what the folds hold.

    The points (n, p) fill the prior evenly, and their weights (n,) sum to 1. The prior is uniform where None.
    """

    def __init__(self, folds: Sequence[Fold], prior: Box | None = None) -> None:
        unit = qmc.Sobol(folds[0].u.shape[1], scramble=False).random_base2(LOG_POINTS)
        if isinstance(prior, Distributed):
            self.points = (prior.at(unit) - prior.mean) / prior.std
        else:
            self.points = EDGE * (2 * unit - 1)
        self.weights = tempered(log_likelihood(folds, self.points))

    def best(self, scale: NDArray[np.float64]) -> NDArray[np.float64]:
        """The point (p,) of least expected loss among those that agree with the observed means to a standard error.

        The loss is the squared error, summed over parameters in units of 1 / scale (p,).
        """
        agree = self.points[self.weights > STANDARD_ERROR * self.weights.max()]
        return agree[(((agree - self.weights @ self.points) * scale) ** 2).sum(axis=1).argmin()]

    def error(self, mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """The root of the expected squared error of an estimate (p,), for each parameter: (p,)."""
        return np.sqrt(self.weights @ (self.points - mean) ** 2)

    def covariance(self, mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """The expected products of the errors of an estimate (p,): (p, p)."""
        away = self.points - mean
        return (self.weights * away.T) @ away


def log_likelihood(folds: Sequence[Fold], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The logarithm of the likelihood of the observed means at each point (n, p), up to a constant: (n,).

    Where one combination of p parameters is open, p - 1 are told at most, so as many combinations of features are
    compared, of all folds together: those that depend most on theta. A single parameter is told by one, if by little.
    More of them would tell points apart that are alike: two that are fitted with different noise agree with the
    observed means on two curves, and both would be believed only where these happen to cross. They only rule out what
    is far from agreement. Noise alone, of k features fitted with m terms, gives the scatter of the fitted means
    eigenvalues of up to (m^(1/2) + k^(1/2))^2 (Marchenko, Pastur, Mathematics of the USSR-Sbornik 1 (1967) 457);
    combinations that show no more are left out.
    """
    values, fits = polynomial(points), [_Fit.of(fold) for fold in folds]
    coefficients, gram = np.hstack([fit.coefficients for fit in fits]), np.mean([fit.gram for fit in fits], axis=0)
    scatter = coefficients.T @ (gram - np.outer(gram[0], gram[0]) / gram[0, 0]) @ coefficients
    signal, axes = np.linalg.eigh(scatter)
    significant = signal > SIGNIFICANT * (np.sqrt(len(gram)) + np.sqrt(len(signal))) ** 2
    axes = axes[:, significant][:, ::-1]
    variance = np.zeros((len(points), axes.shape[1]))
    parts = np.split(axes, np.cumsum([fit.coefficients.shape[1] for fit in fits])[:-1])
    for fold, fit, part in zip(folds, fits, parts, strict=True):
        of_fit = np.einsum("ij,ij->i", values @ np.linalg.pinv(fit.gram, hermitian=True), values)
        variance += np.outer(1 / fold.num_observations + of_fit, (part**2).sum(axis=0))
    distance, compared = (values @ coefficients @ axes) ** 2 / variance, max(points.shape[1] - 1, 1)
    total = distance.sum(axis=1)
    far = total > max(total.min() + FAR * significant.sum(), np.partition(total, LEAST_POINTS)[LEAST_POINTS])
    return np.where(far, -np.inf, -(np.log(variance) + distance)[:, :compared].sum(axis=1) / 2)


class _Fit(NamedTuple):
    """Simulated minus observed means as a polynomial in theta, of features with unit covariance."""

    gram: NDArray[np.float64]
    """Gram matrix of the terms (m, m); its inverse is the covariance of each feature's coefficients."""
    coefficients: NDArray[np.float64]

    @classmethod
    def of(cls, fold: Fold) -> "_Fit":
        terms = polynomial(fold.u)
        gram = terms.T @ terms
        coefficients, inverse = np.linalg.pinv(gram, hermitian=True) @ (terms.T @ fold.synthetic), fold.inverse
        if not fold.is_known:
            inverse = ridged_inverse(np.atleast_2d(np.cov(fold.synthetic - terms @ coefficients, rowvar=False)))
        return cls(gram, coefficients @ np.linalg.cholesky(inverse))


def tempered(log_p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights (n,) that sum to 1, of the largest power up to 1 of p (n,) that LEAST_POINTS effective points share."""

    def weights(power: float) -> NDArray[np.float64]:
        return np.exp(power * log_p - logsumexp(power * log_p))

    def are_enough(power: float) -> bool:
        return 1 / (weights(power) ** 2).sum() >= LEAST_POINTS

    if are_enough(1.0):
        return weights(1.0)
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if are_enough(middle) else (low, middle)
    return weights(low)


def polynomial(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """All products of up to DEGREE coordinates, in units of the box: (n, p) -> (n, m)."""
    z = u / EDGE
    which = [c for degree in range(DEGREE + 1) for c in combinations_with_replacement(range(z.shape[1]), degree)]
    return np.stack([z[:, list(c)].prod(axis=1) for c in which], axis=1)
