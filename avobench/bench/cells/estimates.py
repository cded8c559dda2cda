"""The check that a method returned an estimate which a record can hold."""

import numpy as np

from avobench.methods import Estimate, Problem, TracePoint
from avobench.tasks.errors import InvalidEstimate

FLOATS = (np.float16, np.float32, np.float64)
"""A record holds numbers of 64 bits: a wider one would be rounded, out of its support perhaps."""
SPREADS = ("posterior", "proposal")
"""The mean and std of an estimate are of one of these."""


def require_recordable(estimate: object, problem: Problem, used: int) -> None:
    if not isinstance(estimate, Estimate):
        raise InvalidEstimate(f"the method returned {type(estimate).__name__} instead of an Estimate")
    p = problem.prior.dim
    if not isinstance(estimate.trace, list):
        raise InvalidEstimate(f"the trace must be a list of TracePoint, got {estimate.trace!r:.100}")
    vectors = [("theta", estimate.theta), ("mean", estimate.mean), ("std", estimate.std)]
    vectors += [] if estimate.error is None else [("error", estimate.error)]
    for point in estimate.trace:
        if not (isinstance(point, TracePoint) and isinstance(point.simulations, int | np.integer)):
            raise InvalidEstimate(f"the trace must be a list of TracePoint, got {point!r}")
        vectors += [("theta of the trace", point.theta)]
        vectors += [] if point.std is None else [("std of the trace", point.std)]
    for name, value in vectors:
        if not isinstance(value, np.ndarray) or value.shape != (p,) or value.dtype not in FLOATS:
            raise InvalidEstimate(
                f"{name} of the estimate must be a float array of shape ({p},) of at most 64 bits, got {value!r}"
            )
    if (covariance := estimate.covariance) is not None and np.shape(covariance) != (p, p):
        raise InvalidEstimate(f"covariance of the estimate must have shape ({p}, {p}), got {covariance!r:.100}")
    if (sample := estimate.sample) is not None and np.shape(sample.theta) != (len(sample.weights), p):
        raise InvalidEstimate(f"the sample of the estimate must be thetas (m, {p}) and weights (m,)")
    simulations = [point.simulations for point in estimate.trace]
    if simulations != sorted(simulations) or not all(0 <= number <= used for number in simulations):
        raise InvalidEstimate(f"the trace must go from 0 towards the {used} used, got {simulations!r:.100}")
    for name, value in vectors:
        if name.startswith(("std", "error")) and (value < 0).any():
            raise InvalidEstimate(f"the {name} of the estimate is negative")
    if not np.isfinite(estimate.theta).all() or not problem.support.contains(estimate.theta)[0]:
        raise InvalidEstimate(f"the estimate {estimate.theta.tolist()} is not within the support")
    if not (isinstance(estimate.discarded, int | np.integer) and 0 <= estimate.discarded <= used):
        raise InvalidEstimate(f"discarded must be a number from 0 to the {used} used, got {estimate.discarded!r}")
    for name in ("how", "spread_of", "message", "doubt"):
        if not isinstance(getattr(estimate, name), str):
            raise InvalidEstimate(f"{name} of the estimate must be text, got {getattr(estimate, name)!r}")
    if estimate.spread_of not in SPREADS:
        raise InvalidEstimate(f"spread_of of the estimate must be {' or '.join(SPREADS)}, got '{estimate.spread_of}'")
    if used == 0 and not estimate.message.strip():
        raise InvalidEstimate(
            "the estimate was made without a simulated event, and its message does not say why; events of another cell "
            "are not in this cell's budget: a method whose events serve all targets must say `amortised`"
        )
