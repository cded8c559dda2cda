"""The one meter of simulated events: whatever simulates is charged here first, and never beyond its limit."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import copy
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Task
from avobench.tasks.errors import BudgetExhausted


class Meter:
    """Counts events, and refuses whole a request beyond `limit`, which is added to `refused`; no limit for None."""

    def __init__(self, limit: int | None = None, progress: Callable[[int], None] | None = None) -> None:
        self.limit, self.used, self.refused, self.progress = limit, 0, 0, progress
        self.kept = 0
        """Events among those that remain which are kept for what follows."""

    @property
    def remaining(self) -> int | None:
        """Events that may still be simulated; None for any number."""
        return None if self.limit is None else self.limit - self.used - self.kept

    def charge(self, num_events: int) -> None:
        """Count events that are about to be simulated. Raises BudgetExhausted where too few remain."""
        if self.limit is not None and num_events > self.remaining:
            self.refused += num_events
            raise BudgetExhausted(f"{num_events} events asked for, {self.remaining} of {self.limit} left")
        self.used += num_events
        self.tell()

    def share(self, num_events: int) -> None:
        """Allow so many more events and no others: this is the copy of another process."""
        self.limit, self.kept = self.used + num_events, 0

    def add(self, num_events: int) -> None:
        """Count events that were simulated in another process, under a limit that this one gave it."""
        self.used += num_events
        self.tell()

    def tell(self) -> None:
        if self.progress is not None:
            self.progress(self.used)

    @contextmanager
    def keeping(self, num_events: int) -> Iterator[None]:
        """Meanwhile so many of the events that remain are for what follows."""
        self.kept += num_events
        try:
            yield
        finally:
            self.kept -= num_events

    @contextmanager
    def closed(self) -> Iterator[None]:
        """Meanwhile nothing may be simulated, and a request is refused without a note of it."""
        limit, refused = self.limit, self.refused
        self.limit = self.used + self.kept
        try:
            yield
        finally:
            self.limit, self.refused = limit, refused

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "progress": None}  # a copy in another process tells nobody


def metered(task: Task, meter: Meter) -> Task:
    """A twin of a task each event of which is charged to a meter, whoever asks for it."""
    twin = copy(task)
    object.__setattr__(twin, "simulate", partial(_simulated, task, meter))  # the task may be a frozen dataclass
    return twin


def _simulated(task: Task, meter: Meter, theta: NDArray[np.float64], rng: np.random.Generator, *alter: Any) -> NDArray:
    meter.charge(len(theta))
    return task.simulate(theta, rng, *alter)
