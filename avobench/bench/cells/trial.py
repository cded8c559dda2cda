"""A cell carried out: its problem posed, its method run, its estimate checked and scored, its record made."""

import json
import numbers
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.bench.cells.budget import SPARE, MeteredSimulator, asked_of, pose
from avobench.bench.cells.cell import Cell
from avobench.bench.cells.estimates import require_recordable
from avobench.bench.cells.prior_shares import in_shares, raw
from avobench.bench.cells.state import peak_memory_mib, put_back, reset_peak_memory
from avobench.bench.cells.streams import observe, stream
from avobench.bench.plugins import registry
from avobench.bench.store.record import SCHEMA_VERSION, SECONDS, Record, decode_record, encode
from avobench.bench.store.status import Status
from avobench.bench.store.versions import versions
from avobench.methods import Estimate, Problem
from avobench.tasks import Task
from avobench.tasks.errors import (
    AvobenchError,
    BudgetExhausted,
    InvalidEstimate,
    SimulatorError,
    SupportError,
    raised,
    text_of,
)
from avobench.tasks.missing import Recorded
from avobench.tasks.region import failing

STATUS_OF = {
    BudgetExhausted: Status.BUDGET_EXHAUSTED,
    SimulatorError: Status.SIMULATOR_ERROR,
    SupportError: Status.OUTSIDE_SUPPORT,
    InvalidEstimate: Status.INVALID_ESTIMATE,
}


@lru_cache(maxsize=1)
def _observed(task: str, settings: str, target: int, num_observations: int, seed: int) -> NDArray:
    """The observed events of a task; kept, as the next cell often has the same, and never handed to a method."""
    return observe(registry.build("task", task, json.loads(settings)), target, num_observations, seed)


class Trial:
    """A cell while it is carried out, by itself or with others: what its method is given, and how it ended.

    What goes wrong is kept as `failure` and becomes status and message of the record; only KeyboardInterrupt leaves.
    """

    def __init__(self, cell: Cell, progress: Callable[[int], None] | None = None, debug: bool = False) -> None:
        start = time.perf_counter()
        self.cell, self._debug = cell, debug
        self._started = datetime.now(UTC).isoformat(timespec="seconds")
        self._task, self.method = cell.build_task(), cell.build_method()
        # An amortised method has the same events for every target: one budget for all, whoever simulates first.
        of_target = () if self.method.amortised else (cell.target,)
        words = (self._task.name, self.method.name, *of_target, cell.repetition)
        metered = partial(MeteredSimulator, rng=stream(cell.seed, "simulator", *words), progress=progress)
        self.simulate = metered(self._task, cell.budget)
        self.rng = stream(cell.seed, "method", *words)
        self.problem: Problem | None = None
        self.estimate: object = None
        self.failure: BaseException | None = None
        self.method_seconds = 0.0
        """The seconds in the method outside of the simulator."""
        self.remark = ""
        """A remark that is added to the message of the estimate."""
        self._floors: dict[str, float | None] = {}
        with self.failing():
            self._floors = _floors(self._task, cell)
            settings = json.dumps(cell.task_settings, sort_keys=True)
            # An amortised method shares its simulated summaries among all targets, so these have one reference.
            x = _observed(cell.task, settings, cell.target, cell.num_observations, cell.seed)
            reference = x if of_target else _observed(cell.task, settings, 0, cell.num_observations, cell.seed)
            recorded = Recorded(self._task, reference)
            self._posed, self._x_observed = in_shares(recorded.task(self._task), self.method), recorded.events(x)
            asked = cell.budget
            if failing(self._posed):
                asked = asked_of(self._posed, int((1 - SPARE) * cell.budget))
            self.simulate = metered(self._posed, asked, reserve=cell.budget - asked)
            self.problem = pose(self._posed, self._x_observed.copy(), self.simulate, recorded.events(reference))
        self._observation_seconds = time.perf_counter() - start

    @contextmanager
    def failing(self) -> Iterator[None]:
        """An error within the block becomes the failure of this cell; with `debug` its traceback is printed."""
        try:
            yield
        except (Exception, SystemExit) as error:
            self.failure = error
            if self._debug:
                traceback.print_exc()

    def record(self) -> dict[str, Any]:
        """The record of the cell, its estimate checked and scored; as it is read back once it is written."""
        start = time.perf_counter()
        if self.failure is None:
            with self.failing():
                return self._estimated(start)
        status = next((word for kind, word in STATUS_OF.items() if isinstance(self.failure, kind)), Status.METHOD_ERROR)
        if self.problem is None:  # where it was too much, e.g. for memory: no method has run
            status = Status.SIMULATOR_ERROR
        return self._recorded(status, message_of(self.failure), start)

    def _estimated(self, start: float) -> dict[str, Any]:
        """The record where the method returned. Raises InvalidEstimate for what is none, or cannot be recorded."""
        if not np.array_equal(self.problem.x_observed, self._x_observed):
            raise InvalidEstimate("the method changed the observed events; let it work on a copy")
        require_recordable(self.estimate, self.problem, self.simulate.used)
        self.estimate = raw(self.estimate, self._posed)
        message = "; ".join(filter(None, (self.estimate.message, self.remark, self.estimate.doubt)))
        status = Status.DOUBTFUL if self.estimate.doubt else Status.OK
        try:
            return self._recorded(status, message, start, _scored(self.estimate, self._task, self.cell))
        except (TypeError, ValueError) as error:
            raise InvalidEstimate(f"what the method returned cannot be recorded: the record {error}") from error

    def _recorded(
        self, status: Status, message: str, start: float, scored: dict[str, Any] | None = None
    ) -> dict[str, Any]:
        """The record with these fields. Raises TypeError or ValueError where a file could not hold it."""
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
            **(scored or {}),
        }
        record["harness_seconds"] = time.perf_counter() - start
        return decode_record(encode(record))


