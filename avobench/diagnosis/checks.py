"""What a diagnosis simulates before it begins: the checks of the events and of the simulator, within the limit."""

from dataclasses import dataclass, field

from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.checks import LEAST_REFERENCE, NUM_REFERENCE, SHARE, check_events, reference
from avobench.diagnosis.summary.published import TablePart, tables_of
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.pool import Counted
from avobench.effects.ranges import REFERENCE_EVENTS
from avobench.tables.table import Tables
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.meter import Meter


@dataclass
class Checks:
    """The checks before a diagnosis of a task, with at most `limit` simulated events, and a counter of what they take.

    They take one in SHARE of the limit, half of it for the ranges of features. Raises UsageError for too low a limit.
    """

    task: Task
    limit: int | None = None
    simulate: Counted = field(init=False)

    def __post_init__(self) -> None:
        self.simulate = Counted(self.task, Meter(self.limit))
        if self.limit is not None and self.limit < 2 * SHARE * LEAST_REFERENCE:
            raise UsageError(f"{self.limit} simulated events are too few for a diagnosis")

    @property
    def used(self) -> int:
        """Events that were simulated."""
        return self.simulate.used

    def entries(self) -> list[Effect]:
        """The entries of the catalogue for the task."""
        num_events = REFERENCE_EVENTS if self.limit is None else min(REFERENCE_EVENTS, self.limit // (2 * SHARE))
        return catalogue(self.task, None, self.simulate, num_events)

    def events(self, x: ArrayLike, *, drop_invalid: bool = False) -> tuple[NDArray, list[str]]:
        """The events (n, d) as `check_events` gives them, and warnings."""
        limit = None if self.limit is None else self.limit // 2
        return check_events(self.task, x, drop_invalid=drop_invalid, simulate=self.simulate, limit=limit)

    def tables(self, tables: Tables) -> TablePart:
        """Published tables in place of events. Raises UsageError where they are not those of the task."""
        tables = tables_of(self.task, tables)
        num_events = NUM_REFERENCE if self.limit is None else min(NUM_REFERENCE, self.limit // (2 * SHARE))
        part = TablePart.whole(tables, reference(self.task, self.simulate, num_events))
        if (rank := part.target(part.reference).rank) <= (p := len(self.task.parameter_names)):
            raise UsageError(f"tables with {rank} degrees of freedom tell no more than the {p} parameters")
        return part
