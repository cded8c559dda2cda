"""One cell of the sweep: what identifies it, its random streams, and how it is carried out and scored."""

import hashlib
import importlib.metadata
import json
import math
import numbers
import platform
import subprocess
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from enum import StrEnum
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.budget import MeteredSimulator, checked_events
from avobench.methods import Estimate, Method, TracePoint
from avobench.methods.problem import Problem
from avobench.tasks import Task
from avobench.tasks.contract import stable_hash
from avobench.tasks.errors import (
    AvobenchError,
    BudgetExhausted,
    InvalidEstimate,
    SimulatorError,
    SupportError,
    UsageError,
)

SCHEMA_VERSION = 1
RECORDED_VERSIONS = ("avobench", "numpy", "scipy", "torch", "pyabc", "elfi", "GPy", "pythia8mc")


class Status(StrEnum):
    """Outcome of a cell; `ok` exactly when an estimate was made within the budget."""

    OK = "ok"
    BUDGET_EXHAUSTED = "budget_exhausted"
    """The method asked for more events than the budget holds before it had an estimate."""
    SIMULATOR_ERROR = "simulator_error"
    """The task's simulator, summary or floor raised, or returned something of the wrong shape, type or value."""
    OUTSIDE_SUPPORT = "outside_support"
    """The method asked for events at parameters where the simulator is not defined."""
    METHOD_ERROR = "method_error"
    """The method raised."""
    INVALID_ESTIMATE = "invalid_estimate"
    """The method returned something that is not a finite estimate within the support."""
    CRASHED = "crashed"
    """The worker process died twice in this cell."""


STATUS_OF = {
    BudgetExhausted: Status.BUDGET_EXHAUSTED,
    SimulatorError: Status.SIMULATOR_ERROR,
    SupportError: Status.OUTSIDE_SUPPORT,
    InvalidEstimate: Status.INVALID_ESTIMATE,
}


