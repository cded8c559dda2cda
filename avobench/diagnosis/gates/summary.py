"""Do simulation and measurement disagree? A summary test with theta fitted on the same events."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, chi2, norm

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit, polish, settled
from avobench.diagnosis.fit.known import Base
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary.bins import Summary
from avobench.diagnosis.summary.target import Target

MIXED_IN = 0.1
"""Share of the simulated events in the covariance: where nothing was measured, what was expected still counts."""
HOPELESS = 1e-12
"""No care in the fit helps a model with a smaller p-value."""


def target_of(x: NDArray, summary: Summary, simulated: NDArray) -> Target:
    """What to fit to the measured events x (N, d), whitened with their covariance and a little of the simulated."""
    cov = (1 - MIXED_IN) * summary.covariance(x) + MIXED_IN * summary.covariance(simulated)
    return Target.of(summary, summary.mean(x)[0], len(x), cov)


def summary_gate(
    fit: Fit, target: Target, rng: np.random.Generator, effort: Effort, base: Base | None = None
) -> tuple[Gate, Fit, Target]:
    """Hansen's J: the whitened distance at the best theta, with the covariance that the model itself predicts.

    Chi-squared with as many degrees of freedom as the summary has, less those that theta takes up. The model's own
    covariance, because that of few measured events is biased where they are fewest. Where it makes none, but
    some were measured, they scatter as if it were to make one. Also the fit in that metric. `base` is the model without
    its last effect, if that is known well.
    """
    num_events = int(effort.polish * target.num_events)
    x = fit.model.simulate(np.tile(fit.params, (min(num_events, effort.covariance), 1)), rng)
    cov = target.summary.covariance(x)
    lacking = np.maximum(1 / target.num_events - np.diag(cov), 0)
    own_target = Target.of(target.summary, target.mean, target.num_events, cov + np.diag(lacking))
    still = round(float(lacking @ (own_target.whitening**2).sum(axis=1)))
    num_events = num_events if base is None else num_events // 2
    own = polish(fit, own_target, rng, num_events, base=base)
    if own.p_value > HOPELESS:
        own = settled(own, own_target, rng, int(effort.polish * target.num_events), effort.settle)
    dof = own.dof - still
    return Gate(statistic=own.q, dof=dof, p_value=float(chi2.sf(own.q, dof)) if dof > 0 else 1.0), own, own_target


def cell_gate(fit: Fit, x: NDArray, rng: np.random.Generator, effort: Effort) -> Gate:
    """The cell of an image (N, d) that is furthest from what the model expects, among all cells.

    Sums over many cells do not see a few that are faulty. Theta hardly moves a single cell, so no correction for it.
    How often a cell fires is compared as two Poisson counts are: of all, the measured ones are binomial, exactly also
    where they are few (J. Przyborowski and H. Wilenski, Biometrika 31 (1940) 313). The statistic is the largest excess
    or deficit in standard deviations.
    """
    n = int(effort.polish * len(x))
    simulated = fit.model.simulate(np.tile(fit.params, (n, 1)), rng)
    measured, expected = np.count_nonzero(x, axis=0), np.count_nonzero(simulated, axis=0)
    both, share = measured + expected, len(x) / (len(x) + n)
    tail = np.minimum(binom.cdf(measured, both, share), binom.sf(measured - 1, both, share))
    least = float(min(2 * tail.min(), 1.0))
    p = -np.expm1((both > 0).sum() * np.log1p(-min(least, 1 - 1e-16)))
    return Gate(statistic=float(norm.isf(max(least, 1e-300) / 2)), dof=None, p_value=float(p))
