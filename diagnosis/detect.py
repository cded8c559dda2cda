"""Do simulation and measurement disagree? A summary test with theta fitted on the same events."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.diagnosis.fit import Fit, Target, polish
from avobench.diagnosis.schema import Gate
from avobench.diagnosis.summary import Summary

MIXED_IN = 0.1
"""Share of the simulated events in the covariance: where nothing was measured, what was expected still counts."""


COVARIANCE_EVENTS = 100_000


def target_of(x: NDArray, summary: Summary, simulated: NDArray) -> Target:
    """What to fit to the measured events x (N, d), whitened with their covariance and a little of the simulated."""
    cov = (1 - MIXED_IN) * summary.covariance(x) + MIXED_IN * summary.covariance(simulated)
    return Target.of(summary, summary.mean(x)[0], len(x), cov)


def summary_gate(fit: Fit, target: Target, rng: np.random.Generator, num_events: int) -> tuple[Gate, Fit, Target]:
    """Hansen's J: the whitened distance at the best theta, with the covariance that the model itself predicts.

    Chi-squared with as many degrees of freedom as the summary has, less those that theta takes up. The model's own
    covariance, because that of few measured events is biased where they are fewest.
    """
    x = fit.model.simulate(np.tile(fit.params, (min(num_events, COVARIANCE_EVENTS), 1)), rng)
    own_target = Target.of(target.summary, target.mean, target.num_events, target.summary.covariance(x))
    own = polish(fit, own_target, rng, num_events)
    return Gate(statistic=own.q, dof=own.dof, p_value=float(chi2.sf(own.q, own.dof))), own, own_target
