"""The metered simulator: the only way a method can simulate, and the place where events are counted."""

import os
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.methods import Problem
from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.errors import BudgetExhausted, SimulatorError, SupportError, UsageError, raised, text_of
from avobench.tasks.meter import Meter
from avobench.tasks.region import regions

AGAIN = 1.5
"""Events that are kept to be made in place of failed ones, for each that is expected: where an answer lies more may
fail than elsewhere."""
SURE = 3.0
"""Standard errors of their number, as far as it is known, that are kept on top."""
SPARE = 0.1
"""Share of the events of a cell that is kept on top, as `infer` has its test of the answer."""


class MeteredSimulator:
    """Simulates events of a task from its own random stream, and never more than `budget` of them.

    A `reserve` of more events may be made in place of failed ones; beyond it these count within the budget.

    A request that would exceed the budget is refused whole: it raises BudgetExhausted, its events are added to
    `refused`, and nothing is simulated. `requested == used + refused` always holds. An event is charged before it
    is simulated, so a simulator that fails is charged too. A copy in another process raises UsageError.
    """

    def __init__(
        self,
        task: Task,
        budget: int,
        rng: np.random.Generator,
        progress: Callable[[int], None] | None = None,
        reserve: int = 0,
    ) -> None:
        self._task, self._rng, self._progress = task, rng, progress
        self._meter, self._budget, self._seconds = Meter(budget + reserve), budget, 0.0
        self._process = os.getpid()

    @property
    def budget(self) -> int:
        return self._budget

    @property
    def used(self) -> int:
        return self._meter.used

    @property
    def failed(self) -> int:
        """Those of them that were made in place of failed ones."""
        return self._meter.failed

    @property
    def refused(self) -> int:
        return self._meter.refused

    @property
    def requested(self) -> int:
        return self.used + self.refused

    @property
    def remaining(self) -> int:
        return min(self._budget + self.failed - self.used, self._meter.remaining)

    @property
    def seconds(self) -> float:
        return self._seconds

    def __call__(self, theta: ArrayLike) -> NDArray:
        """One event per row: theta (n, p) in raw units -> x (n, d).

        Raises SupportError for a theta that is not finite, of the wrong shape or outside the support, BudgetExhausted
        when fewer than n events remain, SimulatorError when the simulator fails.
        """
        return self._simulate(_checked(np.asarray(theta, float), self._task))

    def repeat(self, theta: ArrayLike, n: int) -> NDArray:
        """n events per row: theta (m, p) -> x (m, n, d). Raises as `__call__` does."""
        theta = _checked(np.atleast_2d(np.asarray(theta, float)), self._task)
        if n < 1:
            raise SupportError(f"at least 1 event per row must be asked for, got {n}")
        return self._simulate(np.repeat(theta, n, axis=0)).reshape(len(theta), n, -1)

    def _simulate(self, theta: NDArray[np.float64]) -> NDArray:
        if os.getpid() != self._process:  # a copy would count for itself, and draw the same random numbers
            raise UsageError("a method called problem.simulate in a process that it started; call it where infer runs")
        start = time.perf_counter()
        try:
            with self._meter.keeping(self._meter.remaining - self.remaining):
                self._meter.charge(len(theta))
            with self._meter.paying(self._task):
                x = checked_events(self._task, theta, self._rng)
        except BudgetExhausted as error:
            if not self.failed:
                raise
            raise BudgetExhausted(
                f"{self.failed} of {self.used} events of {self._task.name} failed and were made again, more than the "
                "budget has room for: leave out of the prior where it fails, or allow more simulated events"
            ) from error
        finally:
            self._seconds += time.perf_counter() - start
        if self._progress is not None:
            self._progress(self.used)
        return x


def asked_of(task: Task, limit: int, checks: Meter | None = None) -> int:
    """How many of `limit` events may be asked for, so that the others suffice for those made in place of failed ones.

    All may be asked for where the simulator cannot fail. The rate of failures comes from the `checks` that were made,
    and from the events that taught in which region the simulator works.
    """
    counts = [region.within_it for region in regions(task)]
    if not counts:
        return limit
    failed, tried = (sum(numbers) for numbers in zip(*counts, strict=True))
    made = tried - failed + (checks.used - checks.failed if checks else 0)
    failed += checks.failed if checks else 0
    share = failed / made
    return int(limit / (1 + AGAIN * share + SURE * np.sqrt((share + 1 / made) / made)))


def pose(task: Task, x_observed: NDArray, simulate: MeteredSimulator, reference: NDArray | None = None) -> Problem:
    """The problem of finding the parameters behind events x_observed (N, d), which are made read-only.

    The summary suits the events `reference` (n, d), those that were observed by default.
    """
    x_observed.setflags(write=False)
    summarised = task.with_reference(x_observed if reference is None else reference)
    return Problem(
        parameter_names=task.parameter_names,
        prior=task.prior,
        support=task.support,
        x_observed=x_observed,
        simulate=simulate,
        summary=lambda x: checked_summary(summarised, x),
        discriminator=task.discriminator,
        feature_names=task.feature_names,
        event_shape=task.event_shape,
        cyclic_axes=task.cyclic_axes,
    )


def checked_summary(task: Task, x: NDArray) -> NDArray[np.float64]:
    """The summary statistic of events (n, d) -> (k,), or SimulatorError saying what is wrong with it."""
    try:
        summary = task.summary(x)
    except (Exception, SystemExit) as error:
        raise SimulatorError(f"the summary of {task.name} raised {raised(error)}") from error
    if not (isinstance(summary, np.ndarray) and summary.ndim == 1 and np.isfinite(summary).all()):
        raise SimulatorError(f"the summary of {task.name} must be a finite array (k,), got {summary!r:.100}")
    return summary


def _checked(theta: NDArray[np.float64], task: Task) -> NDArray[np.float64]:
    p = len(task.parameter_names)
    if theta.ndim != 2 or theta.shape[1] != p or len(theta) == 0:
        raise SupportError(f"theta must have shape (n, {p}) with n > 0, got {theta.shape}")
    try:
        task.require_support(theta)
    except ValueError as error:
        raise SupportError(text_of(error)) from error
    return theta
