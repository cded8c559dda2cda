"""The conformance suite: does a task or method, ours or a user's, keep its contract?

Seeds are fixed, so a verdict is repeatable; a statistical check blames a sound task with a probability below ALPHA.
"""

import itertools
import json
import numbers
import pickle
import random
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import joblib
import numpy as np
from numpy.typing import NDArray
from scipy.stats import ks_2samp, norm, rankdata

from avobench.bench import registry
from avobench.bench.budget import MeteredSimulator, checked_events
from avobench.bench.cells import Cell, Status, execute, observe, stream
from avobench.bench.errors import SimulatorError, UsageError
from avobench.bench.problem import Problem
from avobench.methods import Method
from avobench.methods.base import global_seed
from avobench.tasks import Box, Discriminator, Task
from avobench.tasks.base import NUM_TARGETS

ALPHA = 1e-6
NUM_ALONE = 1000
"""Events simulated one at a time, which cannot know of each other, at each of two theta."""
NUM_BATCHES = 5
METHOD_TASKS = ("poisson", "carl")
NUM_OBSERVATIONS = 1000
MODEST_BUDGET = 3001
"""Events of the larger of the two budgets, where twice the method's minimum is not more. Odd on purpose."""
MAX_LEFT_WITHOUT_REASON = 0.1

Stage = Iterator[tuple[str, Callable[[], None]]]
"""Checks by what they promise. Each raises when the promise is broken."""


@dataclass(frozen=True)
class Result:
    """The outcome of one check; `why` is one line, empty for one that passed."""

    passed: bool
    what: str
    why: str = ""


class _BrokenPromise(Exception):
    """What a check found wrong, in a sentence."""


def run(kind: str, name: str) -> Iterator[Result]:
    """Check the task or method `name`, registered or `module:Class`, with its default settings; results as they come.

    Checks come in stages; a stage is tried only if all of the one before passed, so that one fault is told once.
    Whatever the checked object raises is a result. Only UsageError leaves this function: there is no such object, or a
    package that it needs is not installed.
    """
    try:
        subject = registry.build(kind, name, {})
    except UsageError:
        raise
    except Exception as error:
        yield Result(False, "can be built with its default settings", _line(error))
        return
    for stage in _task_stages(name, subject) if kind == "task" else _method_stages(name, subject):
        passed = True
        for what, check in stage:
            result = _result(what, check)
            passed &= result.passed
            yield result
        if not passed:
            return


def _result(what: str, check: Callable[[], None]) -> Result:
    try:
        check()
    except UsageError:
        raise
    except Exception as error:
        return Result(False, what, _line(error))
    return Result(True, what)


def _line(error: Exception) -> str:
    ours = isinstance(error, (_BrokenPromise, SimulatorError))
    return " ".join(f"{'' if ours else type(error).__name__ + ': '}{error}".split())


def _expect(holds: bool, why: str) -> None:
    if not holds:
        raise _BrokenPromise(why)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _recordable(kind: str, name: str, subject: Task | Method) -> None:
    for attribute in ("name", "version", "source"):
        _expect(_is_text(getattr(subject, attribute)), f"{attribute} must be text, got {getattr(subject, attribute)!r}")
    identity = registry.identity(kind, name, subject)
    try:
        json.dumps(identity)
    except TypeError as error:
        raise _BrokenPromise(f"a record cannot hold the settings {identity[f'{kind}_settings']}: {error}") from error


@contextmanager
def _global_seeds(seed: int) -> Iterator[None]:
    """Another state of every global generator inside the block; PyTorch's where it has been loaded."""
    torch = sys.modules.get("torch")
    with global_seed(np.random.default_rng(seed)):
        if torch is None:
            yield
            return
        with torch.random.fork_rng():
            torch.manual_seed(seed)
            yield


def _global_state() -> dict[str, Any]:
    """What tasks and methods share with the rest of the process, by its name."""
    state = {
        "numpy.random": joblib.hash(np.random.get_state()),  # noqa: NPY002 - looked at, not drawn from
        "random": random.getstate(),
        "numpy's floating-point error handling": np.geterr(),
        "warnings.filters": list(warnings.filters),
    }
    if torch := sys.modules.get("torch"):
        state["PyTorch's random state"] = torch.get_rng_state().tolist()
    return state


