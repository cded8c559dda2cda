"""The progress that a command shows: a live display on a terminal, plain lines elsewhere. All on standard error."""

import time
from collections.abc import Callable
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table

from avobench.api.progress import QUIET_SECONDS, clock
from avobench.api.terminal import plain
from avobench.bench.cells.cell import Cell
from avobench.bench.store.status import Status, reason
from avobench.bench.sweep.runner import Sweep, View


class ProgressView(View):
    """A line for each finished cell; below it, on a terminal, the sweep and the running cells as bars."""

    def __init__(self, console: Console, after_cell: Callable[[Sweep, Cell], None]) -> None:
        self.console, self.after_cell = console, after_cell
        self.live = Live(console=console, auto_refresh=False, transient=True) if console.is_terminal else None
        self.last = time.monotonic()

    def __enter__(self) -> "ProgressView":
        if self.live:
            self.live.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self.live:
            self.live.stop()

    def note(self, line: str) -> None:
        self.console.print(plain(line), markup=False, highlight=False, soft_wrap=True)

    def finished(self, sweep: Sweep, cell: Cell, record: dict[str, Any]) -> None:
        seconds = record["simulator_seconds"] + record["method_seconds"]
        if record["status"] == Status.OK:
            ratio = f" ({record['squared_error'] / record['floor']:.3g} x floor)" if record["floor"] else ""
            outcome = f"squared error {record['squared_error']:.3g}{ratio}"
        else:
            outcome = reason(record)
        self.note(
            f"[{len(sweep.done)}/{len(sweep.cells)}] {cell.label}: {outcome}, {clock(seconds)}{_time_left(sweep)}"
        )
        self.after_cell(sweep, cell)
        self.last = time.monotonic()

    def tick(self, sweep: Sweep) -> None:
        labels = {cell.id: cell.label for cell in sweep.pending}
        running = {labels[id]: share for id, share in sorted(sweep.running.items()) if id in labels}
        if self.live:
            table = Table.grid(padding=(0, 1))
            share = (len(sweep.done) + sum(running.values())) / len(sweep.cells)
            bars = {f"{len(sweep.done)} of {len(sweep.cells)} cells{_time_left(sweep)}": share, **running}
            for label, value in bars.items():
                table.add_row(ProgressBar(total=1, completed=value, width=30), f"{value:4.0%}", label)
            self.live.update(table, refresh=True)
        elif time.monotonic() - self.last >= QUIET_SECONDS:
            self.last = time.monotonic()
            self.note(
                "running: " + ", ".join(f"{label} {share:.0%}" for label, share in running.items()) + _time_left(sweep)
            )


def _time_left(sweep: Sweep) -> str:
    if not sweep.pending:
        return ""
    remaining, all_timed = sweep.seconds_left()
    return f"; {'about' if all_timed else 'at least'} {clock(remaining)} left" if remaining else ""
