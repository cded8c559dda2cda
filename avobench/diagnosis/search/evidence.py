"""One number for any set of effects: how probable the measured summary is under a fitted model.

The measured mean m is normal about that of the model, m ~ N(s(theta, eta), C / N), with the covariance C of the
measurement. Theta and the effects' parameters eta are integrated over (Laplace), so that whatever is free pays for
itself. That something is missing which the catalogue does not have is a model too: the simulator, distorted smoothly by
a share a of each bin, where K is a smooth correlation between bins,

    m ~ N(s(theta), C / N + a^2 diag(s) K diag(s)).

That no shape of the catalogue is exactly right is a matter of the temperature of what a fit leaves, see `posterior`.
After M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425, and D. J. C. MacKay, Neural Computation 4 (1992) 415.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.settings import SCORE
from avobench.diagnosis.summary.target import Target, fixed


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
        """What it is surely worth: others matter beside that, and of one set the fit that has most is told."""
        return self.value - self.error

    @property
    def at_most(self) -> float:
        """What it may be worth, for all that simulation leaves open."""
        return self.value + self.error


@dataclass(frozen=True)
class Unknown:
    """Something that the catalogue lacks, as a target's summary would show it."""

    target: Target

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

    def evidence(self, null: Fit) -> float:
        """Of it, from the fit of the simulator as it is."""
        evidences, shares = [], np.geomspace(*SCORE.distortions)
        for length in SCORE.lengths:
            alike = self.target.summary.alike(length)
            share = self.target.summary.distorted(null.predicted)
            values, vectors = np.linalg.eigh(self.whitened(share, alike, null.predicted))
            evidences += [marginal(null, 1 + a**2 * np.maximum(values, 0), vectors).value for a in shares]
        return float(logsumexp(evidences)) - np.log(len(evidences))


def evidence_of(fit: Fit) -> Evidence:
    """Of a fitted model."""
    return marginal(fit, np.ones(len(fit.residual)), None)


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
        precision[at] = 12 / np.log(1 / SCORE.weakest) ** 2
        scale[at] = max(strength, SCORE.weakest)
    return precision, scale


@dataclass(frozen=True)
class Weighed:
    """A fitted model and its evidence."""

    fit: Fit
    evidence: Evidence
    resemblance: float = 0.0
    """Logarithm of how much the measured events look like its effects, on average."""

    @classmethod
    def of(cls, fit: Fit, like: dict[str, float] | None = None) -> "Weighed":
        """`like` is the logarithm of how much they look like each family, where there is experience."""
        likeness = [like[effect.name] for effect in fit.model.effects] if like else []
        return cls(fit, evidence_of(fit), float(np.mean(likeness)) if likeness else 0.0)

    @property
    def effects(self) -> frozenset[tuple]:
        """The effects of the model, which name it, by their keys."""
        return frozenset(effect.key for effect in self.fit.model.effects)
