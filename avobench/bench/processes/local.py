"""Cells carried out in worker processes of this machine; or in this process, where that is asked for."""

import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import blank_record, execute, execute_together, told
from avobench.bench.processes.apart import Call, Limits, here, outcomes
from avobench.bench.processes.contract import Backend
from avobench.bench.store.atomic import write_atomically
from avobench.bench.store.status import Status
from avobench.tasks.errors import ProcessEnded, StoreError

HEARTBEAT_SECONDS = 1.0
"""How often a cell tells how far it is: as often as the display is drawn."""
ATTEMPTS = 2
"""How often a cell may lose its worker process before it is recorded as crashed."""
LIMITS = Limits(seconds=6 * 3600, mib=8192)
"""Of a cell. The longest of the committed records took 21 minutes, the largest 3.3 GiB."""
Piece = tuple[Cell, ...]
"""Cells that a worker carries out as one."""


class LocalBackend(Backend):
    """Processes of this machine. Each running cell keeps a file in `marks`, with the share of its budget used.

    A process that ends, hangs or takes too much memory costs its own piece only. A cell whose process ended is tried
    once more when all else is done, by itself, since another may have left it no memory; one that exceeds a limit is
    not.

    A process is given a piece of work at a time, here always of one cell. A subclass may make larger pieces: one that
    fails as a whole is begun again in halves, one whose process ended in single cells, one after the other, so that
    only the cell to blame fails.
    """

    name = "local"

    def __init__(
        self, jobs: int, marks: Path, *, limits: Limits = LIMITS, in_process: bool = False, debug: bool = False
    ) -> None:
        """`limits` are those of a cell; with `in_process` cells are carried out in this process, without limits."""
        self._jobs, self._marks, self._limits, self._debug = jobs, marks, limits, debug
        self._in_process = in_process

    @property
    def workers(self) -> int:
        return self._jobs

    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        try:
            self._marks.mkdir(exist_ok=True)
        except OSError as error:
            raise StoreError(f"{self._marks} cannot be made: {error.strerror or error}") from error
        deaths: dict[str, int] = {}
        work, jobs = self.pieces(cells), self._jobs
        while work:
            again: list[Piece] = []
            for piece, outcome in self._outcomes(work, jobs):
                for cell in piece:
                    (self._marks / cell.id).unlink(missing_ok=True)
                if isinstance(outcome, list):
                    yield from outcome
                elif isinstance(outcome, str):
                    middle = (len(piece) + 1) // 2
                    again += [piece[:middle], piece[middle:]]
                    note(f"{label(piece)}: {outcome}; begun again in halves, as with --group {middle}")
                elif len(piece) > 1:
                    again += [(cell,) for cell in piece]
                    note(f"{label(piece)}: {outcome}; begun again one by one")
                else:
                    deaths[piece[0].id] = deaths.get(piece[0].id, 0) + 1
                    if outcome.how == Status.CRASHED and deaths[piece[0].id] < ATTEMPTS:
                        again.append(piece)
                        note(f"{label(piece)}: {outcome}; begun again when all else is done")
                    else:
                        tries = f" ({ATTEMPTS} times)" if outcome.how == Status.CRASHED else ""
                        yield blank_record(piece[0], Status(outcome.how), f"{outcome}{tries}")
            work, jobs = again, 1

    def pieces(self, cells: list[Cell]) -> list[Piece]:
        """The cells in the pieces that workers are given, in the order in which they are begun."""
        return [(cell,) for cell in cells]

    def shares(self) -> dict[str, float]:
        shares = {}
        for path in self._marks.glob("[!.]*"):
            with suppress(FileNotFoundError):  # finished in between
                shares[path.name] = json.loads(path.read_text())
        return shares

    def _outcomes(
        self, work: list[Piece], jobs: int
    ) -> Iterator[tuple[Piece, list[dict[str, Any]] | str | ProcessEnded]]:
        """Pieces as they are finished, each with what `_work` returns, or how its process ended."""
        calls = [
            Call(_work, (piece, self._marks, os.getpid(), self._debug), self._limits.times(len(piece)))
            for piece in work
        ]
        for place, outcome in here(calls) if self._in_process else outcomes(jobs, calls):
            if isinstance(outcome, BaseException) and not isinstance(outcome, ProcessEnded):
                raise outcome
            yield work[place], outcome


def label(piece: Piece) -> str:
    """What a piece of work is, for a line to the user."""
    first, n = piece[0], len(piece)
    return first.label if n == 1 else f"{first.identity['task']} {first.identity['method']}, {n} cells together"


def _work(piece: Piece, marks: Path, parent: int, debug: bool) -> list[dict[str, Any]] | str:
    """A piece in a worker: the records of its cells, or the reason why there are none."""
    progress = [_heartbeat(cell, marks / cell.id, parent) for cell in piece]
    if len(piece) == 1:
        return [execute(piece[0], progress[0], debug)]
    try:
        return execute_together(piece, progress, debug)
    except (Exception, SystemExit) as error:
        if debug:
            traceback.print_exc()
        return told(error)
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
