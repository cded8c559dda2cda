"""The sweep: cells to records, in parallel with joblib, each written as soon as it is finished."""

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from avobench.bench.cells import Cell, Status, blank_record, execute, versions
from avobench.bench.errors import AvobenchError
from avobench.bench.store import Store, write_atomically

HEARTBEAT_SECONDS = 1.0
ATTEMPTS = 2
"""How often a cell may lose its worker process before it is recorded as crashed."""


@dataclass
class Sweep:
    """The state of a sweep, for whoever shows it."""

    cells: list[Cell]
    jobs: int
    done: dict[str, dict[str, Any]]
    """Records of the finished cells by id."""
    running: dict[str, float] = field(default_factory=dict)
    """Share of the budget used, by id."""
    fresh: list[dict[str, Any]] = field(default_factory=list)
    """Records that this run made."""

    @property
    def pending(self) -> list[Cell]:
        return [cell for cell in self.cells if cell.id not in self.done]

    def seconds_left(self) -> tuple[float, bool]:
        """Expected time to the end, and whether every pending method has a finished cell to judge from.

        A pending cell is expected to take as long as finished cells of its task and method did, else of its method;
        one of a method that has none yet counts as nothing.
        """
        total: dict[tuple[str, str], list[float]] = {}
        for record in list(self.done.values()):
            task, method = record["task"], record["method"]
            for key in ((task, method), ("", method)):
                total.setdefault(key, []).append(seconds(record))
        left, longest, known = 0.0, 0.0, True
        for cell in self.pending:
            task, method = cell.identity["task"], cell.identity["method"]
            durations = total.get((task, method)) or total.get(("", method)) or [0.0]
            known &= ("", method) in total
            expected = sum(durations) / len(durations) * (1 - self.running.get(cell.id, 0.0))
            left, longest = left + expected, max(longest, expected)
        return max(left / self.jobs, longest), known


def seconds(record: dict[str, Any]) -> float:
    """What a cell took, all in all."""
    return sum(record[f"{part}_seconds"] for part in ("observation", "simulator", "method", "harness"))


class View:
    """What shows a sweep; all methods are called from one process, `tick` from a thread of its own."""

    def note(self, line: str) -> None:
        """Something that the user should know, in a line."""

    def finished(self, sweep: Sweep, cell: Cell, record: dict[str, Any]) -> None:
        """A cell was finished and its record written."""

    def tick(self, sweep: Sweep) -> None:
        """Called every second."""


def run(
    cells: list[Cell], store: Store, jobs: int, view: View, *, retry_failed: bool = False, debug: bool = False
) -> list[dict[str, Any]]:
    """Carry out the cells that the store lacks, in their order, and return the records of all, in their order.

    A damaged record is set aside and made again. A cell whose worker dies is tried once more, by itself. With
    `retry_failed`, cells with a record that is not `ok` are made again too. KeyboardInterrupt leaves the store as it
    is: what was finished stays, and the next run goes on from there.
    """
    with store.lock():
        store.remove_leftovers()
        store.running.mkdir(exist_ok=True)
        sound, damaged = store.read()
        wanted = {cell.id: cell for cell in cells}
        for path, reason in damaged.items():
            if path.stem.rpartition("_")[2] in wanted:
                view.note(f"{path.name} {reason}: set aside in {store.set_aside(path).parent}, made again")
            else:
                view.note(f"{path.name} {reason}: left as it is, not part of this run")
        done = {record["id"]: record for record in sound if record["id"] in wanted}
        if retry_failed:
            done = {id: record for id, record in done.items() if record["status"] == Status.OK}
        sweep = Sweep(list(wanted.values()), jobs, done)
        crashes: dict[str, int] = {}
        with _logged(sweep, store), _ticking(sweep, store, view):
            while pending := sweep.pending:
                suspects = [cell for cell in pending if cell.id in crashes]
                batch = suspects[:1] or pending  # a suspect runs alone, so that it alone is blamed
                try:
                    for record in _parallel(batch, store, jobs, debug):
                        _keep(record, wanted[record["id"]], store, sweep, view)
                except TerminatedWorkerError as error:
                    if not any((store.running / cell.id).exists() for cell in batch):
                        raise AvobenchError(
                            "worker processes die before they begin; is there enough memory?"
                        ) from error
                    for cell in batch:
                        if (store.running / cell.id).exists() and cell.id not in sweep.done:
                            crashes[cell.id] = crashes.get(cell.id, 0) + 1
                            (store.running / cell.id).unlink()
                            view.note(f"{cell.label}: the worker process died ({crashes[cell.id]} of {ATTEMPTS})")
                            if crashes[cell.id] == ATTEMPTS:
                                message = f"the worker process died {ATTEMPTS} times (killed, or out of memory)"
                                _keep(blank_record(cell, Status.CRASHED, message), cell, store, sweep, view)
    return [sweep.done[cell.id] for cell in cells]


