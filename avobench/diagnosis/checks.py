"""What is asked of events and simulator before a diagnosis begins, and the bank that its simulated events come from."""

from pathlib import Path

from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.checks import FEW_REFERENCE, LEAST_REFERENCE, SHARE, Simulate, check_events, reference
from avobench.bench.store.bank import KeptBank
from avobench.effects import Effect
from avobench.effects.bank import Bank, Given
from avobench.effects.catalogue import catalogue
from avobench.effects.pool import Counted
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.meter import Meter
from avobench.tasks.sample import SampleTask


def bank_of(task: Task, meter: Meter, seed: int = 0, jobs: int = 1, folder: Path | None = None) -> Bank | Counted:
    """What a diagnosis has simulated events of a task from; they are kept in a `folder`, if there is one.

    Where the task generates something first that is used again, that is enough, and its events are only counted.
    """
    if isinstance(task, SampleTask):
        return Given(task, meter)
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
        """The entries of the catalogue for the task."""
        return catalogue(self.task, None, self._over_prior)

    def events(self, x: ArrayLike, *, drop_invalid: bool = False) -> tuple[NDArray, list[str]]:
        """The events (n, d) as `check_events` gives them, and warnings."""
        return check_events(self.task, x, drop_invalid=drop_invalid, made=self._made)

    def _over_prior(self) -> NDArray:
        made = self._made()
        return made[: len(made) // 2]

    def _made(self) -> NDArray:
        """Simulated events (n, d), the first half of them over the prior."""
        if isinstance(self.task, SampleTask):
            return self.task.events
        return reference(self.task, self.simulate, self._num_reference)
