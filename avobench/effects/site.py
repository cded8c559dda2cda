"""Where effects act: the events of one task, what kind they are and where they lie."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.ranges import Range, ranges
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

Domain = Literal["counts", "continuous", "images"]
"""What events are: one whole number, real numbers, or an image."""


def domain(task: Task) -> Domain:
    """What the events of a task are. Raises UsageError for several counts an event, for which there is no catalogue."""
    if task.event_shape:
        return "images"
    if np.dtype(task.dtype).kind not in "iu":
        return "continuous"
    if task.num_features > 1:
        raise UsageError(f"an event of {task.name} has {task.num_features} counts: effects are known of one count only")
    return "counts"


@dataclass(frozen=True, eq=False)
class Site:
    """A task as its effects see it. Families make their entries in its catalogue from this.

    Raises UsageError for a task whose events are of no known domain.
    """

    task: Task
    x: NDArray | None = None
    """Measured events (N, d), if the ranges of features are to be those that they show."""

    @cached_property
    def domain(self) -> Domain:
        return domain(self.task)

    @cached_property
    def ranges(self) -> tuple[Range, ...]:
        """Of each feature of continuous events, over the prior or as the measured events show it."""
        spans = ranges(self.task)
        return spans if self.x is None else tuple(span.shown(self.x[:, j]) for j, span in enumerate(spans))

    @property
    def features(self) -> list[int | Literal["all"]]:
        """What an effect on continuous events may act on: each feature, and all alike where there are several."""
        return [0] if self.task.num_features == 1 else [*range(self.task.num_features), "all"]
