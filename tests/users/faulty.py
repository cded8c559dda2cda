"""A task and a method that keep the contract, and others that each break it in one way. Loaded as `faulty:Name`."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from avobench.methods import Estimate, Method, TracePoint
from avobench.tasks import Box, Task
from avobench.tasks.errors import BudgetExhausted, SimulatorError


def declare(base, faults):
    """A class of this module for each name, with one thing changed of the base."""
    for name, changes in faults.items():
        globals()[name] = type(name, (base,), {"__module__": __name__, **changes})


class SoundTask(Task):
    """x ~ N(theta, 1)."""

    name = "sound"
    parameter_names = ("location",)
    parameter_units = ("1",)
    source = "test"
    prior = Box((-1,), (1,))
    support = Box((-9,), (9,))
    num_features = 1

    def simulate(self, theta, rng):
        if not self.support.contains(theta).all():
            raise ValueError("theta lies outside the support")
        return self.events(theta, rng)

    def events(self, theta, rng):
        return rng.normal(theta)

    def summary(self, x):
        return x.mean(axis=0)

    def floor(self, theta, num_observations, num_simulations):
        return 1 / num_observations + (1 / num_simulations if num_simulations else 0)


def halves(theta, rng):
    """A random number for half of the rows."""
    return rng.standard_normal((len(theta) + 1) // 2)


TASKS = {
    "Nameless": {"source": ""},
    "TwoNames": {"parameter_names": ("location", "scale")},
    "WidePrior": {"prior": Box((-10,), (1,))},
    "TwoKinds": {"feature_kinds": ("count", "count")},
    "HalfCounts": {"feature_kinds": ("count",)},
    "WideAngle": {"feature_kinds": ("angle",)},
    "TargetsElsewhere": {"targets": lambda self, n=15: np.full((n, 1), 2.0)},
    "NotANumber": {"events": lambda self, theta, rng: np.where(theta > 0, np.nan, rng.normal(theta))},
    "FailsAtTheEdge": {"events": lambda self, theta, rng: np.where(np.abs(theta) == 9, np.inf, rng.normal(theta))},
    "Anywhere": {"simulate": lambda self, theta, rng: rng.normal(theta)},
    "OwnEntropy": {"events": lambda self, theta, rng: np.random.default_rng().normal(theta)},
    "GlobalRandomness": {"events": lambda self, theta, rng: np.random.normal(theta)},
    "FixedSeed": {"events": lambda self, theta, rng: np.random.default_rng(0).normal(theta)},
    "IgnoresTheta": {"events": lambda self, theta, rng: rng.standard_normal(theta.shape)},
    "FirstTheta": {"events": lambda self, theta, rng: rng.normal(theta[0], size=theta.shape)},
    "SharedLatent": {
        "events": lambda self, theta, rng: rng.normal(theta, np.sqrt(1 / 2)) + rng.normal(0, np.sqrt(1 / 2))
    },
    "SummaryOfOrder": {"summary": lambda self, x: x.mean(axis=0) + x[0]},
    "GrowingSummary": {"summary": lambda self, x: np.sort(x[:, 0])},
    "TableSummary": {"summary": lambda self, x: x.mean(axis=0, keepdims=True)},
    "HalfAFloor": {"floor_shares": (0.5,)},
    "RisingFloor": {
        "floor": lambda self, theta, num_observations, num_simulations: (
            1 / num_observations + (num_simulations or 0) / 1e9
        )
    },
    "NoFloor": {"floor": lambda self, theta, num_observations, num_simulations: 0.0},
    "DeterminesMore": {"identifiable": lambda self, theta: np.hstack([theta, theta**2])},
    "DeterminesAnother": {"identifiable": lambda self, theta: 2 * theta},
    "DeterminesInNothing": {"identifiable_scale": np.zeros(1)},
    "GeneratesNothing": {"generates": "noise"},
    "PairsOfRows": {"events": lambda self, theta, rng: theta + np.repeat(halves(theta, rng), 2)[: len(theta), None]},
    "Antithetic": {
        "events": lambda self, theta, rng: theta + np.outer([1, -1], halves(theta, rng)).reshape(-1, 1)[: len(theta)]
    },
    "Unpicklable": {"__init__": lambda self: setattr(self, "trick", lambda: None)},
}
declare(SoundTask, TASKS)


@dataclass(frozen=True)
class HoldsASet(SoundTask):
    edges: Any = frozenset({1, 2})


class Burning(SoundTask):
    def events(self, theta, rng):
        raise RuntimeError("the detector\nis on fire")


class ChangesTheta(SoundTask):
    def events(self, theta, rng):
        theta += rng.standard_normal(theta.shape)
        return theta.copy()


class SeedsGlobally(SoundTask):
    def events(self, theta, rng):
        np.random.seed(rng.integers(2**32))
        return np.random.normal(theta)


class Silences(SoundTask):
    def events(self, theta, rng):
        np.seterr(under="ignore" if np.geterr()["under"] == "warn" else "warn")
        return rng.normal(theta)


class DeterminesTogether(SoundTask):
    """Two parameters, of which the sum counts."""

    parameter_names = ("location", "shift")
    parameter_units = ("1", "1")
    prior = Box((-1, -1), (1, 1))
    support = Box((-9, -9), (9, 9))
    identifiable_scale = np.ones(1)

    def identifiable(self, theta):
        return theta.sum(axis=1, keepdims=True) - theta.mean()

    def events(self, theta, rng):
        return rng.normal(theta.sum(axis=1, keepdims=True))


class Noise(np.ndarray):
    """What SoundGenerator makes first: noise (n, 1)."""

    def events(self, start, stop):
        return self[start:stop]


class SoundGenerator(SoundTask):
    """Noise, to which theta is added."""

    generates = "noise"

    def generate(self, num_events, rng):
        yield rng.normal(size=(num_events, 1)).view(Noise)

    def detect(self, generated, theta):
        return np.asarray(generated) + theta

    def simulate(self, theta, rng, alter=None):
        self.require_support(theta)
        (noise,) = self.generate(len(theta), rng)
        return self.detect(alter(noise, slice(0, len(noise))) if alter else noise, theta)


GENERATORS = {
    "DetectsAnew": {"simulate": lambda self, *given: SoundGenerator.simulate(self, *given) + 1},
    "AltersNothing": {"simulate": lambda self, theta, rng, alter=None: SoundGenerator.simulate(self, theta, rng)},
}
declare(SoundGenerator, GENERATORS)


class GeneratesMore(SoundGenerator):
    def generate(self, num_events, rng):
        yield from super().generate(num_events + (num_events == 30), rng)

    def simulate(self, theta, rng, alter=None):
        self.require_support(theta)
        (noise,) = SoundGenerator.generate(self, len(theta), rng)
        return self.detect(alter(noise, slice(0, len(noise))) if alter else noise, theta)


class SoundMethod(Method):
    """The nearest of ten events each at draws from the prior."""

    name = "sound"
    source = "test"
    least = 100

    def min_simulations(self, num_parameters):
        return self.least

    def infer(self, problem, rng):
        theta, x = self.draws(problem, rng)
        distance = [np.linalg.norm(problem.summary(events) - problem.summary(problem.x_observed)) for events in x]
        best = theta[np.argmin(distance)]
        return self.estimate(problem, best)

    def draws(self, problem, rng):
        theta = problem.prior.sample(max(self.least, problem.simulate.remaining) // 10, rng)
        return theta, np.concatenate([problem.simulate.repeat(row, 10) for row in theta])

    def estimate(self, problem, theta):
        trace = [TracePoint(problem.simulate.used // 2, theta), TracePoint(problem.simulate.used, theta)]
        return Estimate(theta, "nearest", "posterior", theta, theta * np.nan, trace)


def drawing(draws):
    """A fault of what the method simulates."""
    return {"draws": lambda self, problem, rng: draws(self, problem, rng)}


def telling(theta=lambda theta: theta, how="nearest", trace=lambda used, theta: []):
    """A fault of the estimate that it returns."""
    return {
        "estimate": lambda self, problem, at: Estimate(
            theta(at), how, "posterior", theta(at), at * 0, trace(problem.simulate.used, at)
        )
    }


def seeded(seed):
    """Draws of another generator than the one that is given."""
    return drawing(lambda self, problem, rng: SoundMethod.draws(self, problem, np.random.default_rng(seed())))


def few(self, problem, rng):
    theta = problem.prior.sample(10, rng)
    return theta, problem.simulate.repeat(theta, 10)


RUNS = itertools.count()
METHODS = {
    "NoMinimum": {"least": 0},
    "UnpicklableMethod": {"__init__": lambda self: setattr(self, "trick", lambda: None)},
    "Quits": drawing(few),
    "UnderstatesMinimum": drawing(
        lambda self, problem, rng: (
            problem.simulate.repeat(problem.prior.center, 150) is not None and SoundMethod.draws(self, problem, rng)
        )
    ),
    "WritesPlainly": drawing(lambda self, problem, rng: problem.x_observed.__setitem__(0, 0)),
    "GlobalRandomMethod": seeded(lambda: np.random.randint(2**31)),
    "OwnEntropyMethod": seeded(lambda: None),
    "Remembers": seeded(lambda: next(RUNS)),
    "WideEstimate": telling(lambda theta: theta[None]),
    "SaysNothing": telling(how=" "),
    "TracesTooMuch": telling(trace=lambda used, theta: [TracePoint(used, np.append(theta, 0))]),
    "TracesNotANumber": telling(trace=lambda used, theta: [TracePoint(used, theta * np.nan)]),
    "MixesThemUp": {
        "together": True,
        "infer_together": lambda self, problems, rngs: Method.infer_together(self, problems, rngs)[::-1],
    },
    "SharesAStream": {
        "together": True,
        "infer_together": lambda self, problems, rngs: Method.infer_together(self, problems, [rngs[0]] * len(rngs)),
    },
}
declare(SoundMethod, METHODS)


@dataclass(frozen=True)
class HoldsATask(SoundMethod):
    task: Any = SoundTask


class Makeshift(SoundMethod):
    def draws(self, problem, rng):
        try:
            return super().draws(problem, rng)
        except BudgetExhausted:
            return problem.prior.center[None], problem.x_observed[None]


class ForcesAWrite(SoundMethod):
    def draws(self, problem, rng):
        problem.x_observed.setflags(write=True)
        problem.x_observed[:10] = 0
        return super().draws(problem, rng)


class FixedGlobalSeed(SoundMethod):
    def draws(self, problem, rng):
        np.random.seed(0)
        return super().draws(problem, np.random.default_rng(np.random.randint(2**31)))


class SwallowsFailure(SoundMethod):
    def draws(self, problem, rng):
        theta, x = [], []
        for row in problem.prior.sample(max(self.least, problem.simulate.remaining) // 10, rng):
            try:
                x.append(problem.simulate.repeat(row, 10)[0])
                theta.append(row)
            except SimulatorError:
                continue
        return np.array(theta), np.array(x)


class DisguisesFailure(SoundMethod):
    def draws(self, problem, rng):
        try:
            return super().draws(problem, rng)
        except SimulatorError as error:
            raise RuntimeError("sampling failed") from error
