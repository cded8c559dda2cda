"""A task whose prior is not uniform, for methods that know uniform ones: its parameters are shares of it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avobench.methods import Estimate, Method, TracePoint, WeightedSample
from avobench.tasks import Box, Task
from avobench.tasks.prior import Distributed


class InShares(Task):
    """A task with a parameter in [0, 1] for each of another's: the share of the prior that lies below it."""

    source = "a task, by shares of its prior"

    def __init__(self, task: Task) -> None:
        self.task, self.name, self.tasks = task, task.name, (task,)
        self.parameter_names, self.parameter_units = task.parameter_names, task.parameter_units
        self.copy_events_of(task)
        self.prior = self.support = Box((0.0,) * task.prior.dim, (1.0,) * task.prior.dim)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event per row: shares (n, p) -> (n, d). Raises ValueError outside of 0 to 1."""
        self.require_support(theta)
        return self.task.simulate(self.task.at_whole(self.task.prior.at(theta), rng), rng)

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        return self.task.summary(x)

    def with_reference(self, x: NDArray) -> Task:
        return InShares(self.task.with_reference(x))


def in_shares(task: Task, method: Method) -> Task:
    """The task by shares of its prior; itself where that is uniform, or the method can do with its moments.

    By shares even a mean is strongly curved in the tails, where a local quadratic of it would be biased.
    """
    return InShares(task) if isinstance(task.prior, Distributed) and not method.by_moments else task


def raw(estimate: Estimate, posed: Task) -> Estimate:
    """An estimate of a task from `in_shares` in the units of the parameters.

    Points of a posterior are mapped one by one. Other errors follow the slope of the quantiles over their reach.
    """
    if not isinstance(posed, InShares):
        return estimate
    prior = posed.task.prior

    def slopes(at: NDArray, std: NDArray) -> NDArray[np.float64]:
        reach = np.maximum(np.nan_to_num(std, posinf=1.0), 1e-6)
        above, below = np.clip(at + reach, 0, 1), np.clip(at - reach, 0, 1)
        return (prior.at(above) - prior.at(below)) / (above - below)

    def moved(theta: NDArray, std: NDArray | None) -> NDArray | None:
        return None if std is None else std * slopes(theta, std)

    changes = {"theta": prior.at(estimate.theta), "error": moved(estimate.theta, estimate.error)}
    changes["trace"] = [TracePoint(n, prior.at(theta), moved(theta, std)) for n, theta, std in estimate.trace]
    if estimate.covariance is not None:
        slope = slopes(estimate.theta, np.sqrt(np.diag(estimate.covariance)))
        changes["covariance"] = estimate.covariance * np.outer(slope, slope)
    if estimate.sample is None:
        return replace(estimate, **changes, mean=prior.at(estimate.mean), std=moved(estimate.mean, estimate.std))
    points, weights = prior.at(estimate.sample.theta), estimate.sample.weights
    mean = weights @ points / weights.sum()
    std = np.sqrt(weights @ (points - mean) ** 2 / weights.sum())
    return replace(estimate, **changes, sample=WeightedSample(points, weights), mean=mean, std=std)