def execute(cell: Cell, progress: Callable[[int], None] | None = None, debug: bool = False) -> dict[str, Any]:
    """Carry out a cell and return its record. Only KeyboardInterrupt leaves; `debug` prints tracebacks."""
    with put_back():
        return carried_out(cell, progress, debug)


def carried_out(cell: Cell, progress: Callable[[int], None] | None = None, debug: bool = False) -> dict[str, Any]:
    """The record of a cell as `execute` gives it, in a process that is left as the cell's code leaves it."""
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
    """Carry out cells of one task and method by `Method.infer_together`; their records in order.

    They are those of `execute`, to floating-point reordering of the estimate, but for `method_seconds`, an equal share,
    and a remark in `message`. A cell that cannot be observed fails alone; what the method raises leaves this function.
    """
    reset_peak_memory()
    trials = [Trial(cell, heartbeat, debug) for cell, heartbeat in zip(cells, progress, strict=True)]
    posed = [trial for trial in trials if trial.problem is not None]
    if posed:
        start = time.perf_counter()
        with put_back():
            estimates = posed[0].method.infer_together(
                [trial.problem for trial in posed], [trial.rng for trial in posed]
            )
        seconds = time.perf_counter() - start - sum(trial.simulate.seconds for trial in posed)
        if not isinstance(estimates, list) or len(estimates) != len(posed):
            raise InvalidEstimate(
                f"infer_together must return a list of {len(posed)} estimates, got {estimates!r:.100}"
            )
        for trial, estimate in zip(posed, estimates, strict=True):
            trial.estimate, trial.method_seconds = estimate, seconds / len(posed)
            trial.remark = f"one of {len(posed)} cells carried out together"
    return [trial.record() for trial in trials]


def message_of(error: BaseException) -> str:
    """The message of an error, for a record or a line to the user."""
    if isinstance(error, AvobenchError):
        return text_of(error)
    if type(error).__name__ == "OutOfMemoryError":  # PyTorch's, whose message goes on about its allocator
        message = ". ".join(text_of(error).split(". ")[:2])
        return f"{message}; fewer cells at a time (--group, --jobs) or --device cpu need less"
    return raised(error)


def blank_record(cell: Cell, status: Status, message: str) -> dict[str, Any]:
    """A record with every field of the schema, for a cell of which nothing more is known."""
    return {
        **{name: None for name, field in Record.model_fields.items() if field.is_required()},
        "schema_version": SCHEMA_VERSION,
        "id": cell.id,
        **cell.identity,
        "parameter_names": list(cell.parameter_names),
        "status": str(status),
        "message": message.encode(errors="backslashreplace").decode(),  # half a surrogate pair is no text
        "trace": [],
        **dict.fromkeys(SECONDS, 0.0),
        "versions": versions(cell.packages),
        **({"amortised": True} if cell.amortised else {}),
    }


def _floors(task: Task, cell: Cell) -> dict[str, float | None]:
    """The two floors of the squared error. Raises SimulatorError for what is none."""
    floors = {}
    for name, num_simulations in (("floor", cell.budget), ("floor_likelihood", None)):
        try:
            floor = task.floor(task.targets()[cell.target], cell.num_observations, num_simulations)
        except (Exception, SystemExit) as error:
            raise SimulatorError(f"the floor of {task.name} raised {raised(error)}") from error
        if not isinstance(floor, numbers.Real) or floor < 0:
            raise SimulatorError(f"the floor of {task.name} must be a number, not negative, got {floor!r:.100}")
        floors[name] = float(floor) if np.isfinite(floor) else None
    return floors


def _scored(estimate: Estimate, task: Task, cell: Cell) -> dict[str, Any]:
    """The fields of a record that tell its estimate, as the task quotes it: an integer is whole there."""
    theta_true = task.targets()[cell.target]
    theta, error = task.quoted(estimate.theta, np.zeros_like(theta_true) if estimate.error is None else estimate.error)
    return {
        "theta_hat": theta.tolist(),
        "squared_error": float(((theta - theta_true) ** 2).sum()),
        "how": estimate.how,
        "spread_of": estimate.spread_of,
        "mean": _numbers(estimate.mean),
        "std": _numbers(estimate.std),
        **({} if estimate.error is None else {"standard_error": _numbers(error)}),
        "trace": [
            {"simulations": int(point.simulations), "theta": _numbers(point.theta), "std": _numbers(point.std)}
            for point in estimate.trace
        ],
        "simulations_discarded": int(estimate.discarded),
    }


def _numbers(values: NDArray[np.float64] | None) -> list[float | None] | None:
    """A vector as a record holds it: what is not finite is null there."""
    return None if values is None else [float(value) if np.isfinite(value) else None for value in values]
