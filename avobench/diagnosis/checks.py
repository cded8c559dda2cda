"""What a diagnosis simulates before it begins: the checks of the events and of the simulator, within the limit."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.checks import LEAST_REFERENCE, NUM_REFERENCE, SHARE, check_events, reference
from avobench.diagnosis.summary.joint import JointPart
from avobench.diagnosis.summary.published import TablePart, tables_of
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.pool import Counted
from avobench.effects.ranges import REFERENCE_EVENTS
from avobench.tables.table import Tables
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.joint import JointTask
from avobench.tasks.meter import Meter


@dataclass
class Checks:
    """The checks before a diagnosis of a task, with at most `limit` simulated events, and a counter of what they take.

    They take one in SHARE of the limit, half of it for the ranges of features. Raises UsageError for too low a limit.
    """

    task: Task
    limit: int | None = None
    simulate: Counted = field(init=False)
    beside: int = field(init=False, default=0)
    """Events of single data sets of a joint task that were simulated."""

    def __post_init__(self) -> None:
        self.simulate = Counted(self.task, Meter(self.limit))
        if self.limit is not None and self.limit < 2 * SHARE * LEAST_REFERENCE:
            raise UsageError(f"{self.limit} simulated events are too few for a diagnosis")

    @property
    def used(self) -> int:
        """Events that were simulated; of a joint task such as have an event of each data set."""
        each = len(self.task.tasks) if isinstance(self.task, JointTask) else 1
        return self.simulate.used + -(-self.beside // each)

    def entries(self) -> list[Effect]:
        """The entries of the catalogue for the task; of a joint one, but for those that tie features to each other."""
        num_events = REFERENCE_EVENTS if self.limit is None else min(REFERENCE_EVENTS, self.limit // (2 * SHARE))
        entries = catalogue(self.task, None, self.simulate, num_events)
        return [each for each in entries if not (each.between and isinstance(self.task, JointTask))]

    def events(self, x: ArrayLike, *, drop_invalid: bool = False) -> tuple[NDArray, list[str]]:
        """The events (n, d) as `check_events` gives them, and warnings."""
        limit = None if self.limit is None else self.limit // 2
        return check_events(self.task, x, drop_invalid=drop_invalid, simulate=self.simulate, limit=limit)

    def tables(self, tables: Tables) -> TablePart:
        """Published tables in place of events. Raises UsageError where they are not those of the task."""
        tables = tables_of(self.task, tables)
        num_events = NUM_REFERENCE if self.limit is None else min(NUM_REFERENCE, self.limit // (2 * SHARE))
        return TablePart.whole(tables, reference(self.task, self.simulate, num_events))

    def joint(self, sets: Sequence[Any], *, drop_invalid: bool = False) -> tuple[JointPart, list[str]]:
        """What was measured of each task of a `JointTask`, events or `Tables`, and warnings. Raises UsageError."""
        task, parts, warnings = self.task, [], []
        for name, own, x in zip(task.names, task.tasks, sets, strict=True):
            checks = Checks(own, self.limit)
            if isinstance(x, Tables):
                parts.append(checks.tables(x))
            else:
                events, more = checks.events(x, drop_invalid=drop_invalid)
                parts.append(events)
                warnings += [f"{name}: {each}" for each in more]
            self.beside += checks.used
        return JointPart(task, tuple(parts)), warnings
