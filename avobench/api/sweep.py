"""Sweeps and their records, from Python as from the command line."""

from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from avobench.bench.cells.cell import Cell
from avobench.bench.plugins import registry
from avobench.bench.processes.calls import Call, Limits, apart, kept
from avobench.bench.processes.local import LIMITS
from avobench.bench.processes.workers import Workers
from avobench.bench.store.frame import to_frame
from avobench.bench.store.store import Store
from avobench.bench.sweep import runner
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import View
from avobench.tasks.arguments import checked
from avobench.tasks.errors import ProcessEnded, UsageError

RESULTS = Path("results/local")
"""Records are kept in this folder unless another one is given."""
LOOK_SECONDS = 60.0
"""Each task and method of the user's is looked at for so long before a sweep; 600 events are simulated."""


@checked
def run(
    tasks: str | Sequence[str] = (),
    methods: str | Sequence[str] = (),
    targets: str = "0-14",
    *,
    budget: int = 160_000,
    observations: int = 100_000,
    repetitions: int = 1,
    seed: int = 0,
    settings: Sequence[str] = (),
    device: str = "cpu",
    results: str | Path = RESULTS,
    workers: Workers | None = None,
    retry_failed: bool = False,
    view: View | None = None,
    debug: bool = False,
) -> pd.DataFrame:
    """Carry out the cells that the results folder lacks: task x method x target x repetition.

    What is finished is kept at once; after an interruption the same call goes on from there.

    Parameters
    ----------
    tasks, methods
        Names as `avobench list` shows them, `module:Class` or `path/to/file.py:Class`; where none is given, all
        registered ones that are carried out by default: of ours the paper's four tasks, and every method.
    targets
        Indices and ranges of target parameters, such as "0,3,7-9".
    budget
        Simulated events that a cell may use.
    observations
        Observed events of each target.
    repetitions
        Of each cell, with other random streams.
    seed
        Root of all random streams.
    settings
        Texts NAME.SETTING=VALUE, such as "abc-smc.population_size=50".
    device
        "cpu" or "cuda", for the methods that can use one.
    results
        Folder of the records; made where there is none.
    workers
        Processes of this machine, one a core, unless another kind is given; and how much time and memory a cell may
        take.
    retry_failed
        Make cells again whose status is not ok.
    view
        Is told what happens; nothing is shown without one.
    debug
        Print tracebacks of failed cells to standard error.

    Returns
    -------
    One row per cell, as `records` returns it, in the order of the cells.

    Raises
    ------
    UsageError
        If the request cannot be met; nothing is simulated then.
    StoreError
        If the folder cannot be used.
    """
    workers = workers or Workers()
    numbers = {"budget": budget, "observations": observations, "repetitions": repetitions, "seed": seed}
    how = {"targets": targets, **numbers, "settings": settings, "device": device}
    with kept():
        cells = asked(tasks, methods, in_process=workers.in_process, **how)
        return to_frame(carried_out(cells, results, workers, retry_failed=retry_failed, view=view, debug=debug))


def asked(
    tasks: str | Sequence[str], methods: str | Sequence[str], *, in_process: bool = False, **how: Any
) -> list[Cell]:
    """The cells that `run` carries out, in their order; `how` is what else `plan` takes.

    Tasks and methods of the user's are looked at in a process of its own, unless `in_process`. One that ends it, or
    takes a minute, where its simulator is tried is left to the sweep; elsewhere UsageError is raised.
    """
    chosen = {
        kind: [given] if isinstance(given, str) else list(given) or registry.names(kind)
        for kind, given in (("task", tasks), ("method", methods))
    }
    if not tasks:
        chosen["task"] = [name for name in chosen["task"] if registry.load("task", name).by_default]
    planned = partial(plan, chosen["task"], chosen["method"], **how)
    theirs = [spec for kind, specs in chosen.items() for spec in specs if registry.runs_theirs(kind, spec)]
    if in_process or not theirs:
        return planned()
    limits = Limits(LOOK_SECONDS * len(theirs), LIMITS.mib)
    with suppress(ProcessEnded):
        return apart(Call(planned, (), limits))
    try:
        return apart(Call(partial(planned, tried=False), (), limits))
    except ProcessEnded as error:
        raise UsageError(f"{', '.join(theirs)}: cannot be used: {error}") from error


def carried_out(
    cells: list[Cell],
    results: str | Path = RESULTS,
    workers: Workers | None = None,
    *,
    retry_failed: bool = False,
    view: View | None = None,
    debug: bool = False,
) -> list[dict[str, Any]]:
    """The records of cells, without their traces; those that the folder lacks are made."""
    store = Store(Path(results), create=True)
    backend = (workers or Workers()).begin(store.running, debug=debug)
    return runner.run(cells, store, backend, view or View(), retry_failed=retry_failed)


@checked
def records(results: str | Path = RESULTS) -> pd.DataFrame:
    """The records of a results folder, one row per cell; see docs/records.md for the columns.

    Raises StoreError where a record is damaged or there are none, UsageError where there is no such folder.
    """
    return to_frame(Store(Path(results)).read_all())
