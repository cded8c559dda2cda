"""Do simulation and measurement disagree? A test of the summary, with theta fitted on the same events."""

import numpy as np
from scipy.stats import chi2

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.sharpening import settled, sharpen
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary.target import Target

HOPELESS = 1e-12
"""No care in the fit helps a model with a smaller p-value."""


def summary_gate(
    fit: Fit, target: Target, rng: np.random.Generator, effort: Effort, known: KnownModel | None = None
) -> tuple[Gate, Fit, Target]:
    """Hansen's J: the whitened distance at the best theta, with the covariance that the model itself predicts.

    Chi-squared with as many degrees of freedom as the summary has, less those that theta takes up. The model's own
    covariance, because that of few measured events is biased where they are fewest. Where it makes none, but some were
    measured, they scatter as if it were to make one. Also the fit in that metric, and what was fitted in it. `known` is
    the model without its last effect, if that is known well.
    """
    num_events = int(effort.sharpen * target.num_events)
    x = fit.model.simulate(np.tile(fit.params, (min(num_events, effort.covariance), 1)), rng)
    cov = target.summary.covariance(x)
    lacking = np.maximum(1 / target.num_events - np.diag(cov), 0)
    own_target = Target.of(target.summary, target.mean, target.num_events, cov + np.diag(lacking))
    still = round(float(lacking @ (own_target.whitening**2).sum(axis=1)))
    num_events = num_events if known is None else num_events // 2
    own = sharpen(fit, own_target, rng, num_events, known=known)
    if own.p_value > HOPELESS:
        own = settled(own, own_target, rng, int(effort.sharpen * target.num_events), effort.settle)
    dof = own.dof - still
    return Gate(statistic=own.q, dof=dof, p_value=float(chi2.sf(own.q, dof)) if dof > 0 else 1.0), own, own_target