def _changed(before: dict[str, Any]) -> set[str]:
    after = _global_state()
    return {what for what in before if before[what] != after[what]}


# Tasks


def _task_stages(name: str, task: Task) -> Iterator[Stage]:
    yield iter(
        [
            ("says what it is, in a form that a record can hold", partial(_recordable, "task", name, task)),
            ("names parameters, units, prior, support and features", partial(_task_described, task)),
        ]
    )
    yield iter(
        [
            (f"has {NUM_TARGETS} targets within its prior", partial(_targets, task)),
            ("simulates 1 and 1000 events of the promised shape and type", partial(_batch_sizes, task)),
        ]
    )
    statistics = _Statistics(task)
    yield iter(
        [
            ("simulates every corner of its prior and its support", partial(_corners, task)),
            ("refuses theta outside its support", partial(_outside, task)),
            ("leaves theta as it is", partial(_theta_unchanged, task)),
            ("repeats its events for a seed, whatever the global seeds", partial(_same_seed, task)),
            ("makes other events for another seed", partial(_other_seed, task)),
            ("leaves global state as it is", partial(_task_global_state, task)),
            ("makes events that depend on theta", statistics.depends_on_theta),
            ("gives each row its own theta and randomness", statistics.own_theta_and_randomness),
            ("makes neighbouring rows independent", statistics.independent_rows),
            ("summarises events whatever their number and order", partial(_summary, task)),
            ("has a floor that more events do not raise", partial(_floor, task)),
            ("can be sent to a worker process", partial(_task_pickles, task)),
        ]
    )


def _task_described(task: Task) -> None:
    for attribute in ("prior", "support"):
        box = getattr(task, attribute)
        _expect(isinstance(box, Box), f"{attribute} must be a Box, got {box!r}")
    p = task.prior.dim
    for attribute in ("parameter_names", "parameter_units"):
        words = getattr(task, attribute)
        sound = isinstance(words, tuple) and len(words) == p and all(map(_is_text, words))
        _expect(sound, f"{attribute} must be {p} texts, one a parameter of the prior, got {words!r}")
    _expect(len(set(task.parameter_names)) == p, f"parameter_names must differ, got {task.parameter_names}")
    _expect(task.support.dim == p, f"the support has {task.support.dim} parameters, the prior {p}")
    inside = task.support.contains([task.prior.low, task.prior.high]).all()
    _expect(inside, f"the support {task.support} must contain the prior {task.prior}")
    d = task.num_features
    _expect(isinstance(d, numbers.Integral) and d >= 1, f"num_features must be a whole number from 1, got {d!r}")
    _expect(np.dtype(task.dtype).kind in "biuf", f"dtype must be a type of real numbers, got {task.dtype!r}")
    _expect(isinstance(task.discriminator, Discriminator), f"discriminator must be one, got {task.discriminator!r}")


def _targets(task: Task) -> None:
    targets = task.targets()
    expected = (NUM_TARGETS, task.prior.dim)
    _expect(np.shape(targets) == expected, f"targets have shape {np.shape(targets)}, not {expected}")
    _expect(bool(task.prior.contains(targets).all()), "a target lies outside the prior")
    _expect(np.array_equal(targets, task.targets()), "targets are not the same when asked for again")


def _batch_sizes(task: Task) -> None:
    rng = np.random.default_rng(0)
    for n in (1, 1000):
        checked_events(task, task.prior.sample(n, rng), rng)


def _corners(task: Task) -> None:
    rng = np.random.default_rng(0)
    for box in (task.prior, task.support):
        for corner in itertools.islice(itertools.product(*zip(box.low, box.high, strict=True)), 64):
            checked_events(task, np.tile(corner, (10, 1)), rng)


def _outside(task: Task) -> None:
    for theta in (task.support.low - 0.01 * task.support.width, task.support.high + 0.01 * task.support.width):
        try:
            task.simulate(theta[None], np.random.default_rng(0))
        except ValueError:
            continue
        raise _BrokenPromise(f"made an event at theta = {theta.tolist()}, where ValueError is due")


def _theta_unchanged(task: Task) -> None:
    theta = task.prior.sample(100, np.random.default_rng(0))
    before = theta.copy()
    task.simulate(theta, np.random.default_rng(0))
    _expect(np.array_equal(theta, before), "simulate changed the array of parameters that it was given")