@dataclass(frozen=True)
class Cell:
    """One inference: a task's target, a method, a repetition, under one budget and seed.

    `task` and `method` are names or `module:Class`. `identity` holds everything that determines the result.
    """

    task: str
    task_settings: dict[str, Any]
    method: str
    method_settings: dict[str, Any]
    target: int
    repetition: int
    budget: int
    num_observations: int
    seed: int
    identity: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        task, method = self.build_task(), self.build_method()
        identity = {
            **registry.identity("task", self.task, task),
            **registry.identity("method", self.method, method),
            "theta_true": registry.blamed(lambda: task.targets()[self.target].tolist(), f"task '{self.task}'"),
            **{name: getattr(self, name) for name in ("target", "repetition", "budget", "num_observations", "seed")},
        }
        try:
            object.__setattr__(self, "identity", json.loads(json.dumps(identity, allow_nan=False)))
        except (TypeError, ValueError) as error:
            given = {**identity["task_settings"], **identity["method_settings"]}
            raise UsageError(f"settings must be finite numbers, texts or lists of them, got {given}") from error
        names, theta = list(task.parameter_names), identity["theta_true"]
        if not len(names) == len(set(names)) == len(theta):
            raise UsageError(f"task '{self.task}' has targets of {len(theta)} parameters and the names {names}")

    def build_task(self) -> Task:
        return registry.build("task", self.task, self.task_settings)

    def build_method(self) -> Method:
        return registry.build("method", self.method, self.method_settings)

    @property
    def id(self) -> str:
        return hashlib.sha256(json.dumps(self.identity, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def label(self) -> str:
        return f"{self.identity['task']} {self.identity['method']} target {self.target} repetition {self.repetition}"


def reason(record: dict[str, Any]) -> str:
    """Status and message of a cell that failed, in a line."""
    return f"{record['status']}: {' '.join(record['message'].split()) or 'no message'}"


def stream(seed: int, *words: object) -> np.random.Generator:
    """The random stream that belongs to `words` under the root seed."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(stable_hash(*map(str, words)),)))


def observe(task: Task, target: int, num_observations: int, seed: int) -> NDArray:
    """The observed events of a target, the same for every method and repetition: (N, d)."""
    theta = np.repeat(task.targets()[target : target + 1], num_observations, axis=0)
    return checked_events(task, theta, stream(seed, "observation", task.name, target))


@lru_cache(maxsize=1)
def _observed(task: str, settings: str, target: int, num_observations: int, seed: int) -> NDArray:
    """The same from the name of the task and its settings, in JSON; kept, as the next cell often has the same."""
    return observe(registry.build("task", task, json.loads(settings)), target, num_observations, seed)


class Trial:
    """A cell while it is carried out, by itself or with others: what its method is given, and how it ended.

    What goes wrong is kept as `failure` and becomes status and message of the record; only KeyboardInterrupt leaves.
    """

    def __init__(self, cell: Cell, progress: Callable[[int], None] | None = None, debug: bool = False) -> None:
        """Observe the target of the cell and pose its problem."""
        start = time.perf_counter()
        self.cell, self._debug = cell, debug
        self._started = datetime.now(UTC).isoformat(timespec="seconds")
        self._task, self.method = cell.build_task(), cell.build_method()
        words = (self._task.name, self.method.name, cell.target, cell.repetition)
        self.simulate = MeteredSimulator(self._task, cell.budget, stream(cell.seed, "simulator", *words), progress)
        self.rng = stream(cell.seed, "method", *words)
        self.problem: Problem | None = None
        self.estimate: object = None
        self.failure: BaseException | None = None
        self.method_seconds = 0.0
        """In the method outside of the simulator."""
        self.remark = ""
        """Added to the message of the estimate."""
        self._floors: dict[str, float | None] = {}
        with self.failing():
            self._floors = _floors(self._task, cell)
            settings = json.dumps(cell.task_settings, sort_keys=True)
            x_observed = _observed(cell.task, settings, cell.target, cell.num_observations, cell.seed)
            self.problem = Problem.of(self._task, x_observed, self.simulate)
        self._observation_seconds = time.perf_counter() - start

    @contextmanager
    def failing(self) -> Iterator[None]:
        """What goes wrong within the block becomes the failure of this cell; with `debug` its traceback is printed."""
        try:
            yield
        except (Exception, SystemExit) as error:
            self.failure = error
            if self._debug:
                traceback.print_exc()

    def record(self) -> dict[str, Any]:
        """The record of the cell, its estimate checked and scored."""
        start = time.perf_counter()
        scored, status, message = {}, Status.OK, ""
        if self.failure is None:
            with self.failing():
                _check(self.estimate, self.problem, self.simulate.used)
                scored = _scored(self.estimate, self._task, self.cell)
                message = "; ".join(filter(None, (self.estimate.message, self.remark)))
        if (error := self.failure) is not None:
            status = next((word for kind, word in STATUS_OF.items() if isinstance(error, kind)), Status.METHOD_ERROR)
            message = told(error)
            if self.problem is None:  # where it was too much, e.g. for memory: no method has run
                status = Status.SIMULATOR_ERROR
        record = {
            **blank_record(self.cell, status, message),
            **self._floors,
            "started": self._started,
            "simulations_requested": self.simulate.requested,
            "simulations_used": self.simulate.used,
            "simulations_refused": self.simulate.refused,
            "simulations_discarded": self.simulate.used,  # unless an estimate was made of them
            "observation_seconds": self._observation_seconds,
            "simulator_seconds": self.simulate.seconds,
            "method_seconds": self.method_seconds,
            "peak_memory_mib": peak_memory_mib(),
            **scored,
        }
        record["harness_seconds"] = time.perf_counter() - start
        return record


def execute(cell: Cell, progress: Callable[[int], None] | None = None, debug: bool = False) -> dict[str, Any]:
    """Carry out a cell and return its record; whatever goes wrong becomes its status and message.

    Only KeyboardInterrupt leaves this function. With `debug` the traceback of a failure goes to standard error.
    """
    reset_peak_memory()
    trial = Trial(cell, progress, debug)
    if trial.problem is not None:
        start = time.perf_counter()
        with trial.failing():
            trial.estimate = trial.method.infer(trial.problem, trial.rng)
        trial.method_seconds = time.perf_counter() - start - trial.simulate.seconds
    return trial.record()


def execute_together(
    cells: Sequence[Cell], progress: Sequence[Callable[[int], None] | None], debug: bool = False
) -> list[dict[str, Any]]:
    """Carry out cells of one task and method as one, by `Method.infer_together`, and return their records in order.

    Each record is that which `execute` makes, to floating-point reordering of the estimate, but for `method_seconds`,
    an equal share of what all took, and a remark in `message`. A cell that cannot be observed fails alone. Whatever
    the method raises leaves this function, and no cell has a record: it is not known whose fault it is.
    """
    reset_peak_memory()
    trials = [Trial(cell, heartbeat, debug) for cell, heartbeat in zip(cells, progress, strict=True)]
    posed = [trial for trial in trials if trial.problem is not None]
    if posed:
        start = time.perf_counter()
        estimates = posed[0].method.infer_together([trial.problem for trial in posed], [trial.rng for trial in posed])
        seconds = time.perf_counter() - start - sum(trial.simulate.seconds for trial in posed)
        if not isinstance(estimates, list) or len(estimates) != len(posed):
            raise InvalidEstimate(
                f"infer_together must return a list of {len(posed)} estimates, got {estimates!r:.100}"
            )
        for trial, estimate in zip(posed, estimates, strict=True):
            trial.estimate, trial.method_seconds = estimate, seconds / len(posed)
            trial.remark = f"one of {len(posed)} cells carried out together"
    return [trial.record() for trial in trials]


def told(error: BaseException) -> str:
    """What went wrong, for a record or a line to the user."""
    if isinstance(error, AvobenchError):
        return str(error)
    if type(error).__name__ == "OutOfMemoryError":  # PyTorch's, whose message goes on about its allocator
        message = ". ".join(str(error).split(". ")[:2])
        return f"{message}; fewer cells at a time (--group, --jobs) or --device cpu need less"
    return f"{type(error).__name__}: {error}"


def blank_record(cell: Cell, status: Status, message: str) -> dict[str, Any]:
    """A record with every field of the schema, for a cell of which nothing more is known."""
    return {
        "schema_version": SCHEMA_VERSION,
        "id": cell.id,
        **cell.identity,
        "parameter_names": list(cell.build_task().parameter_names),
        "status": str(status),
        "message": message,
        "theta_hat": None,
        "squared_error": None,
        "floor": None,
        "floor_likelihood": None,
        "how": None,
        "spread_of": None,
        "mean": None,
        "std": None,
        "trace": [],
        "simulations_requested": None,
        "simulations_used": None,
        "simulations_discarded": None,
        "simulations_refused": None,
        "observation_seconds": 0.0,
        "simulator_seconds": 0.0,
        "method_seconds": 0.0,
        "harness_seconds": 0.0,
        "peak_memory_mib": None,
        "started": None,
        "versions": versions(),
    }


@cache
def versions() -> dict[str, str | None]:
    """Versions of what a result depends on, and the commit of the source where it is a git checkout."""
    found: dict[str, str | None] = {"python": platform.python_version()}
    for name in RECORDED_VERSIONS:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = None
    source = Path(__file__).resolve().parents[2]
    found["commit"] = None
    if (source / ".git").exists():
        git = ["git", "-C", str(source)]
        try:
            head = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=True)
            changed = subprocess.run([*git, "diff", "--quiet", "HEAD", "--", "avobench"])
            found["commit"] = head.stdout.strip() + "-changed" * (changed.returncode != 0)
        except (OSError, subprocess.CalledProcessError):
            found["commit"] = "unknown"
    return found


def _floors(task: Task, cell: Cell) -> dict[str, float | None]:
    floors = {}
    for name, num_simulations in (("floor", cell.budget), ("floor_likelihood", None)):
        try:
            floor = task.floor(task.targets()[cell.target], cell.num_observations, num_simulations)
        except (Exception, SystemExit) as error:
            raise SimulatorError(f"the floor of {task.name} raised {type(error).__name__}: {error}") from error
        if not isinstance(floor, numbers.Real):
            raise SimulatorError(f"the floor of {task.name} must be a number, got {floor!r:.100}")
        if floor < 0:
            raise SimulatorError(f"the floor of {task.name} must not be negative, got {floor!r:.100}")
        floors[name] = _number(floor)
    return floors


def _scored(estimate: Estimate, task: Task, cell: Cell) -> dict[str, Any]:
    theta_true = task.targets()[cell.target]
    return {
        "theta_hat": estimate.theta.tolist(),
        "squared_error": float(((estimate.theta - theta_true) ** 2).sum()),
        "how": estimate.how,
        "spread_of": estimate.spread_of,
        "mean": [_number(value) for value in estimate.mean],
        "std": [_number(value) for value in estimate.std],
        "trace": [
            {
                "simulations": int(point.simulations),
                "theta": [_number(value) for value in point.theta],
                "std": None if point.std is None else [_number(value) for value in point.std],
            }
            for point in estimate.trace
        ],
        "simulations_discarded": int(estimate.discarded),
    }


def _check(estimate: object, problem: Problem, used: int) -> None:
    """Raise InvalidEstimate unless `estimate` is one that a record can hold."""
    if not isinstance(estimate, Estimate):
        raise InvalidEstimate(f"the method returned {type(estimate).__name__} instead of an Estimate")
    p = problem.prior.dim
    if not isinstance(estimate.trace, list):
        raise InvalidEstimate(f"the trace must be a list of TracePoint, got {estimate.trace!r:.100}")
    vectors = [("theta", estimate.theta), ("mean", estimate.mean), ("std", estimate.std)]
    for point in estimate.trace:
        if not (isinstance(point, TracePoint) and isinstance(point.simulations, int | np.integer)):
            raise InvalidEstimate(f"the trace must be a list of TracePoint, got {point!r}")
        vectors += [("theta of the trace", point.theta)]
        vectors += [] if point.std is None else [("std of the trace", point.std)]
    for name, value in vectors:
        if not isinstance(value, np.ndarray) or value.shape != (p,) or value.dtype.kind != "f":
            raise InvalidEstimate(f"{name} of the estimate must be a float array of shape ({p},), got {value!r}")
    simulations = [point.simulations for point in estimate.trace]
    if simulations != sorted(simulations) or not all(0 <= number <= used for number in simulations):
        raise InvalidEstimate(f"the trace must go from 0 towards the {used} used, got {simulations!r:.100}")
    if any((value < 0).any() for name, value in vectors if name.startswith("std")):
        raise InvalidEstimate("the std of the estimate must not be negative")
    if not np.isfinite(estimate.theta).all() or not problem.support.contains(estimate.theta)[0]:
        raise InvalidEstimate(f"the estimate {estimate.theta.tolist()} is not within the support")
    if not (isinstance(estimate.discarded, int | np.integer) and 0 <= estimate.discarded <= used):
        raise InvalidEstimate(f"discarded must be a number from 0 to the {used} used, got {estimate.discarded!r}")
    for name in ("how", "spread_of", "message"):
        if not isinstance(getattr(estimate, name), str):
            raise InvalidEstimate(f"{name} of the estimate must be text, got {getattr(estimate, name)!r}")


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def reset_peak_memory() -> None:
    """Start a new high-water mark (Linux), so that a reused worker reports each cell's own peak."""
    with suppress(OSError):  # not Linux, or not allowed: the mark of the whole process stands
        Path("/proc/self/clear_refs").write_text("5")


def peak_memory_mib() -> float | None:
    """High-water mark of resident memory in MiB since the last reset; None where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024
