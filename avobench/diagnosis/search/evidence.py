"""One number for any set of effects: how probable the measured summary is under a fitted model.

The measured mean m is normal about that of the model, m ~ N(s(theta, eta), C / N), with the covariance C of the
measurement. Theta and the effects' parameters eta are integrated over (Laplace), so that whatever is free pays for
itself. No shape of the catalogue is exactly right: `posterior.covariates_of` allows for this by a logarithm. After D.
J. C. MacKay, Neural Computation 4 (1992) 415.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.settings import SCORE


@dataclass(frozen=True)
class Evidence:
    """Logarithm of the probability of the measured summary, up to what all models have in common."""

    value: float
    error: float
    """Standard error of the value, by simulation."""
    excess: float = 0.0
    """What a further effect might gain at most: half of what chi-squared exceeds its degrees of freedom by."""

    @property
    def at_least(self) -> float:
        """The value less its error. Other models are compared with it, and it chooses the fit that stands for a set."""
        return self.value - self.error

    @property
    def at_most(self) -> float:
        """The value with its error added: what it may be, for all that simulation leaves open."""
        return self.value + self.error


def evidence_of(fit: Fit) -> Evidence:
    """Of a fitted model.

    The parameters are integrated over in the fit's linear approximation, with a normal prior of the width of their
    range; a strength in its logarithm. What simulation adds to the residual is taken out on average.
    """
    r, (precision, scale) = fit.residual, prior(fit)
    # in units of the prior's width
    j = fit.jacobian * (scale / np.sqrt(precision))
    noise = fit.jacobian_noise * np.outer(scale, scale) / np.sqrt(np.outer(precision, precision))
    information = j.T @ j
    # Slopes that are simulation's noise identify nothing, but follow the residual all the same.
    q = closest(j, r, -fit.point * np.sqrt(precision) / scale, (1 - fit.point) * np.sqrt(precision) / scale)
    values = np.maximum(np.linalg.eigvalsh(information - noise), 0)
    free = float(len(r) - (values / (1 + values)).sum())
    noiseless = q - fit.noise * free
    value = -0.5 * (noiseless + np.log1p(values).sum())
    error = np.sqrt(2 * free * fit.noise**2 + 4 * max(noiseless, 0) * fit.noise) / 2
    return Evidence(value, float(error), max(noiseless - free, 0) / 2)


def closest(
    j: NDArray[np.float64], r: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> float:
    """The least |r - j d|^2 + |d|^2 of steps d between `low` and `high` (P,): of r (k,) and slopes j (k, P).

    A parameter at an end of its range may not go beyond it, however much that would explain.
    """
    if not len(low):
        return float(r @ r)
    design, residual = np.vstack([j, np.eye(len(low))]), np.r_[r, np.zeros(len(low))]
    return float(2 * lsq_linear(design, residual, (np.minimum(low, -1e-9), np.maximum(high, 1e-9))).cost)


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
