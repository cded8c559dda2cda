"""Fits shared out to processes, with the simulated events counted."""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.starts import Start
from avobench.effects.pool import Counted, Pool
from avobench.tasks.errors import ProcessEnded


def in_processes(
    jobs: int, events: Counted | Pool | None, fitting: Callable[..., Fit], calls: list[tuple]
) -> list[Fit]:
    """The fits of all calls, by so many processes; `events` is what simulates, and counts what they simulated."""
    fits = []
    try:
        made = joblib.Parallel(n_jobs=jobs)(joblib.delayed(_apart)(fitting, *call) for call in calls)
    except TerminatedWorkerError as error:
        raise ProcessEnded("crashed", "a worker process of the fits was ended (killed, or out of memory)") from error
    for fit, used, process in made:
        if process != os.getpid() and events is not None:
            events.used += used
        fits.append(replace(fit, model=replace(fit.model, events=events)))
    return fits


def _apart(fitting: Callable[..., Fit], begun: Start | Fit, *more: Any) -> tuple[Fit, int, int]:
    """A fit without this process's copy of what simulates, how many events that made, and which process it is."""
    events = begun.model.events
    before = events.used if events else 0
    fit = fitting(begun, *more)
    return replace(fit, model=replace(fit.model, events=None)), events.used - before if events else 0, os.getpid()
