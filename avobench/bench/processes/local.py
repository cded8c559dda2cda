"""Cells carried out in processes of this machine, one by one or many as one piece of work; or in this process."""

import json
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import blank_record, execute, execute_together, message_of
from avobench.bench.processes.calls import Call, Limits, outcomes
from avobench.bench.processes.contract import ATTEMPTS, Backend, differing, heartbeat
from avobench.bench.store.files import disk_errors, write_atomically
from avobench.bench.store.status import Status
from avobench.tasks.errors import UsageError

LIMITS = Limits(seconds=6 * 3600, mib=8192)
"""The limits of a cell. The longest of the committed records took 21 minutes, the largest 3.3 GiB."""
EACH = ("target", "repetition", "theta_true")
"""These fields may differ between the cells of a piece."""
Piece = tuple[Cell, ...]
"""Cells that a worker carries out as one."""


@dataclass(frozen=True)
class LocalBackend(Backend):
    """Processes of this machine. Each running cell keeps a file in `marks`, with the share of its budget used.

    A process that ends, hangs or takes too much memory costs its own piece only: one cell, or with `together` all
    targets and repetitions of a task and a method that gains from it. A piece that fails as a whole is begun again in
    halves, one whose process ended in single cells; such a cell is tried once more, by itself, when all else is done.
    """

    jobs: int | None
    """None for this process alone, without limits."""
    marks: Path
    _: KW_ONLY
    together: bool = False
    most: int | None = None
    """The most cells of a piece."""
    limits: Limits = LIMITS
    """Those of a cell."""
    debug: bool = False

    @property
    def name(self) -> str:
        return "together" if self.together else "local"

    @property
    def workers(self) -> int:
        return self.jobs or 1

    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        with disk_errors(f"{self.marks} cannot be made"):
            self.marks.mkdir(exist_ok=True)
        deaths: dict[str, int] = {}
        work, jobs = self.pieces(cells), self.jobs
        while work:
            again: list[Piece] = []
            calls = [Call(_work, (piece, self.marks, self.debug), self.limits.times(len(piece))) for piece in work]
            for place, outcome in outcomes(jobs, calls):
                piece = work[place]
                for cell in piece:
                    (self.marks / cell.id).unlink(missing_ok=True)
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
            work, jobs = again, jobs and 1

    def pieces(self, cells: list[Cell]) -> list[Piece]:
        """The pieces in the order of their first cells, those of several cells before all others: they take longest."""
        alike: dict[str, list[Cell]] = {}
        for cell in cells:
            shared = {name: value for name, value in cell.identity.items() if name not in EACH}
            key = json.dumps(shared, sort_keys=True) if self.together and cell.together else cell.id
            alike.setdefault(key, []).append(cell)
        pieces = []
        for group in alike.values():
            most = self.most or len(group)
            pieces += [tuple(group[start : start + most]) for start in range(0, len(group), most)]
        return sorted(pieces, key=lambda piece: len(piece) == 1)

    def shares(self) -> dict[str, float]:
        shares = {}
        for path in self.marks.glob("[!.]*"):
            with suppress(FileNotFoundError):  # finished in between
                shares[path.name] = json.loads(path.read_text())
        return shares


def label(piece: Piece) -> str:
    first, n = piece[0], len(piece)
    return first.label if n == 1 else f"{first.identity['task']} {first.identity['method']}, {n} cells together"


def _work(piece: Piece, marks: Path, debug: bool) -> list[dict[str, Any]] | str:
    """A piece in a worker: the records of its cells, or the reason why there are none.

    Raises UsageError where its task or method is not the one that was planned: its records would be under a wrong name.
    """
    if what := differing(piece[0]):
        raise UsageError(
            f"{what} was changed while the sweep runs; give the same command again, which keeps what is finished (if "
            "you changed no file, make the values that it holds the same in every process)"
        )
    progress = [heartbeat(cell, partial(_mark, marks / cell.id)) for cell in piece]
    if len(piece) == 1:
        return [execute(piece[0], progress[0], debug)]
    try:
        return execute_together(piece, progress, debug)
    except (Exception, SystemExit) as error:
        if debug:
            traceback.print_exc()
        return message_of(error)
    finally:
        if (torch := sys.modules.get("torch")) and torch.cuda.is_initialized():
            torch.cuda.empty_cache()  # what PyTorch keeps of a GPU for later, other workers may need now


def _mark(path: Path, share: float) -> None:
    with suppress(OSError):  # a full disk costs the display, not the cell
        write_atomically(path, json.dumps(share).encode())
