"""A task and methods that take milliseconds, for tests of the harness. Loaded as `toys:Name`."""

import os
import signal
import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.bench.errors import BudgetExhausted, UsageError
from avobench.methods import Estimate, Method, TracePoint
from avobench.tasks import Box, Task


@dataclass(frozen=True)
class Normal(Task):
    """x ~ N(theta, 1)."""

    name: ClassVar = "normal"
    parameter_names: ClassVar = ("location",)
    parameter_units: ClassVar = ("1",)
    source: ClassVar = "test"
    prior: ClassVar = Box((-1,), (1,))
    support: ClassVar = Box((-9,), (9,))
    num_features: ClassVar = 1

    scale: float = 1.0
    fault: str = ""

    def simulate(self, theta, rng):
        if self.fault == "raises" and len(theta) < 1000:
            raise RuntimeError("the detector\nis on fire")
        if self.fault == "exits":
            raise SystemExit(0)
        if self.fault == "nan":
            return np.full((len(theta), 1), np.nan)
        return rng.normal(theta, self.scale)

    def summary(self, x):
        return x.mean(axis=0) * (np.nan if self.fault == "summary" else 1)

    def floor(self, theta, num_observations, num_simulations):
        if self.fault == "floor":
            return None
        return self.scale**2 * (1 / num_observations + (1 / num_simulations if num_simulations else 0))


@dataclass(frozen=True)
class Moment(Method):
    """Corrects theta by the difference of means, a step at a time."""

    name: ClassVar = "moment"
    source: ClassVar = "test"

    steps: int = 4
    pause: float = 0.0
    fault: str = ""
    fault_at: int = -1

    def min_simulations(self, num_parameters):
        return self.steps

    def infer(self, problem, rng):
        theta, trace = problem.prior.center, []
        for _ in range(self.steps):
            time.sleep(self.pause)
            x = problem.simulate.repeat(theta, problem.simulate.budget // self.steps)[0]
            theta = theta + problem.x_observed.mean(axis=0) - x.mean(axis=0)
            trace.append(TracePoint(problem.simulate.used, theta))
        if self.fault == "greedy":
            problem.simulate.repeat(theta, problem.simulate.budget)
        if self.fault == "raises":
            raise RuntimeError("lost the thread")
        if self.fault == "summary":
            problem.summary(problem.x_observed)
        if self.fault == "exits":
            raise SystemExit(0)
        if self.fault == "quiet":
            raise BudgetExhausted
        if self.fault == "usage":
            raise UsageError("not like this")
        if self.fault == "cheats":
            problem.simulate.budget = 10**6
        if self.fault == "outside":
            theta = theta + 100
        if self.fault == "support":
            problem.simulate(np.array([[100.0]]))
        if self.fault == "nothing":
            return None
        if self.fault == "trace":
            trace = [1, 2]
        if self.fault == "dies":
            os.kill(os.getpid(), signal.SIGKILL)
        std = np.full(1, problem.simulate.used**-0.5)
        return Estimate(theta, "last step", "posterior", theta, std, trace)


@dataclass(frozen=True)
class Dying(Moment):
    """Kills its worker process."""

    name: ClassVar = "dying"
    fault: str = "dies"


class Careless(Normal):
    """Draws from the global generator."""

    name: ClassVar = "careless"

    def simulate(self, theta, rng):
        return np.random.normal(theta)


class Unready(Normal):
    """Needs a package that nobody has."""

    name: ClassVar = "unready"
    packages: ClassVar = ("no_such_package",)
    extra: ClassVar = "unready"


class Fragile(Normal):
    """Cannot be made."""

    name: ClassVar = "fragile"

    def __post_init__(self):
        raise RuntimeError("out of order")
