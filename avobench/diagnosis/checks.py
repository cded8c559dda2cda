"""What is asked of events and simulator before a diagnosis begins, and the bank that its simulated events come from."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.checks import FEW_REFERENCE, LEAST_REFERENCE, SHARE, check_events, reference
from avobench.bench.store.kept_bank import KeptBank
from avobench.diagnosis.summary.joint import JointPart
from avobench.diagnosis.summary.published import TablePart, tables_of
from avobench.effects import Effect
from avobench.effects.bank import Bank, Given
from avobench.effects.catalogue import catalogue
from avobench.effects.contract import Simulate
from avobench.effects.pool import Counted
from avobench.tables.table import Tables
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.joint import JointTask
from avobench.tasks.meter import Meter
from avobench.tasks.sample import SampleTask


def bank_of(task: Task, meter: Meter, seed: int = 0, jobs: int = 1, folder: Path | None = None) -> Bank | Counted:
    """What a diagnosis has simulated events of a task from; they are kept in a `folder`, if there is one.

    Where the task generates something first that is used again, that is enough, and its events are only counted: a
    folder for them is refused by UsageError.
    """
    if isinstance(task, SampleTask):
        return Given(task, meter)
    if task.generates and folder is not None:
        raise UsageError(f"{task.name} generates {task.generates} first, which no folder keeps: leave bank out")
    if task.generates:
        return Counted(task, meter)
    return Bank(task, meter, seed, jobs) if folder is None else KeptBank(task, meter, seed, jobs, folder)


class Checks:
    """The checks before a diagnosis of a task by so many measured events, and the `bank` that they simulate into.

    They take an event for each measured one, FEW_REFERENCE at least and one in SHARE of a `limit` at most. Raises
    UsageError for too low a limit, and for a `folder` that cannot be used.
    """

    def __init__(
        self,
        task: Task,
        num_events: int,
        limit: int | None = None,
        *,
        seed: int = 0,
        jobs: int = 1,
        folder: Path | None = None,
    ) -> None:
        if limit is not None and limit < SHARE * LEAST_REFERENCE:
            raise UsageError(f"{limit} simulated events are too few for a diagnosis")
        self.task, self.bank = task, bank_of(task, Meter(limit), seed, jobs, folder)
        wanted = max(num_events, FEW_REFERENCE)
        self._num_reference = wanted if limit is None else min(wanted, limit // SHARE)

    @property
    def simulate(self) -> Simulate:
        """A simulator whose events are kept."""
        return self.bank.session() if isinstance(self.bank, Bank) else self.bank

    def entries(self) -> list[Effect]:
        """The entries of the catalogue for the task.

        Those that tie features to each other are left out of a joint task, and where values may be missing.
        """
        entries = catalogue(self.task, None, self._over_prior)
        alone = isinstance(self.task, JointTask) or self.task.missing
        return [each for each in entries if not (each.between and alone)]

    def events(self, x: ArrayLike, *, drop_invalid: bool = False) -> tuple[NDArray, list[str]]:
        """The events (n, d) as `check_events` gives them, and warnings."""
        return check_events(self.task, x, drop_invalid=drop_invalid, made=self._made)

    def tables(self, tables: Tables) -> TablePart:
        """Published tables in place of events. Raises UsageError where they are not those of the task."""
        return TablePart.whole(tables_of(self.task, tables), self._made())

    def joint(self, sets: Sequence[Any], *, drop_invalid: bool = False) -> tuple[JointPart, list[str]]:
        """What was measured of each task of a `JointTask`, events or `Tables`, and warnings. Raises UsageError.

        A simulated event of one task alone counts as its share of one that has an event of each.
        """
        parts, warnings, beside = [], [], 0
        for name, task, x in zip(self.task.names, self.task.tasks, sets, strict=True):
            checks = Checks(task, self._num_reference, self.bank.meter.limit)
            try:
                part, more = (
                    (checks.tables(x), []) if isinstance(x, Tables) else checks.events(x, drop_invalid=drop_invalid)
                )
            except UsageError as error:
                raise UsageError(f"{name}: {error}") from error
            parts.append(part)
            warnings += [f"{name}: {each}" for each in more]
            beside += checks.bank.meter.used - checks.bank.meter.failed
        self.bank.meter.charge(-(-beside // len(sets)))
        return JointPart(self.task, tuple(parts)), warnings

    def _over_prior(self) -> NDArray:
        made = self._made()
        return made[: len(made) // 2]

    def _made(self) -> NDArray:
        """Simulated events (n, d), the first half of them over the prior."""
        if isinstance(self.task, SampleTask):
            return self.task.events
        return reference(self.task, self.simulate, self._num_reference)
