"""Do simulation and measurement disagree? A summary test with theta fitted on the same events."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.diagnosis.fit import Fit, Target, polish
from avobench.diagnosis.summary import Summary, whitening

MIXED_IN = 0.1
"""Share of the simulated events in the covariance: where nothing was measured, what was expected still counts."""


COVARIANCE_EVENTS = 100_000


@dataclass(frozen=True)
class Gate:
    statistic: float
    dof: int | None
    p_value: float


def target_of(x: NDArray, summary: Summary, simulated: NDArray) -> Target:
    """What to fit to the measured events x (N, d), whitened with their covariance and a little of the simulated."""
    cov = (1 - MIXED_IN) * summary.covariance(x) + MIXED_IN * summary.covariance(simulated)
    return Target(summary, np.asarray(summary.rows(x).mean(axis=0)), len(x), whitening(cov))


def summary_gate(fit: Fit, target: Target, rng: np.random.Generator, num_events: int) -> tuple[Gate, Fit]:
    """Hansen's J: the whitened distance at the best theta, with the covariance that the model itself predicts.

    Chi-squared with as many degrees of freedom as the summary has, less those that theta takes up. The model's own
    covariance, because that of few measured events is biased where they are fewest.
    """
    x = fit.model.simulate(np.tile(fit.params, (min(num_events, COVARIANCE_EVENTS), 1)), rng)
    w = whitening(target.summary.covariance(x))
    own = polish(fit, Target(target.summary, target.mean, target.num_events, w), rng, num_events)
    return Gate(own.q, own.dof, float(chi2.sf(own.q, own.dof))), own