def _parallel(cells: list[Cell], store: Store, jobs: int, debug: bool) -> Iterator[dict[str, Any]]:
    """Records as they are finished. One cell a task and one thread a worker; in this process where jobs is 1."""
    with parallel_config(backend="loky", inner_max_num_threads=1) if jobs > 1 else parallel_config():
        parallel = Parallel(n_jobs=jobs, batch_size=1, return_as="generator_unordered")
        parent = os.getpid()
        yield from parallel(delayed(_work)(cell, store.running / cell.id, parent, debug) for cell in cells)


def _work(cell: Cell, mark: Path, parent: int, debug: bool) -> dict[str, Any]:
    """One cell in a worker: marks itself as running, tells how far it is, and ends itself if the sweep is gone."""
    if os.getpid() != parent:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the sweep ends its workers
    last = 0.0

    def heartbeat(used: int) -> None:
        nonlocal last
        if os.getpid() != parent and os.getppid() != parent:
            os._exit(1)  # the sweep was killed: nobody is left to take the record
        if time.monotonic() - last >= HEARTBEAT_SECONDS:
            last = time.monotonic()
            tell(used / cell.budget)

    def tell(share: float) -> None:
        with suppress(OSError):  # a full disk costs the display, not the cell
            write_atomically(mark, json.dumps(share).encode())

    tell(0)
    return execute(cell, heartbeat, debug)


def _keep(record: dict[str, Any], cell: Cell, store: Store, sweep: Sweep, view: View) -> None:
    store.write(record)
    (store.running / cell.id).unlink(missing_ok=True)
    sweep.done[cell.id] = record
    sweep.fresh.append(record)
    view.finished(sweep, cell, record)


@contextmanager
def _ticking(sweep: Sweep, store: Store, view: View) -> Iterator[None]:
    """Read the workers' marks and call `view.tick` every second while the block runs."""
    stop = threading.Event()

    def watch() -> None:
        while not stop.wait(HEARTBEAT_SECONDS):
            sweep.running = _marks(store.running)
            view.tick(sweep)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@contextmanager
def _logged(sweep: Sweep, store: Store) -> Iterator[None]:
    """Log what this run did, however it ends short of a kill, if it finished any cell."""
    started, wall, cpu = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic(), time.process_time()
    try:
        yield
    finally:
        if sweep.fresh:
            store.log_sweep(
                {
                    "started": started,
                    "command": " ".join(["avobench", *sys.argv[1:]]),
                    "jobs": sweep.jobs,
                    "cells": len(sweep.fresh),
                    "cell_seconds": sum(seconds(record) for record in sweep.fresh),
                    "wall_seconds": time.monotonic() - wall,
                    "cpu_seconds": time.process_time() - cpu,  # of the sweep itself, not of its workers
                    "versions": versions(),
                }
            )


def _marks(folder: Path) -> dict[str, float]:
    marks = {}
    for path in folder.glob("[!.]*"):
        try:
            marks[path.name] = json.loads(path.read_text())
        except FileNotFoundError:  # finished in between
            continue
    return marks
