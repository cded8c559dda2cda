"""How far a fit or a diagnosis is, on a terminal, in a notebook or in plain lines, and how long it may take."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from avobench.api.terminal import plain as as_text
from avobench.bench.processes.calls import apart_within
from avobench.tasks.errors import ProcessEnded

QUIET_SECONDS = 30.0
"""How often plain output tells how far it is."""
NOTEBOOK_SECONDS = 1.0
"""How often the line in a notebook changes; it is first there after as long."""

P = ParamSpec("P")
R = TypeVar("R")
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
    else:
        with _in_notebook() if console.is_jupyter else displayed(console) as tell:
            yield tell


@contextmanager
def displayed(console: Any) -> Iterator[Progress]:
    """A bar on a terminal, and else a line every QUIET_SECONDS."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    if not console.is_terminal:
        yield _now_and_then(
            QUIET_SECONDS, lambda line: console.print(as_text(line), markup=False, highlight=False, soft_wrap=True)
        )
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        row = bar.add_task("checks of the events", total=None)
        yield lambda phase, done, total: bar.update(row, description=as_text(phase), completed=done, total=total)


@contextmanager
def _in_notebook() -> Iterator[Progress]:
    """A line below the cell of a notebook, which is empty at the end."""
    from IPython.display import HTML, display

    handles: list[Any] = []

    def show(line: str) -> None:
        if handles:
            handles[0].update(HTML(line))
        else:
            handles.append(display(HTML(line), display_id=True))

    try:
        yield _now_and_then(NOTEBOOK_SECONDS, show)
    finally:
        if handles:
            show("")


def _now_and_then(seconds: float, show: Callable[[str], None]) -> Progress:
    """What shows a line of progress every so many seconds."""
    began = last = time.monotonic()

    def tell(phase: str, done: int, total: int) -> None:
        nonlocal last
        if (now := time.monotonic()) - last >= seconds:
            last, spent = now, now - began
            remaining = spent * (total - done) / done if done else 0
            share = f", {done / total:.0%} of what is usual, about {clock(remaining)} left" if remaining > 0 else ""
            show(f"{phase}: {done} simulated events{share}")

    return tell


@contextmanager
def cursor_kept() -> Iterator[None]:
    """Within the block a process that is ended leaves the cursor shown, which its display may have hidden."""
    try:
        yield
    except ProcessEnded:
        if sys.stderr is not None and sys.stderr.isatty():
            print(SHOW_CURSOR, end="", file=sys.stderr, flush=True)
        raise


def limited(function: Callable[P, R]) -> Callable[P, R]:
    """A function that works in a process of its own where `seconds` is given, and is ended after so long.

    All other arguments are passed on as they are. The function itself makes nothing of `seconds`.
    """

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> R:
        seconds = options.pop("seconds", None)
        if seconds is None:
            return function(*arguments, **options)
        with cursor_kept():
            return apart_within(seconds, called, *arguments, **options)

    return called


def clock(seconds: float) -> str:
    """A time for a person: `3.2 s`, `45 s`, `12 min`, `2 h 05 min`."""
    if seconds < 60:
        return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"
