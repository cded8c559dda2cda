"""Where effects act: the events of one task, what kind they are and where they lie."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from numpy.typing import NDArray

from avobench.effects.ranges import Range, ranges
from avobench.tasks import Task

Domain = Literal["counts", "continuous", "images"]
"""What an effect acts on: counts, real numbers, or the cells of an image."""


def domain(task: Task) -> Domain:
    """What the events of a task are: counts only where all features are."""
    if task.event_shape:
        return "images"
    return "counts" if set(task.kinds_of_features) == {"count"} else "continuous"


@dataclass(frozen=True, eq=False)
class Site:
    """A task as its effects see it. Families make their entries in its catalogue from this."""

    task: Task
    x: NDArray | None = None
    """Measured events (N, d), if the ranges of features are to be those that they show."""
    made: Callable[[], NDArray] | None = None
    """What gives simulated events over the prior (n, d), from which the ranges are read."""

    @property
    def domains(self) -> set[Domain]:
        """The domains of the effects that apply: both where an event has counts beside real numbers."""
        if self.task.event_shape:
            return {"images"}
        return {"counts" if kind == "count" else "continuous" for kind in self.task.kinds_of_features}

    @cached_property
    def ranges(self) -> tuple[Range, ...]:
        spans = ranges(self.task, self.made and self.made())
        return spans if self.x is None else tuple(span.shown(self.x[:, j]) for j, span in enumerate(spans))

    @property
    def features(self) -> list[int | Literal["all"]]:
        """What an effect on real numbers may act on: each of them, and all alike where an event has several."""
        return self._acted_on([j for j, kind in enumerate(self.task.kinds_of_features) if kind != "count"])

    @property
    def counts(self) -> list[int | Literal["all"] | None]:
        """What an effect on counts may act on: as `features`, and None where an event is one count alone."""
        if self.task.num_features == 1 and self.domains == {"counts"}:
            return [None]
        return self._acted_on([j for j, kind in enumerate(self.task.kinds_of_features) if kind == "count"])

    def columns(self, feature: int | Literal["all"] | None) -> tuple[int, ...]:
        return (feature,) if isinstance(feature, int) else tuple(range(self.task.num_features))

    def _acted_on(self, columns: list[int]) -> list[int | Literal["all"]]:
        return [*columns, "all"] if len(columns) == self.task.num_features > 1 else columns