def _events(task: Task, seed: int, global_seeds: int) -> NDArray:
    """1000 events across the prior."""
    with _global_seeds(global_seeds):
        return task.simulate(task.prior.sample(1000, np.random.default_rng(0)), np.random.default_rng(seed))


def _same_seed(task: Task) -> None:
    events = _events(task, 1, 1)
    _expect(np.array_equal(events, _events(task, 1, 1)), "two generators of one seed give different events")
    _expect(np.array_equal(events, _events(task, 1, 2)), "the events depend on the seed of a global generator")


def _other_seed(task: Task) -> None:
    same = np.array_equal(_events(task, 1, 1), _events(task, 2, 2))
    _expect(not same, "generators of different seeds give the same events: is the generator ignored?")


def _task_global_state(task: Task) -> None:
    with _global_seeds(1):
        before = _global_state()
        task.summary(task.simulate(task.prior.sample(1000, np.random.default_rng(0)), np.random.default_rng(1)))
        changed = _changed(before)
    _expect(not changed, f"simulate or summary changes {', '.join(sorted(changed))}")


def _p_value(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Kolmogorov and Smirnov's, least over the features, times their number (Bonferroni): (n, d), (m, d) -> number."""
    return float(ks_2samp(a, b, method="asymp").pvalue.min() * a.shape[1])


class _Statistics:
    """Checks of the distribution of events, at two theta where it differs clearly."""

    def __init__(self, task: Task) -> None:
        self._task = task

    def depends_on_theta(self) -> None:
        rng = np.random.default_rng(1)
        first, second = (self._features(self._simulate(theta, 1000, rng)) for theta in self._theta)
        _expect(_p_value(first, second) < 1e-3, "1000 events at each of eight theta in the prior look alike")

    def own_theta_and_randomness(self) -> None:
        """Compares batches that alternate between two theta with events that were made one a call."""
        rng = np.random.default_rng(2)
        size = NUM_ALONE // NUM_BATCHES
        batches = [self._task.simulate(np.tile(self._theta, (size, 1)), rng) for _ in range(NUM_BATCHES)]
        for row, theta in enumerate(self._theta):
            alone = self._features(np.concatenate([self._simulate(theta, 1, rng) for _ in range(NUM_ALONE)]))
            mixed = [self._features(x[row::2]) for x in batches]
            # All together show a wrong theta, each by itself a random number that all of its rows share.
            p = min(_p_value(x, alone) for x in (np.concatenate(mixed), *mixed))
            _expect(
                p * 2 * (NUM_BATCHES + 1) > ALPHA,
                f"at theta = {theta.tolist()}, events of a batch that mixes two theta are not distributed as events "
                "made one a call: does a row use the theta of another, or a random number drawn once for the batch?",
            )

    def independent_rows(self) -> None:
        n = 2000
        ranks = rankdata(self._features(self._simulate(self._theta[0], n, np.random.default_rng(3))), axis=0)
        # A feature that is nearly always the same has too few exceptions for its correlation to be Gaussian.
        ranks = ranks[:, ranks.var(axis=0) > n**2 / 12 / 4]
        z = (ranks - ranks.mean(axis=0)) / ranks.std(axis=0)
        for lag in (1, n // 2):
            correlation = (z[lag:] * z[:-lag]).mean(axis=0)
            p = 2 * norm.sf(np.abs(correlation) * np.sqrt(n - lag)) * 2 * z.shape[1]
            _expect(bool((p > ALPHA).all()), f"rows i and i + {lag} of a batch of {n} are correlated")

    def _simulate(self, theta: NDArray[np.float64], n: int, rng: np.random.Generator) -> NDArray:
        return self._task.simulate(np.tile(theta, (n, 1)), rng)

    @property
    def _theta(self) -> NDArray[np.float64]:
        """The two theta: (2, p)."""
        return self._contrast[0]

    def _features(self, x: NDArray) -> NDArray[np.float64]:
        """The features, and last the combination of them and their squares that tells the two theta apart.

        Where events are images, it sees what no single pixel shows. (n, d) -> (n, d + 1).
        """
        _, center, direction = self._contrast
        return np.column_stack([x, _moments(x, center) @ direction])

    @cached_property
    def _contrast(self) -> tuple[NDArray[np.float64], ...]:
        """Of eight theta in the prior the two whose first and second moments differ most.

        With them (2, p), the mean event (d,) and the direction (2 d,) in the space of moments in which they differ.
        """
        prior, rng = self._task.prior, np.random.default_rng(0)
        theta = np.vstack([prior.low, prior.center, prior.high, self._task.targets()[:5]])
        x = np.stack([self._simulate(candidate, 500, rng) for candidate in theta])
        center = x.mean(axis=(0, 1))
        moments = _moments(x, center)
        mean, variance = moments.mean(axis=1), moments.var(axis=1).mean(axis=0)
        gap = mean[:, None] - mean
        direction = np.divide(gap, variance, out=np.zeros_like(gap), where=variance > 0)
        pair = np.unravel_index((gap * direction).sum(axis=-1).argmax(), gap.shape[:2])
        return theta[list(pair)], center, direction[pair]


def _moments(x: NDArray, center: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., d) -> (..., 2 d)."""
    return np.concatenate([x - center, (x - center) ** 2], axis=-1)


def _summary(task: Task) -> None:
    rng = np.random.default_rng(0)
    x = task.simulate(np.tile(task.prior.center, (1000, 1)), rng)
    x.setflags(write=False)
    summary = task.summary(x)
    sound = isinstance(summary, np.ndarray) and summary.ndim == 1 and summary.size and summary.dtype.kind == "f"
    _expect(bool(sound), f"a summary must be an array (k,) of floats, got {summary!r:.200}")
    for some in (x, x[:128], x[:10]):
        shape = np.shape(task.summary(some))
        _expect(shape == summary.shape, f"{len(some)} events have a summary {shape}, {len(x)} have {summary.shape}")
        _expect(bool(np.isfinite(task.summary(some)).all()), f"the summary of {len(some)} events is not finite")
    permuted = task.summary(rng.permutation(x))
    _expect(np.allclose(summary, permuted, rtol=1e-6, atol=1e-9), "the summary depends on the order of the events")


def _floor(task: Task) -> None:
    for theta in task.targets():
        few = task.floor(theta, 1000, 1000)
        more = {
            "more observations": task.floor(theta, 100_000, 1000),
            "more simulations": task.floor(theta, 1000, 100_000),
            "the likelihood": task.floor(theta, 1000, None),
        }
        for floor in (few, *more.values()):
            sound = isinstance(floor, numbers.Real) and not np.isinf(floor) and not floor <= 0
            _expect(sound, f"the floor at theta = {theta.tolist()} must be a positive number, or NaN, got {floor!r}")
        for what, floor in more.items():
            _expect(
                not floor > few * (1 + 1e-9),
                f"at theta = {theta.tolist()}, {what} raised the floor from {few:g} to {floor:g}",
            )


def _task_pickles(task: Task) -> None:
    events = _events(task, 1, 1)  # first, so that what it keeps of them is pickled too
    copy = pickle.loads(pickle.dumps(task))
    _expect(np.array_equal(events, _events(copy, 1, 1)), "a pickled copy makes other events from the same seed")


# Methods


def _method_stages(name: str, method: Method) -> Iterator[Stage]:
    yield iter(
        [
            ("says what it is, in a form that a record can hold", partial(_recordable, "method", name, method)),
            ("declares the smallest budget it can use", partial(_minimum, method)),
            ("can be sent to a worker process", lambda: pickle.loads(pickle.dumps(method))),
        ]
    )
    trials = []
    for task in METHOD_TASKS:
        least = method.min_simulations(registry.build("task", task, {}).prior.dim)
        cell = Cell(task, {}, name, {}, 0, 0, least, NUM_OBSERVATIONS, 0)
        trials += [_Trial(cell), _Trial(replace(cell, budget=max(2 * least, MODEST_BUDGET) | 1))]
    yield (
        (f"makes an estimate on {trial.cell.task} from {trial.cell.budget} events", trial.estimate) for trial in trials
    )
    smallest, last = trials[0], trials[-1]
    yield iter(
        [
            ("traces its estimate against the events used", lambda: [trial.trace() for trial in trials]),
            ("says why where it leaves much of the budget", lambda: [trial.left_over() for trial in trials]),
            ("leaves global state as it is", last.global_state),
            ("repeats its estimate bit for bit for a seed, whatever the global seeds", last.repeats),
            ("leaves the observed events as they are", partial(_observed_unchanged, method, smallest.cell)),
            ("makes no estimate from fewer events than it needs", partial(_too_small, smallest.cell)),
            ("lets errors of the simulator through", partial(_failing_simulator, method, last)),
        ]
    )


def _minimum(method: Method) -> None:
    for p in (1, 2):
        least = method.min_simulations(p)
        sound = isinstance(least, numbers.Integral) and least >= 1
        _expect(sound, f"min_simulations({p}) must be a whole number from 1, got {least!r}")


class _Trial:
    """A cell that is carried out once, as a sweep would, and looked at from several sides."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.record: dict[str, Any] = {}
        self._again: dict[str, Any] = {}

    def estimate(self) -> None:
        self.record = execute(self.cell)
        status, used = self.record["status"], self.record["simulations_used"]
        _expect(status == Status.OK, f"{status}: {self.record['message']}")
        _expect(used <= self.cell.budget, f"used {used} events")
        for name in ("how", "spread_of"):
            _expect(_is_text(self.record[name]), f"{name} of the estimate must be text, got {self.record[name]!r}")
        message = self.record["message"]
        _expect(isinstance(message, str), f"message of the estimate must be text, got {message!r}")
        std = self.record["std"]
        _expect(all(value is None or value >= 0 for value in std), f"std of the estimate is negative: {std}")

    def trace(self) -> None:
        p = self.cell.build_task().prior.dim
        last = 0
        for point in self.record["trace"]:
            simulations, theta, std = point["simulations"], point["theta"], point["std"]
            sound = last <= simulations <= self.record["simulations_used"]
            _expect(sound, f"goes from {last} to {simulations} events, of {self.record['simulations_used']} used")
            _expect(len(theta) == p and None not in theta, f"has theta = {theta}, where {p} finite numbers are due")
            _expect(std is None or len(std) == p, f"has std = {std}, where {p} numbers are due")
            last = simulations

    def left_over(self) -> None:
        left = self.cell.budget - self.record["simulations_used"]
        unexplained = left > MAX_LEFT_WITHOUT_REASON * self.cell.budget and not _is_text(self.record["message"])
        _expect(not unexplained, f"left {left} of {self.cell.budget} events on {self.cell.task}, and no message")

    def global_state(self) -> None:
        """Carries the cell out again, now that packages are loaded: what loading them does is not the method's."""
        with _global_seeds(1):
            before = _global_state()
            self._again = execute(self.cell)
            changed = _changed(before)
        _expect(not changed, f"infer changes {', '.join(sorted(changed))}")

    def repeats(self) -> None:
        for field in ("status", "simulations_used", "theta_hat", "mean", "std", "trace"):
            first, second = self.record[field], self._again[field]
            _expect(first == second, f"{field} was {first}, then {second}")


def _problem(cell: Cell, progress: Callable[[int], None] | None = None) -> Problem:
    task = cell.build_task()
    simulate = MeteredSimulator(task, cell.budget, stream(cell.seed, "check"), progress)
    return Problem.of(task, observe(task, cell.target, cell.num_observations, cell.seed), simulate)


def _observed_unchanged(method: Method, cell: Cell) -> None:
    problem = _problem(cell)
    before = problem.x_observed.copy()
    method.infer(problem, np.random.default_rng(0))
    _expect(np.array_equal(before, problem.x_observed), "infer changed the events in x_observed")


def _too_small(cell: Cell) -> None:
    if cell.budget == 1:
        return
    record = execute(replace(cell, budget=1))
    status, used = record["status"], record["simulations_used"]
    sound = status == Status.BUDGET_EXHAUSTED or (status == Status.OK and used > 0)
    _expect(sound, f"with a budget of 1, status {status} after {used} events, where BudgetExhausted is due")


def _failing_simulator(method: Method, trial: _Trial) -> None:
    """The simulator fails once, halfway, so that a method that just tries again comes to an end too."""
    halfway = trial.record["simulations_used"] / 2
    failed_at = []

    def fail_once(used: int) -> None:
        if used >= halfway and not failed_at:
            failed_at.append(used)
            raise SimulatorError("the simulator failed on purpose")

    try:
        method.infer(_problem(trial.cell, fail_once), np.random.default_rng(0))
    except SimulatorError:
        return
    except Exception as error:
        raise _BrokenPromise(f"SimulatorError became {type(error).__name__}: {error}") from error
    _expect(not failed_at, f"made an estimate though the simulator failed after {failed_at} events")
