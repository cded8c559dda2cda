"""The sweep: cells to records, wherever they are carried out, each written as soon as it is finished."""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from avobench.bench.cells.cell import Cell
from avobench.bench.processes.contract import Backend
from avobench.bench.store.files import disk_errors
from avobench.bench.store.record import SECONDS, UNREAD
from avobench.bench.store.status import Status
from avobench.bench.store.store import Store
from avobench.bench.store.versions import versions
from avobench.tasks.errors import StoreError

TICK_SECONDS = 1.0
"""The display is drawn anew this often."""


@dataclass
class Sweep:
    """The state of a sweep, for whoever shows it."""

    cells: list[Cell]
    backend: Backend
    done: dict[str, dict[str, Any]]
    """Records of the finished cells by id, without the trace, which is most of a record: there may be many."""
    running: dict[str, float] = field(default_factory=dict)
    """Share of the budget used, by id."""
    fresh: list[dict[str, Any]] = field(default_factory=list)
    """Records that this run made."""

    @property
    def pending(self) -> list[Cell]:
        return [cell for cell in self.cells if cell.id not in self.done]

    def seconds_left(self) -> tuple[float, bool]:
        """The expected time to the end, and whether every pending method has a finished cell to judge from.

        A pending cell is expected to take as long as finished cells of its task and method did, else of its method.
        """
        total: dict[tuple[str, str], list[float]] = {}
        for record in list(self.done.values()):
            task, method = record["task"], record["method"]
            for key in ((task, method), ("", method)):
                total.setdefault(key, []).append(seconds(record))
        remaining, longest, all_timed = 0.0, 0.0, True
        for cell in self.pending:
            task, method = cell.identity["task"], cell.identity["method"]
            durations = total.get((task, method)) or total.get(("", method)) or [0.0]
            all_timed &= ("", method) in total
            expected = sum(durations) / len(durations) * (1 - self.running.get(cell.id, 0.0))
            remaining, longest = remaining + expected, max(longest, expected)
        return max(remaining / max(1, self.backend.workers), longest), all_timed


def seconds(record: dict[str, Any]) -> float:
    return sum(record[name] for name in SECONDS)


class View:
    """A display of a sweep. All its methods are called from one process, `tick` from a thread of its own."""

    def note(self, line: str) -> None:
        """Show the user a line."""

    def finished(self, sweep: Sweep, cell: Cell, record: dict[str, Any]) -> None:
        """Show that a cell was finished and its record written."""

    def tick(self, sweep: Sweep) -> None:
        """Show how far the sweep is; this is called every second."""


def run(
    cells: list[Cell], store: Store, backend: Backend, view: View, *, retry_failed: bool = False
) -> list[dict[str, Any]]:
    """Carry out the cells that the store lacks, in their order, and return the records of all, without their traces.

    A damaged record is set aside and made again; with `retry_failed`, so is a cell whose record is not `ok`. What was
    finished when it is interrupted stays. Raises UsageError for names that no file can have, StoreError when the table
    of packed records is damaged, or the disk fails.
    """
    with store.lock(), disk_errors(f"the results folder {store.path} cannot be used"):
        store.remove_leftovers()
        wanted = {cell.id: cell for cell in cells}
        for cell in cells:
            store.place({**cell.identity, "id": cell.id})  # a name that is none is told before anything is made
        sound, damaged = store.read(traces=False)
        if store.table in damaged:  # it is not known which records are lost, and they may have taken days
            fault = damaged[store.table]
            raise StoreError(f"{store.table} {fault}; {store.remedy(store.table, fault)}")
        for path, reason in damaged.items():
            if reason.startswith(UNREAD):
                raise StoreError(f"{path} {reason}; {store.remedy(path, reason)}")
            if path.stem.rpartition("_")[2] in wanted:
                view.note(f"{path.name} {reason}: set aside in {store.set_aside(path).parent}, made again")
            else:
                view.note(f"{path.name} {reason}: left as it is, not part of this run")
        done = {record["id"]: record for record in sound if record["id"] in wanted}
        del sound
        if retry_failed:
            done = {id: record for id, record in done.items() if record["status"] == Status.OK}
        sweep = Sweep(list(wanted.values()), backend, done)
        if sweep.pending:
            with (
                _logged(sweep, store),
                _ticking(sweep, view),
                closing(backend.records(sweep.pending, view.note)) as records,
            ):
                for record in records:
                    store.write(record)
                    record = {name: value for name, value in record.items() if name != "trace"}
                    sweep.done[record["id"]] = record
                    sweep.fresh.append(record)
                    view.finished(sweep, wanted[record["id"]], record)
    return [sweep.done[cell.id] for cell in cells]


@contextmanager
def _ticking(sweep: Sweep, view: View) -> Iterator[None]:
    """Ask how far the running cells are and call `view.tick` every second while the block runs."""
    stop = threading.Event()

    def watch() -> None:
        while not stop.wait(TICK_SECONDS):
            sweep.running = sweep.backend.shares()
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

    def log() -> None:
        if sweep.fresh:
            module = sys.orig_argv[1:2] == ["-m"]
            program, *rest = sys.orig_argv if module else sys.argv
            entry = {"started": started, "command": " ".join([Path(program).name, *rest])}
            entry |= {"backend": sweep.backend.name, "jobs": sweep.backend.workers, "cells": len(sweep.fresh)}
            entry |= {"cell_seconds": sum(map(seconds, sweep.fresh)), "wall_seconds": time.monotonic() - wall}
            entry |= {"cpu_seconds": time.process_time() - cpu, "versions": versions()}  # of the sweep, not its workers
            store.log_sweep(entry)

    try:
        yield
    except BaseException:
        with suppress(StoreError):  # what stopped the sweep is said, not that it could not be logged on the same disk
            log()
        raise
    log()
