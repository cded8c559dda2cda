"""One number for any set of effects: how probable the measured summary is under a fitted model.

The measured mean m is normal about that of the model, with the covariance of the measurement and a term which says that
no shape of the catalogue is exactly right: each effect is wrong by a smooth share of what it does,

    m ~ N(s(theta, eta), C / N + sum over effects of d^2 diag(D) K diag(D)).

D is the change of the mean that adding the effect makes, theta following it, K a smooth correlation between bins, d the
share. Theta, eta and d are integrated over (Laplace), so that whatever is free pays for itself. That something is
missing which the catalogue does not have is a model too: the simulator, distorted smoothly by a share a of each bin,

    m ~ N(s(theta), C / N + a^2 diag(s) K diag(s)).

After M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, and D. J. C. MacKay, Neural Computation 4 (1992) 415.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.summary.target import Target, fixed

WRONG = (0.0, 0.03, 0.1)
"""Shares d by which a shape may be wrong, equally probable: some are right, some only of the right kind."""
SMOOTH = ((1 / 8, 0.7), (1 / 40, 0.3))
"""Lengths, as shares of a feature's range, over which a shape is wrong in the same way, and how much of it is so."""
DISTORTED = np.geomspace(0.003, 1, 12)
"""Shares a by which something unknown distorts the simulation: log-uniform, from what a million events would show."""
UNKNOWN = (1e-6, 1 / 40, 1 / 16, 1 / 8, 1 / 4)
"""Lengths over which it does so; the shortest for bins each by itself, as spikes and combs do."""
ANYWHERE = 0.1
"""Of the mean of all bins: what the unknown may add where nothing is expected."""
WEAKEST = 0.001
"""Of the range of a strength: log-uniform from there, since effects are weak more often than strong."""


@dataclass(frozen=True)
class Evidence:
    """Logarithm of the probability of the measured summary, up to what all models have in common."""

    value: float
    error: float
    """By simulation."""
    excess: float = 0.0
    """What a further effect might gain at most: half of what chi-squared exceeds its degrees of freedom by."""

    @property
    def at_least(self) -> float:
        """What counts: a fit that is known badly must not win by chance."""
        return self.value - self.error

    @property
    def at_most(self) -> float:
        """What it may be worth, for all that simulation leaves open."""
        return self.value + self.error


@dataclass(frozen=True)
class Scale:
    """What all evidences of one target share: where the summary's parts are alike."""

    target: Target

    @cached_property
    def wrong(self) -> NDArray[np.float64]:
        """K of the effects (K, K)."""
        return sum(share * self.target.summary.alike(length) for length, share in SMOOTH)

    @cached_property
    def unknown(self) -> list[NDArray[np.float64]]:
        """K of what the catalogue lacks, a length each."""
        return [self.target.summary.alike(length) for length in UNKNOWN]

    @cached_property
    def fixed(self) -> NDArray[np.float64]:
        """What no change of a model changes, such as the sum of all shares: (K, k)."""
        return fixed(self.target.cov)

    def whitened(
        self, change: NDArray[np.float64], alike: NDArray[np.float64], mean: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Covariance (r, r), where that of the measurement is 1, of a change (K,) that is wrong by a share of 1.

        What is fixed stays so: the sum of all shares is restored by a factor on the model's `mean` (K,).
        """
        weight = np.maximum(mean, 0)[:, None] * self.fixed
        restored = weight @ np.linalg.pinv(self.fixed.T @ weight) @ self.fixed.T
        w = self.target.whitening - restored.T @ self.target.whitening
        w = np.sqrt(self.target.num_events) * w * change[:, None]
        return w.T @ alike @ w

    def of(self, fit: Fit, path: Sequence[NDArray[np.float64]] = ()) -> Evidence:
        """Of a fitted model, with the means (K,) of the best fits before each of its effects was added: `path`."""
        if not path:
            return marginal(fit, np.ones(self.target.rank), None)
        changes = [after - before for before, after in pairwise([*path, fit.predicted])]
        spread = sum(self.whitened(change, self.wrong, fit.predicted) for change in changes)
        values, vectors = np.linalg.eigh(spread)
        found = [marginal(fit, 1 + d**2 * np.maximum(values, 0), vectors) for d in WRONG]
        value = float(logsumexp([one.value for one in found])) - np.log(len(WRONG))
        return replace(max(found, key=lambda one: one.value), value=value)

    def outside(self, null: Fit) -> float:
        """That what is missing is not in the catalogue, from the fit of the simulator as it is."""
        found = []
        for alike in self.unknown:
            share = np.maximum(null.predicted, 0) + ANYWHERE * null.predicted.mean()
            values, vectors = np.linalg.eigh(self.whitened(share, alike, null.predicted))
            found += [marginal(null, 1 + a**2 * np.maximum(values, 0), vectors).value for a in DISTORTED]
        return float(logsumexp(found)) - np.log(len(found))


def marginal(fit: Fit, variances: NDArray[np.float64], vectors: NDArray[np.float64] | None) -> Evidence:
    """Of a fit whose residual has these variances along these vectors (None for the axes): (r,), (r, r).

    The parameters are integrated over in the fit's linear approximation, with a normal prior of the width of their
    range; a strength in its logarithm. What simulation adds to the residual is taken out on average.
    """
    r, jacobian = fit.residual, fit.jacobian
    if vectors is not None:
        r, jacobian = vectors.T @ r, vectors.T @ jacobian
    precision, scale = prior(fit)
    weights = 1 / variances
    # in units of the prior's width
    j = jacobian * (scale / np.sqrt(precision))
    noise = fit.jacobian_noise * np.outer(scale, scale) / np.sqrt(np.outer(precision, precision)) * weights.mean()
    information = j.T @ (weights[:, None] * j)
    along, one = j.T @ (weights * r), np.eye(len(precision))
    # Slopes that are simulation's noise identify nothing, but follow the residual all the same.
    q = float(weights @ r**2 - along @ np.linalg.solve(information + one, along))
    values = np.maximum(np.linalg.eigvalsh(information - noise), 0)
    free = float(weights.sum() - (values / (1 + values)).sum())
    left = q - fit.noise * free
    value = -0.5 * (left + np.log(variances).sum() + np.log1p(values).sum())
    error = np.sqrt(2 * free * fit.noise**2 + 4 * max(left, 0) * fit.noise) / 2
    return Evidence(value, float(error), max(left - free, 0) / 2)


def prior(fit: Fit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Precision of each parameter's prior, and by what its derivative is multiplied: (P,), (P,).

    A range of 1 has a variance of 1/12. The coordinate of a strength is its logarithm.
    """
    precision, scale = np.full(fit.model.dim, 12.0), np.ones(fit.model.dim)
    for at, strength in fit.model.strengths(fit.point).items():
        precision[at] = 12 / np.log(1 / WEAKEST) ** 2
        scale[at] = max(strength, WEAKEST)
    return precision, scale
