"""Several data sets with one theta, for `infer` and `diagnose`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avobench.bench.plugins import registry
from avobench.tables.table import Table, Tables
from avobench.tasks import Task
from avobench.tasks.arguments import checked
from avobench.tasks.errors import UsageError
from avobench.tasks.joint import JointTask
from avobench.tasks.sample import SampleTask


@dataclass(frozen=True, repr=False)
class Joint:
    """Data sets that share parameters, as `joint` makes them."""

    task: JointTask
    sets: tuple[Any, ...]
    """What was measured of each: events, or `Tables`."""

    def __repr__(self) -> str:
        return f"{len(self.sets)} data sets ({', '.join(self.task.names)}) of {', '.join(self.task.parameter_names)}"


@checked
def joint(sets: Mapping[str, tuple[Task | str, Any]], shared: Sequence[str] | None = None) -> Joint:
    """Data sets with one theta, each with its own conditions, its own number of events, and events or tables.

    Parameters
    ----------
    sets
        By a name for each: its task, and its measured events (N, d) or published tables. The conditions of a set are
        settings of its task, or fixed in its function.
    shared
        Names of the parameters that the tasks have in common; all of one name where None. Others are named
        `set: parameter`.

    Raises
    ------
    UsageError
        For a single set, for a set without events, for names that no two tasks have, for shared parameters whose units,
        kinds or ranges do not fit together, for images, and for events that were simulated before in place of a task.

    Examples
    --------
    >>> import avobench
    >>> def rates(seconds):
    ...     return lambda theta, rng: rng.poisson(seconds * theta[:, 0])
    >>> near, far = (avobench.task(rates(t), prior={"rate": (1, 9)}, features=["count"]) for t in (1, 10))
    >>> avobench.joint({"near": (near, [3, 4, 2]), "far": (far, [32, 35])})
    2 data sets (near, far) of rate
    """
    if not isinstance(sets, Mapping) or not all(isinstance(each, tuple) and len(each) == 2 for each in sets.values()):
        raise UsageError("joint takes a task and what was measured by the name of each set: {'near': (task, x), ...}")
    tasks = {str(name): registry.task_of(task) for name, (task, _) in sets.items()}
    if made := [name for name, task in tasks.items() if isinstance(task, SampleTask)]:
        raise UsageError(f"{', '.join(made)}: joint takes simulators, not events that were simulated before")
    if empty := [name for name, (_, x) in sets.items() if hasattr(x, "__len__") and not len(x)]:
        raise UsageError(f"{', '.join(map(str, empty))}: there are no events: leave the set out")
    measured = (x if (tables := tables_in(x)) is None else tables for _, x in sets.values())
    return Joint(JointTask(tasks, shared), tuple(measured))


def require_measured(task: Any, x: Any) -> None:
    """Raise UsageError unless what was measured is given once: as `x`, or in a Joint."""
    if isinstance(task, Joint) == (x is not None):
        raise UsageError("give what was measured as x; leave x out for data sets of `avobench.joint`, which has it")


def tables_in(x: Any) -> Tables | None:
    """What was measured, if it is published tables."""
    if isinstance(x, Table | Tables):
        return Tables.of(x)
    return Tables.of(x) if isinstance(x, list | tuple) and x and all(isinstance(t, Table) for t in x) else None
