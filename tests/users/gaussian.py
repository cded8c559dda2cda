"""A task with a known posterior, for tests of the methods."""

import numpy as np

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.methods.problem import Problem
from avobench.tasks import Box, Task

TRUTH = np.array([1.0])


class GaussianMean(Task):
    """x ~ N(mu, 1) with a U(-3, 3) prior: the posterior given N events is N(mean(x), 1/N)."""

    name, parameter_names, parameter_units, source = "gaussian-mean", ("mu",), ("1",), "textbook"
    prior, support, num_features = Box((-3,), (3,)), Box((-3,), (3,)), 1

    def simulate(self, theta, rng):
        return rng.normal(theta, 1)

    def summary(self, x):
        return x.mean(axis=0)

    def floor(self, theta, num_observations, num_simulations):
        return 1 / num_observations


class GaussianMeans(GaussianMean):
    """Two means in boxes that do not overlap, with names whose alphabetical order is not their order."""

    parameter_names, parameter_units, num_features = ("second", "first"), ("1", "1"), 2
    prior = support = Box((-3, 10), (3, 14))


class Failing(GaussianMean):
    def simulate(self, theta, rng):
        raise ZeroDivisionError("the detector is off")


class Constant(GaussianMean):
    """Every theta reproduces the observed summary."""

    def summary(self, x):
        return np.ones(1)


def posed(task: Task, x_observed: np.ndarray, budget: int, rng: np.random.Generator | int) -> Problem:
    """The problem of events (n, d), with a generator or a seed for those that are simulated."""
    return pose(task, x_observed, MeteredSimulator(task, budget, np.random.default_rng(rng)))


def problem_at(task: Task, truth, budget: int, rng: np.random.Generator | int, num_observed: int = 20_000) -> Problem:
    """The problem of a task's own events at a truth (p,)."""
    rng = np.random.default_rng(rng)
    return posed(task, task.simulate(np.tile(truth, (num_observed, 1)), rng), budget, rng)


def gaussian_problem(task: Task, budget: int, truth=TRUTH, seed: int = 0, num_observed: int = 10_000) -> Problem:
    rng = np.random.default_rng(seed)
    return posed(task, rng.normal(truth, 1, (num_observed, task.num_features)), budget, rng)
