"""Fits shared out to processes, with the simulated events counted."""

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.starts import Start
from avobench.effects.pool import Counted, Pool
from avobench.tasks.errors import BudgetExhausted, ProcessEnded


def in_processes(
    jobs: int, events: Counted | Pool | None, fitting: Callable[..., Fit], calls: list[tuple]
) -> list[Fit | None]:
    """The fits of all calls, by so many processes; `events` is what simulates, and its meter counts it.

    Under a limit each other process has an equal share of what remains. A fit that needs more is made here, from the
    rest; None where that is too little.
    """
    left = events.meter.remaining if events is not None else None
    share = None if jobs == 1 or left is None else max(left, 0) // max(len(calls), 1)
    try:
        work = joblib.Parallel(n_jobs=jobs, return_as="generator")
        made: list[Fit | None] = []
        for fit, used, process in work(joblib.delayed(_apart)(share, fitting, *call) for call in calls):
            made.append(fit)
            if process != os.getpid() and events is not None:
                events.meter.add(used)
    except TerminatedWorkerError as error:
        raise ProcessEnded("crashed", "a worker process of the fits was ended (killed, or out of memory)") from error
    for k in (k for k, fit in enumerate(made) if fit is None and share is not None):
        with suppress(BudgetExhausted):
            made[k] = fitting(*calls[k])
    return [fit and replace(fit, model=replace(fit.model, events=events)) for fit in made]


def _apart(
    share: int | None, fitting: Callable[..., Fit], begun: Start | Fit, *more: Any
) -> tuple[Fit | None, int, int]:
    """A fit without this process's copy of what simulates, how many events that made, and which process it is.

    No more than a `share` of events is made, which a process of its own has; None where the fit needs more.
    """
    events = begun.model.events
    before = events.used if events else 0
    if share is not None:
        events.meter.share(share)
    try:
        fit = fitting(begun, *more)
    except BudgetExhausted:
        return None, events.used - before, os.getpid()
    return replace(fit, model=replace(fit.model, events=None)), events.used - before if events else 0, os.getpid()
