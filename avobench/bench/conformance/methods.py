"""The checks of a method, on two tasks and with two budgets each."""

import numbers
import pickle
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.cell import Cell
from avobench.bench.cells.streams import observe, stream
from avobench.bench.cells.trial import carried_out, execute, execute_together
from avobench.bench.conformance.promises import BrokenPromise, Round, expect, recordable, state_kept
from avobench.bench.plugins import registry
from avobench.bench.store.status import Status
from avobench.methods import Method
from avobench.methods.problem import Problem
from avobench.tasks.errors import SimulatorError, raised

METHOD_TASKS = ("poisson", "carl")
NUM_OBSERVATIONS = 1000
"""So many events are enough to infer something from; the checks are not about how good an estimate is."""
MODEST_BUDGET = 3001
"""Events of the larger of the two budgets, where twice the method's minimum is not more. Odd on purpose."""
MAX_LEFT_WITHOUT_REASON = 0.1
"""Share of the budget that a method may leave without a word, as its contract says."""
MAX_SHIFT = 0.1
"""Rounding may shift an estimate made together with others by so many of the spreads that the method states."""


def rounds(name: str, method: Method) -> Iterator[Round]:
    yield [
        ("says what it is, in a form that a record can hold", partial(recordable, "method", name, method)),
        ("declares the smallest budget it can use", partial(_minimum, method)),
        ("can be sent to a worker process", lambda: pickle.loads(pickle.dumps(method))),
    ]
    trials = []
    for task in METHOD_TASKS:
        least = method.min_simulations(registry.build("task", task, {}).prior.dim)
        cell = Cell(task, {}, name, {}, 0, 0, least, NUM_OBSERVATIONS, 0)
        trials += [_Trial(cell), _Trial(replace(cell, budget=max(2 * least, MODEST_BUDGET) | 1))]
    yield [
        (f"makes an estimate on {trial.cell.task} from {trial.cell.budget} events", trial.estimate) for trial in trials
    ]
    smallest, last = trials[0], trials[-1]
    yield [
        ("traces its estimate against the events used", lambda: [trial.trace() for trial in trials]),
        ("says why where it leaves much of the budget", lambda: [trial.left_over() for trial in trials]),
        ("leaves global state as it is", last.global_state),
        ("repeats its estimate bit for bit for a seed, whatever the global seeds", last.repeats),
        ("leaves the observed events as they are", partial(_observed_unchanged, method, smallest.cell)),
        ("makes no estimate from fewer events than it needs", partial(_too_small, smallest.cell)),
        ("lets errors of the simulator through", partial(_failing_simulator, method, last)),
    ]
    if method.together:
        yield [("makes the same estimates together as alone", partial(_together, last))]


def _minimum(method: Method) -> None:
    for p in (1, 2):
        least = method.min_simulations(p)
        sound = isinstance(least, numbers.Integral) and least >= 1
        expect(sound, f"min_simulations({p}) must be a whole number from 1, got {least!r}")


class _Trial:
    """A cell that is carried out once, as a sweep would, and looked at from several sides."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.record: dict[str, Any] = {}
        self._again: dict[str, Any] = {}

    def estimate(self) -> None:
        self.record = execute(self.cell)
        status, used = self.record["status"], self.record["simulations_used"]
        expect(status == Status.OK, f"{status}: {self.record['message']}")
        expect(used <= self.cell.budget, f"used {used} events of a budget of {self.cell.budget}")
        for name in ("how", "spread_of"):
            expect(self.record[name].strip() != "", f"{name} of the estimate must be text, got {self.record[name]!r}")
        std = self.record["std"]
        expect(all(value is None or value >= 0 for value in std), f"std of the estimate is negative: {std}")

    def trace(self) -> None:
        """The order of its points is told with the estimate; a NaN, which a trace may hold, is None in a record."""
        for point in self.record["trace"]:
            simulations, theta = point["simulations"], point["theta"]
            expect(None not in theta, f"has theta = {theta} after {simulations} events, where finite numbers are due")

    def left_over(self) -> None:
        unused = self.cell.budget - self.record["simulations_used"]
        explained = unused <= MAX_LEFT_WITHOUT_REASON * self.cell.budget or self.record["message"].strip() != ""
        expect(explained, f"left {unused} of {self.cell.budget} events on {self.cell.task}, and no message")

    def global_state(self) -> None:
        """Carries the cell out again, now that packages are loaded: what loading them does is not the method's."""
        with state_kept(by="infer"):
            self._again = carried_out(self.cell)

    def repeats(self) -> None:
        for field in ("status", "simulations_used", "theta_hat", "mean", "std", "trace"):
            first, second = self.record[field], self._again[field]
            expect(first == second, f"{field} was {first}, then {second}")


def _problem(cell: Cell, progress: Callable[[int], None] | None = None) -> Problem:
    task = cell.build_task()
    simulate = MeteredSimulator(task, cell.budget, stream(cell.seed, "check"), progress)
    return pose(task, observe(task, cell.target, cell.num_observations, cell.seed), simulate)


def _observed_unchanged(method: Method, cell: Cell) -> None:
    problem = _problem(cell)
    before = problem.x_observed.copy()
    method.infer(problem, np.random.default_rng(0))
    expect(np.array_equal(before, problem.x_observed), "infer changed the events in x_observed")


def _too_small(cell: Cell) -> None:
    if cell.budget == 1:
        return
    record = execute(replace(cell, budget=1))
    status, used = record["status"], record["simulations_used"]
    exhausted = status == Status.BUDGET_EXHAUSTED
    expect(exhausted, f"with a budget of 1, status {status} after {used} events, where BudgetExhausted is due")


def _together(trial: _Trial) -> None:
    cells = [replace(trial.cell, target=target) for target in range(3)]
    for cell, record in zip(cells, execute_together(cells, [None] * len(cells)), strict=True):
        alone = trial.record if cell == trial.cell else execute(cell)
        for field in ("status", "simulations_used"):
            expect(record[field] == alone[field], f"{field} of {cell.label} is {alone[field]}, then {record[field]}")
        shift = np.abs(np.subtract(record["theta_hat"], alone["theta_hat"]))
        spread = np.array([0.0 if value is None else value for value in alone["std"]])
        near = (shift <= MAX_SHIFT * spread + 1e-6 * cell.build_task().prior.width).all()
        expect(near, f"theta_hat of {cell.label} is {alone['theta_hat']}, then {record['theta_hat']}")


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
        raise BrokenPromise(f"SimulatorError became {raised(error)}") from error
    expect(not failed_at, f"made an estimate though the simulator failed after {failed_at} events")
