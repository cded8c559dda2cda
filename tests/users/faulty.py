"""A task and a method that keep the contract, and others that each break it in one way. Loaded as `faulty:Name`.

`breaks` is the promise of a check, or how it begins, which finds the fault.
"""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from avobench.methods import Estimate, Method, TracePoint
from avobench.tasks import Box, Task
from avobench.tasks.errors import BudgetExhausted, SimulatorError


def declare(base, faults):
    """A class of this module for each name, with what it breaks and one thing changed of the base."""
    for name, (breaks, changes) in faults.items():
        globals()[name] = type(name, (base,), {"__module__": __name__, "breaks": breaks, **changes})


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


def events(make):
    """A fault of the events."""
    return {"events": lambda self, theta, rng: make(theta, rng)}


def halves(theta, rng):
    """A random number for half of the rows: (k, 1)."""
    return rng.standard_normal(((len(theta) + 1) // 2, 1))


def burn(theta, rng):
    raise RuntimeError("the detector\nis on fire")


def change_theta(theta, rng):
    theta += rng.standard_normal(theta.shape)
    return theta.copy()


def seed_globally(theta, rng):
    np.random.seed(rng.integers(2**32))
    return np.random.normal(theta)


def silence(theta, rng):
    np.seterr(under="ignore" if np.geterr()["under"] == "warn" else "warn")
    return rng.normal(theta)


ROWS = "makes neighbouring rows independent"
UNPICKLABLE = {"__init__": lambda self: setattr(self, "trick", lambda: None)}
TASKS = {
    "Nameless": ("says what it is", {"source": ""}),
    "TwoNames": ("names parameters", {"parameter_names": ("location", "scale")}),
    "WidePrior": ("names parameters", {"prior": Box((-10,), (1,))}),
    "TwoKinds": ("names parameters", {"feature_kinds": ("count", "count")}),
    "HalfCounts": ("makes features of the kinds", {"feature_kinds": ("count",)}),
    "WideAngle": ("makes features of the kinds", {"feature_kinds": ("angle",)}),
    "TargetsElsewhere": ("has 15 targets", {"targets": lambda self, n=15: np.full((n, 1), 2.0)}),
    "NotANumber": ("simulates 1 and", events(lambda theta, rng: np.where(theta > 0, np.nan, rng.normal(theta)))),
    "FailsAtTheEdge": (
        "simulates every corner",
        events(lambda theta, rng: np.where(np.abs(theta) == 9, np.inf, rng.normal(theta))),
    ),
    "Anywhere": ("refuses theta", {"simulate": lambda self, theta, rng: rng.normal(theta)}),
    "OwnEntropy": ("repeats its events", events(lambda theta, rng: np.random.default_rng().normal(theta))),
    "GlobalRandomness": ("repeats its events", events(lambda theta, rng: np.random.normal(theta))),
    "FixedSeed": ("makes other events", events(lambda theta, rng: np.random.default_rng(0).normal(theta))),
    "IgnoresTheta": ("makes events that depend", events(lambda theta, rng: rng.standard_normal(theta.shape))),
    "FirstTheta": ("gives each row", events(lambda theta, rng: rng.normal(theta[0], size=theta.shape))),
    "SharedLatent": ("gives each row", events(lambda theta, rng: rng.normal(theta, 0.7) + rng.normal(0, 0.7))),
    "SummaryOfOrder": ("summarises", {"summary": lambda self, x: x.mean(axis=0) + x[0]}),
    "GrowingSummary": ("summarises", {"summary": lambda self, x: np.sort(x[:, 0])}),
    "TableSummary": ("summarises", {"summary": lambda self, x: x.mean(axis=0, keepdims=True)}),
    "HalfAFloor": ("has a floor", {"floor_shares": (0.5,)}),
    "RisingFloor": ("has a floor", {"floor": lambda self, theta, observed, simulated: 1 + (simulated or 0) / 1e9}),
    "NoFloor": ("has a floor", {"floor": lambda self, theta, observed, simulated: 0.0}),
    "DeterminesMore": ("says what its events", {"identifiable": lambda self, theta: np.hstack([theta, theta**2])}),
    "DeterminesAnother": ("says what its events", {"identifiable": lambda self, theta: 2 * theta}),
    "DeterminesInNothing": ("says what its events", {"identifiable_scale": np.zeros(1)}),
    "GeneratesNothing": ("detects what it generates", {"generates": "noise"}),
    "PairsOfRows": (ROWS, events(lambda theta, rng: theta + np.repeat(halves(theta, rng), 2, 0)[: len(theta)])),
    "Antithetic": (ROWS, events(lambda theta, rng: theta + np.kron([[1], [-1]], halves(theta, rng))[: len(theta)])),
    "Unpicklable": ("can be sent", UNPICKLABLE),
    "Burning": ("simulates 1 and 1000 events", events(burn)),
    "ChangesTheta": ("leaves theta as it is", events(change_theta)),
    "SeedsGlobally": ("leaves global state", events(seed_globally)),
    "Silences": ("leaves global state", events(silence)),
}
declare(SoundTask, TASKS)


@dataclass(frozen=True)
class HoldsASet(SoundTask):
    breaks = "says what it is"
    edges: Any = frozenset({1, 2})


class DeterminesTogether(SoundTask):
    """Two parameters, of which the sum counts."""

    breaks = "says what its events determine"
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
        (noise,) = SoundGenerator.generate(self, len(theta), rng)
        return self.detect(alter(noise, slice(0, len(noise))) if alter else noise, theta)


def generate_more(self, num_events, rng):
    """One event too many where 30 are asked for, as the check does."""
    return SoundGenerator.generate(self, num_events + (num_events == 30), rng)


DETECTS = "detects what it generates"
GENERATORS = {
    "GeneratesMore": (DETECTS, {"generate": generate_more}),
    "DetectsAnew": (DETECTS, {"simulate": lambda self, *given: SoundGenerator.simulate(self, *given) + 1}),
    "AltersNothing": (
        DETECTS,
        {"simulate": lambda self, theta, rng, alter=None: SoundGenerator.simulate(self, theta, rng)},
    ),
}
declare(SoundGenerator, GENERATORS)


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


def make_shift(self, problem, rng):
    try:
        return SoundMethod.draws(self, problem, rng)
    except BudgetExhausted:
        return problem.prior.center[None], problem.x_observed[None]


def force_a_write(self, problem, rng):
    problem.x_observed.setflags(write=True)
    problem.x_observed[:10] = 0
    return SoundMethod.draws(self, problem, rng)


def fix_the_global_seed():
    np.random.seed(0)
    return np.random.randint(2**31)


def swallow_failure(self, problem, rng):
    theta, x = [], []
    for row in problem.prior.sample(max(self.least, problem.simulate.remaining) // 10, rng):
        try:
            x.append(problem.simulate.repeat(row, 10)[0])
            theta.append(row)
        except SimulatorError:
            continue
    return np.array(theta), np.array(x)


def disguise_failure(self, problem, rng):
    try:
        return SoundMethod.draws(self, problem, rng)
    except SimulatorError as error:
        raise RuntimeError("sampling failed") from error


RUNS = itertools.count()


def together(infer):
    """A fault of cells that are carried out together."""
    return {"together": True, "infer_together": infer}


ESTIMATE = "makes an estimate on poisson from 100 events"
METHODS = {
    "NoMinimum": ("declares the smallest", {"least": 0}),
    "UnpicklableMethod": ("can be sent", UNPICKLABLE),
    "Quits": ("says why", drawing(few)),
    "UnderstatesMinimum": (ESTIMATE, drawing(lambda self, problem, rng: problem.simulate([[1.0]] * 150))),
    "WritesPlainly": (ESTIMATE, drawing(lambda self, problem, rng: problem.x_observed.__setitem__(0, 0))),
    "WideEstimate": (ESTIMATE, telling(lambda theta: theta[None])),
    "SaysNothing": (ESTIMATE, telling(how=" ")),
    "NoSpread": (ESTIMATE, {"estimate": lambda self, problem, at: Estimate(at, "nearest", "none", at, at * 0)}),
    "TracesTooMuch": (ESTIMATE, telling(trace=lambda used, theta: [TracePoint(used, np.append(theta, 0))])),
    "GlobalRandomMethod": ("leaves global state", seeded(lambda: np.random.randint(2**31))),
    "OwnEntropyMethod": ("repeats its estimate", seeded(lambda: None)),
    "Remembers": ("repeats its estimate", seeded(lambda: next(RUNS))),
    "TracesNotANumber": ("traces", telling(trace=lambda used, theta: [TracePoint(used, theta * np.nan)])),
    "Makeshift": ("makes no estimate from fewer", drawing(make_shift)),
    "ForcesAWrite": ("makes an estimate on poisson", drawing(force_a_write)),
    "FixedGlobalSeed": ("leaves global state", seeded(fix_the_global_seed)),
    "SwallowsFailure": ("lets errors", drawing(swallow_failure)),
    "DisguisesFailure": ("lets errors", drawing(disguise_failure)),
    "MixesThemUp": ("makes the same", together(lambda *given: Method.infer_together(*given)[::-1])),
    "SharesAStream": (
        "makes the same",
        together(lambda self, problems, rngs: Method.infer_together(self, problems, [rngs[0]] * len(rngs))),
    ),
}
declare(SoundMethod, METHODS)


@dataclass(frozen=True)
class HoldsATask(SoundMethod):
    breaks = "says what it is"
    task: Any = SoundTask
