"""The one meter of simulated events: whatever simulates is charged here first, and never beyond its limit."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Task, twin
from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.region import regions


class Meter:
    """Counts events, and refuses whole a request beyond `limit`, which is added to `refused`; no limit for None."""

    def __init__(self, limit: int | None = None, progress: Callable[[int], None] | None = None) -> None:
        self.limit, self.used, self.refused, self.progress = limit, 0, 0, progress
        self.failed = 0
        """Events among those used that were made in place of failed ones."""
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

    @contextmanager
    def paying(self, task: Task) -> Iterator[None]:
        """Meanwhile events that simulators are asked for in place of failed ones are charged here, and where they were.

        An event of several data sets has one of each: a part of it counts as its share. To learn where a simulator
        works is not charged: that happens once, and the same seed is to give the same answer whenever it is asked.
        """
        task_regions, calls = regions(task), max(len(task.tasks), 1)
        before = [region.charge for region in task_regions]

        def pay(also: Callable[[int], None] | None, num_events: int) -> None:
            if also is not None:
                also(num_events)
            self.charge(-(-num_events // calls))
            self.failed += -(-num_events // calls)

        for region, also in zip(task_regions, before, strict=True):
            region.charge, _ = partial(pay, also), region.uncharged()
        try:
            yield
        finally:
            for region, also in zip(task_regions, before, strict=True):
                region.charge = also
        if other := sum(region.uncharged() for region in task_regions):  # of other processes
            self.add(-(-other // calls))
            self.failed += -(-other // calls)

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
    return twin(task, simulate=partial(_simulated, task, meter))


def _simulated(task: Task, meter: Meter, theta: NDArray[np.float64], rng: np.random.Generator, *alter: Any) -> NDArray:
    meter.charge(len(theta))
    with meter.paying(task):
        return task.simulate(theta, rng, *alter)
