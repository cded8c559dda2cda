"""A prior that is not uniform in a fit by moments, which knows of it where it ends: as a Gaussian of its moments."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.prior import Distributed

TRIES = 3
"""So often the fit is repeated where the prior moved it, until two lead to one place."""
SAME = 1.0
"""Standard deviations, of all parameters together, within which two places are one."""


class Posterior(NamedTuple):
    """What events and the prior say together, in the parameters' own units."""

    theta: NDArray[np.float64]
    """(p,)"""
    covariance: NDArray[np.float64]
    """(p, p)"""


def with_prior(fit: Fit, prior: Distributed, repeated: Callable[[NDArray[np.float64]], Fit]) -> Posterior | None:
    """The fit of a task alone with its prior by mean and standard deviation; it is `repeated` from where that leads.

    None where that is no fair approximation, since each fit leads elsewhere than the last, or where too few simulated
    events are left to look. A fit that knows its slopes as far as the prior moves it needs no second one.
    """
    model, width = fit.model, fit.model.high - fit.model.low
    lawful = np.array([law is not None for law in prior.laws])
    precision, mean = np.where(lawful, (width / prior.std) ** 2, 0), model.to_cube(prior.mean)
    last = np.full(model.dim, np.inf)
    for tried in range(TRIES + 1):
        values, vectors = np.linalg.eigh(fit.sure_information + np.diag(precision))
        covariance = (vectors / np.maximum(values, 12)) @ vectors.T
        point = model.allowed(fit.point + covariance @ (precision * (mean - fit.point)))
        same = tried > 0 and (point - last) @ np.linalg.solve(covariance, point - last) < SAME**2
        last = point
        if same or (np.abs(fit.design.to_t(point)) <= 1).all():
            return Posterior(model.from_cube(point), covariance * np.outer(width, width))
        if tried < TRIES:
            try:
                fit = repeated(point)
            except BudgetExhausted:
                break
    return None
