"""Events of a slow generator, made once and used for every theta: what differs between thetas acts after it."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.meter import Meter

Alter = Callable[[Any, slice], Any]
"""What happens to generated events before they are detected, and in which rows of theta they are."""


class Counted:
    """A task's simulator, whose events a meter counts. It raises BudgetExhausted at the meter's limit."""

    def __init__(self, task: Task, meter: Meter | None = None) -> None:
        self.task, self.meter = task, meter or Meter()

    def __call__(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """theta (n, p) -> (n, d). Raises SimulatorError for other events than the task declares."""
        self.meter.charge(len(theta))
        with self.meter.paying(self.task):
            return checked_events(self.task, theta, rng)


class Pool:
    """Generated events of a task that says what it `generates`, handed out from a random place on, again and again.

    A request gets no event twice if it asks for no more than the pool holds. A meter counts what is generated.
    """

    def __init__(self, task: Task, num_events: int, rng: np.random.Generator, meter: Meter | None = None) -> None:
        self.task, self.meter = task, meter or Meter()
        self.meter.charge(num_events)
        self._pieces = list(task.generate(num_events, rng))
        self._starts = np.cumsum([0, *(len(piece) for piece in self._pieces)])

    @property
    def size(self) -> int:
        return int(self._starts[-1])

    def fresh(self, theta: NDArray[np.float64], rng: np.random.Generator, alter: Alter | None = None) -> NDArray:
        """Events that are not in the pool: theta (n, p) -> (n, d)."""
        self.meter.charge(len(theta))
        return self.task.simulate(theta, rng) if alter is None else self.task.simulate(theta, rng, alter)

    def __call__(self, theta: NDArray[np.float64], rng: np.random.Generator, alter: Alter | None = None) -> NDArray:
        """One event per row, altered before it is detected: theta (n, p) -> (n, d)."""
        at = int(rng.integers(self.size))
        images, done = [], 0
        while done < len(theta):
            k = int(np.searchsorted(self._starts, at, side="right")) - 1
            start = at - self._starts[k]
            stop = min(start + len(theta) - done, len(self._pieces[k]))
            generated, rows = self._pieces[k].events(start, stop), slice(done, done + stop - start)
            images.append(self.task.detect(alter(generated, rows) if alter else generated, theta[rows]))
            done = rows.stop
            at = (at + stop - start) % self.size
        return np.concatenate(images)
