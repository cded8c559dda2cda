"""Do simulation and measurement disagree? A test of the summary, with theta fitted on the same events."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.sharpening import settled, sharpen
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary.contract import Summary
from avobench.diagnosis.summary.target import Target

HOPELESS = 1e-12
"""No care in the fit helps a model with a smaller p-value."""


def summary_gate(
    fit: Fit, target: Target, rng: np.random.Generator, effort: Effort, known: KnownModel | None = None
) -> tuple[Gate, Fit, Target]:
    """Hansen's J: the whitened distance at the best theta, with the covariance that the model itself predicts.

    Chi-squared with as many degrees of freedom as the summary has, less those that theta takes up, and one at least:
    where nothing is free to scatter, a distance is left because theta cannot reach the measurement. The metric is
    that of `own_metric`. Also the fit in it, and what was fitted in it. `known` is the model without its last effect,
    if that is known well.
    """
    num_events = int(effort.sharpen * target.num_events)
    many = min(num_events, effort.covariance)
    own_target, still = own_metric(fit, target.summary, target.mean, target.num_events, rng, many)
    num_events = num_events if known is None else num_events // 2
    own = sharpen(fit, own_target, rng, num_events, known=known)
    if own.p_value > HOPELESS:
        own = settled(own, own_target, rng, int(effort.sharpen * target.num_events), effort.settle)
    dof = max(own.dof - round(still), 1)
    return Gate(statistic=own.q, dof=dof, p_value=float(chi2.sf(own.q, dof))), own, own_target


def own_metric(
    fit: Fit,
    summary: Summary,
    mean: NDArray[np.float64],
    num_events: int,
    rng: np.random.Generator,
    num_simulated: int,
) -> tuple[Target, float]:
    """A measured mean (K,) of so many events in the metric that the fitted model itself predicts.

    The model's own covariance, because that of few measured events is biased where they are fewest. Where it makes
    none, but some were measured, they scatter as if it were to make one; by how many degrees of freedom that is more
    than the model says comes second.
    """
    cov = summary.covariance(fit.model.simulate(np.tile(fit.params, (num_simulated, 1)), rng))
    lacking = np.maximum(1 / num_events - np.diag(cov), 0)
    target = Target.of(summary, mean, num_events, cov + np.diag(lacking))
    return target, float(lacking @ (target.whitening**2).sum(axis=1))
