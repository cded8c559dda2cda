"""Cells carried out in worker processes of this machine, by joblib; or in this process, with one worker."""

import json
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from avobench.bench.atomic import write_atomically
from avobench.bench.backends.contract import Backend
from avobench.bench.cell import Cell
from avobench.bench.status import Status
from avobench.bench.trial import blank_record, execute, execute_together, told
from avobench.tasks.errors import AvobenchError

HEARTBEAT_SECONDS = 1.0
"""How often a cell tells how far it is: as often as the display is drawn."""
ATTEMPTS = 2
"""How often a cell may lose its worker process before it is recorded as crashed."""
Piece = tuple[Cell, ...]
"""Cells that a worker carries out as one."""


class LocalBackend(Backend):
    """Processes of this machine. Each running cell keeps a file in `marks`, with the share of its budget used.

    A worker that dies takes all others with it, and the files left say whose cell may be to blame. Each of these is
    then tried once more by itself, so that the one that kills its worker is recorded as crashed and no other is.

    A worker is given a piece of work at a time, here always of one cell. A subclass may make larger pieces; one that
    fails as a whole is begun again in halves, one after the other, so that only the cell to blame fails.
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
        halves: list[Piece] = []
        while left:
            if suspects := [(left[id],) for id in crashes if id in left]:
                work = suspects[:1]
            elif halves:
                work = [halves.pop(0)]
            else:
                work = self.pieces(list(left.values()))
            try:
                for place, outcome in self._parallel(work):
                    piece = work[place]
                    if isinstance(outcome, str):
                        middle = (len(piece) + 1) // 2
                        halves += [piece[:middle], piece[middle:]]
                        note(f"{label(piece)}: {outcome}; begun again in halves, as with --group {middle}")
                    else:
                        for record in outcome:
                            yield record
                            del left[record["id"]]
                    self._unmark(piece)
            except TerminatedWorkerError as error:
                marked = {id for id in left if (self._marks / id).exists()}
                began = [piece for piece in work if any(cell.id in marked for cell in piece)]
                if not began:
                    raise AvobenchError("worker processes die before they begin; is there enough memory?") from error
                for piece in began:
                    self._unmark(piece)
                    crashes |= {cell.id: crashes.get(cell.id, 0) + 1 for cell in piece}
                    deaths = crashes[piece[0].id]
                    note(f"{label(piece)}: the worker process died ({deaths} of {ATTEMPTS})")
                    if deaths == ATTEMPTS:  # the second time it was by itself
                        message = f"the worker process died {ATTEMPTS} times (killed, or out of memory)"
                        yield blank_record(left.pop(piece[0].id), Status.CRASHED, message)

    def pieces(self, cells: list[Cell]) -> list[Piece]:
        """The cells in the pieces that workers are given, in the order in which they are begun."""
        return [(cell,) for cell in cells]

    def shares(self) -> dict[str, float]:
        shares = {}
        for path in self._marks.glob("[!.]*"):
            with suppress(FileNotFoundError):  # finished in between
                shares[path.name] = json.loads(path.read_text())
        return shares

    def _unmark(self, piece: Piece) -> None:
        for cell in piece:
            (self._marks / cell.id).unlink(missing_ok=True)

    def _parallel(self, work: list[Piece]) -> Iterator[tuple[int, list[dict[str, Any]] | str]]:
        """Places in `work`, as they are finished, each with what `_work` returns.

        One thread a worker; in this process where jobs is 1.
        """
        with parallel_config(backend="loky", inner_max_num_threads=1) if self._jobs > 1 else parallel_config():
            parallel = Parallel(n_jobs=self._jobs, batch_size=1, return_as="generator_unordered")
            parent = os.getpid()
            yield from parallel(
                delayed(_work)(place, piece, self._marks, parent, self._debug) for place, piece in enumerate(work)
            )


def label(piece: Piece) -> str:
    """What a piece of work is, for a line to the user."""
    first, n = piece[0], len(piece)
    return first.label if n == 1 else f"{first.identity['task']} {first.identity['method']}, {n} cells together"


def _work(place: int, piece: Piece, marks: Path, parent: int, debug: bool) -> tuple[int, list[dict[str, Any]] | str]:
    """A piece in a worker: its place with the records of its cells, or with the reason why there are none."""
    if os.getpid() != parent:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the sweep ends its workers
    progress = [_heartbeat(cell, marks / cell.id, parent) for cell in piece]
    if len(piece) == 1:
        return place, [execute(piece[0], progress[0], debug)]
    try:
        return place, execute_together(piece, progress, debug)
    except (Exception, SystemExit) as error:
        if debug:
            traceback.print_exc()
        return place, told(error)
    finally:
        if (torch := sys.modules.get("torch")) and torch.cuda.is_initialized():
            torch.cuda.empty_cache()  # what PyTorch keeps of a GPU for later, other workers may need now


def _heartbeat(cell: Cell, mark: Path, parent: int) -> Callable[[int], None]:
    """Marks a cell as running; what it returns tells how far the cell is, and ends the worker if the sweep is gone."""
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
    return heartbeat
