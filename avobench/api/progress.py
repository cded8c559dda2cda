"""How far a fit or a diagnosis is: a bar on a terminal, a line in a notebook, plain lines elsewhere if asked for."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from avobench.api.terminal import plain as as_text
from avobench.tasks.errors import ProcessEnded

QUIET_SECONDS = 30.0
"""How often plain output tells how far it is."""
NOTEBOOK_SECONDS = 1.0
"""How often the line in a notebook changes; it is first there after as long."""

SHOW_CURSOR = "\x1b[?25h"

Progress = Callable[[str, int, int], None]
"""Is told the phase, the simulated events so far, and about how many there will be."""


@contextmanager
def shown(progress: Progress | bool | None, plain: bool = False) -> Iterator[Progress]:
    """What is to be told the progress: `progress` itself if it is a function, and nobody for False.

    For None and True it is a display on standard error, if that is a terminal, or in the notebook that this runs in; or
    with `plain` lines now and then.
    """
    if callable(progress):
        yield progress
        return
    from rich.console import Console  # here, since it takes a tenth of a second to load

    console = Console(stderr=True)
    if progress is False or not (plain or console.is_terminal or console.is_jupyter):
        yield lambda phase, done, total: None
    elif console.is_jupyter:
        with _line() as line:
            yield line
    else:
        with Bar(console) as bar:
            yield bar


class Bar:
    def __init__(self, console: Any) -> None:
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        self.console, self.began, self.last = console, time.monotonic(), time.monotonic()
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        self.shown = Progress(*columns, console=console, transient=True) if console.is_terminal else None
        self.row = self.shown.add_task("checks of the events", total=None) if self.shown else None

    def __enter__(self) -> "Bar":
        if self.shown:
            self.shown.start()
        return self

    def __exit__(self, *exception: object) -> None:
        if self.shown:
            self.shown.stop()

    def __call__(self, phase: str, done: int, total: int) -> None:
        if self.shown:
            self.shown.update(self.row, description=as_text(phase), completed=done, total=total)
        elif (now := time.monotonic()) - self.last >= QUIET_SECONDS:
            self.last = now
            self.console.print(
                as_text(_said(phase, done, total, now - self.began)), markup=False, highlight=False, soft_wrap=True
            )


@contextmanager
def _line() -> Iterator[Progress]:
    """A line below the cell of a notebook, which is empty at the end."""
    from IPython.display import HTML, display

    began = last = time.monotonic()
    handle = None

    def tell(phase: str, done: int, total: int) -> None:
        nonlocal handle, last
        if (now := time.monotonic()) - last < NOTEBOOK_SECONDS:
            return
        last = now
        line = HTML(_said(phase, done, total, now - began))
        if handle is None:
            handle = display(line, display_id=True)
        else:
            handle.update(line)

    try:
        yield tell
    finally:
        if handle is not None:
            handle.update(HTML(""))


@contextmanager
def cursor_kept() -> Iterator[None]:
    """Within the block a process that is ended leaves the cursor shown, which its display may have hidden."""
    try:
        yield
    except ProcessEnded:
        if sys.stderr is not None and sys.stderr.isatty():
            print(SHOW_CURSOR, end="", file=sys.stderr, flush=True)
        raise


def _said(phase: str, done: int, total: int, seconds: float) -> str:
    left = seconds * (total - done) / done if done else 0
    share = f", {done / total:.0%} of what is usual, about {clock(left)} left" if left > 0 else ""
    return f"{phase}: {done} simulated events{share}"


def clock(seconds: float) -> str:
    """A time for a person: `3.2 s`, `45 s`, `12 min`, `2 h 05 min`."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"
