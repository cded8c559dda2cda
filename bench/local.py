"""Cells carried out in worker processes of this machine, by joblib; or in this process, with one worker."""

import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from avobench.bench.backend import Backend
from avobench.bench.cells import Cell, Status, blank_record, execute
from avobench.bench.errors import AvobenchError
from avobench.bench.store import write_atomically

HEARTBEAT_SECONDS = 1.0
ATTEMPTS = 2
"""How often a cell may lose its worker process before it is recorded as crashed."""


class LocalBackend(Backend):
    """Processes of this machine. Each running cell keeps a file in `marks`, with the share of its budget used.

    A worker that dies takes all others with it, and the files left say whose cell may be to blame. Each of these is
    then tried once more by itself, so that the one that kills its worker is recorded as crashed and no other is.
    """

    name = "local"

    def __init__(self, jobs: int, marks: Path, *, debug: bool = False) -> None:
        self._jobs, self._marks, self._debug = jobs, marks, debug

    @property
    def workers(self) -> int:
        return self._jobs

    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        self._marks.mkdir(exist_ok=True)
        left = {cell.id: cell for cell in cells}
        crashes: dict[str, int] = {}
        while left:
            suspects = [left[id] for id in crashes if id in left]
            batch = suspects[:1] or list(left.values())
            try:
                for record in self._parallel(batch):
                    yield record
                    (self._marks / record["id"]).unlink(missing_ok=True)
                    del left[record["id"]]
            except TerminatedWorkerError as error:
                began = [cell for cell in batch if cell.id in left and (self._marks / cell.id).exists()]
                if not began:
                    raise AvobenchError("worker processes die before they begin; is there enough memory?") from error
                for cell in began:
                    crashes[cell.id] = crashes.get(cell.id, 0) + 1
                    (self._marks / cell.id).unlink()
                    note(f"{cell.label}: the worker process died ({crashes[cell.id]} of {ATTEMPTS})")
                    if crashes[cell.id] == ATTEMPTS:
                        message = f"the worker process died {ATTEMPTS} times (killed, or out of memory)"
                        yield blank_record(left.pop(cell.id), Status.CRASHED, message)

    def shares(self) -> dict[str, float]:
        shares = {}
        for path in self._marks.glob("[!.]*"):
            with suppress(FileNotFoundError):  # finished in between
                shares[path.name] = json.loads(path.read_text())
        return shares

    def _parallel(self, cells: list[Cell]) -> Iterator[dict[str, Any]]:
        """Records as they are finished. One cell a task, one thread a worker; in this process where jobs is 1."""
        with parallel_config(backend="loky", inner_max_num_threads=1) if self._jobs > 1 else parallel_config():
            parallel = Parallel(n_jobs=self._jobs, batch_size=1, return_as="generator_unordered")
            parent = os.getpid()
            yield from parallel(delayed(_work)(cell, self._marks / cell.id, parent, self._debug) for cell in cells)


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
