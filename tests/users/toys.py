"""A task and methods that take milliseconds, for tests of the harness. Loaded as `toys:Name`."""

import os
import signal
import time
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from faulty import SoundTask

from avobench.methods import Estimate, Method, TracePoint
from avobench.tasks.errors import BudgetExhausted, UsageError


@dataclass(frozen=True)
class Normal(SoundTask):
    """x ~ N(theta, scale), wherever theta is."""

    name: ClassVar = "normal"

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
        return super().summary(x) * (np.nan if self.fault == "summary" else 1)

    def floor(self, theta, num_observations, num_simulations):
        if self.fault == "floor":
            return None
        if self.fault == "negative floor":
            return -1.0
        return self.scale**2 * super().floor(theta, num_observations, num_simulations)


def _raise(error):
    raise error


INSTEAD = {
    "greedy": lambda problem: problem.simulate.repeat(problem.prior.center, problem.simulate.budget),
    "raises": lambda problem: _raise(RuntimeError("lost the thread")),
    "summary": lambda problem: problem.summary(problem.x_observed),
    "exits": lambda problem: _raise(SystemExit(0)),
    "quiet": lambda problem: _raise(BudgetExhausted),
    "usage": lambda problem: _raise(UsageError("not like this")),
    "cheats": lambda problem: setattr(problem.simulate, "budget", 10**6),
    "support": lambda problem: problem.simulate(np.array([[100.0]])),
    "dies": lambda problem: os.kill(os.getpid(), signal.SIGKILL),
}
"""What a method does in place of an estimate."""
CHANGED = {
    "nothing": lambda found: None,
    "outside": lambda found: replace(found, theta=found.theta + 100),
    "trace": lambda found: replace(found, trace=[1, 2]),
    "backwards": lambda found: replace(found, trace=found.trace[::-1]),
    "beyond": lambda found: replace(found, trace=[*found.trace, TracePoint(10**6, found.theta)]),
    "spread": lambda found: replace(found, std=-found.std),
    "tells": lambda found: replace(found, error=found.std),
    "error": lambda found: replace(found, error=-found.std),
}
"""What it returns in place of a sound estimate."""


@dataclass(frozen=True)
class Moment(Method):
    """Corrects theta by the difference of means, a step at a time."""

    name: ClassVar = "moment"
    source: ClassVar = "test"

    steps: int = 4
    pause: float = 0.0
    fault: str = ""

    def min_simulations(self, num_parameters):
        return self.steps

    def infer(self, problem, rng):
        theta, trace = problem.prior.center, []
        if self.fault == "kept":
            return Estimate(theta, "from another cell", "posterior", theta, theta * 0.1)
        for _ in range(self.steps):
            time.sleep(self.pause)
            x = problem.simulate.repeat(theta, problem.simulate.budget // self.steps)[0]
            theta = theta + problem.x_observed.mean(axis=0) - x.mean(axis=0)
            trace.append(TracePoint(problem.simulate.used, theta))
        if self.fault in INSTEAD:
            INSTEAD[self.fault](problem)
        found = Estimate(theta, "last step", "posterior", theta, np.full(1, problem.simulate.used**-0.5), trace)
        return CHANGED.get(self.fault, lambda found: found)(found)


@dataclass(frozen=True)
class Dying(Moment):
    """Kills its worker process."""

    name: ClassVar = "dying"
    fault: str = "dies"


class OutOfMemoryError(RuntimeError):
    """Named as PyTorch's."""


@dataclass(frozen=True)
class Lockstep(Moment):
    """Infer several problems at once, a step of all at a time.

    It fails, as `fault` says, where the observed events of any of them have a mean above `limit`, or where there are
    more than `most`.
    """

    name: ClassVar = "lockstep"
    together: ClassVar = True

    limit: float = 9.0
    most: int = 99

    def infer(self, problem, rng):
        if self.fault in INSTEAD and problem.x_observed.mean() > self.limit:
            INSTEAD[self.fault](problem)
        return replace(self, fault="").infer_together([problem], [rng])[0]

    def infer_together(self, problems, rngs):
        means = np.array([problem.x_observed.mean() for problem in problems])
        if self.fault in INSTEAD and means.max() > self.limit:
            INSTEAD[self.fault](problems[0])
        if len(problems) > self.most:
            raise OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB. GPU 0 has a total of 79 GiB. See")
        theta, traces = np.zeros(len(problems)), [[] for _ in problems]
        for _ in range(self.steps):
            time.sleep(self.pause)
            n = problems[0].simulate.budget // self.steps
            x = np.stack([p.simulate.repeat([[t]], n)[0, :, 0] for p, t in zip(problems, theta, strict=True)])
            theta = theta + means - x.mean(axis=1) + 1e-9 * len(problems)  # as if sums were rounded otherwise
            for problem, trace, t in zip(problems, traces, theta, strict=True):
                trace.append(TracePoint(problem.simulate.used, np.array([t])))
        return [
            Estimate(trace[-1].theta, "last step", "posterior", trace[-1].theta, np.full(1, n**-0.5), trace)
            for trace in traces[: None if self.fault != "few" or len(problems) == 1 else 1]
        ]


@dataclass(frozen=True)
class Cliff(Normal):
    """Fails above theta = 0.5, where some of the targets are, if asked for the 100 events of an observation."""

    name: ClassVar = "cliff"

    def simulate(self, theta, rng):
        if len(theta) == 100 and theta.max() > 0.5:
            raise RuntimeError("over the edge")
        return super().simulate(theta, rng)


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
