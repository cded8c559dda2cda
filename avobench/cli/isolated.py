"""Commands that run code of the user's: in another process, so that code which ends its process ends no command."""

import importlib
import os
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Any

import click

from avobench.bench.plugins import registry
from avobench.bench.processes.apart import NO_LIMITS, Call, apart, in_seconds
from avobench.tasks.errors import AvobenchError, ProcessEnded, UsageError

STOPPED = 130
"""The exit code after Ctrl-C."""
STOPPING_SECONDS = 3.0
"""A stop may take so long: processes are given two seconds to tidy up. An impatient Ctrl-C disturbs it no more."""
SHOW_CURSOR = "\x1b[?25h"


@dataclass
class State:
    """What holds for the whole command, whichever it is."""

    debug: bool = False
    """Show tracebacks."""
    in_process: bool = False
    """Run the user's code in this process, for a debugger."""
    resumes: bool = False
    """Whether the command, when it was stopped and is given again, goes on from what was finished; it sets this."""
    interrupted: float | None = None
    """When Ctrl-C first came, by the monotonic clock, whatever was made of it by what it interrupted."""

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """The handler of Ctrl-C: the first raises KeyboardInterrupt, one that comes when that was in vain ends all."""
        if self.interrupted is None:
            self.interrupted = time.monotonic()
            signal.default_int_handler(number, frame)
        if time.monotonic() - self.interrupted > STOPPING_SECONDS:
            os.write(2, f"{self.stopped}\n".encode())
            os._exit(STOPPED)

    @property
    def stopped(self) -> str:
        """The last line of a command that was stopped."""
        resumes = "what was finished is kept, and the same command goes on from there"
        return f"avobench: stopped; {resumes if self.resumes else 'the same command begins anew'}"


class Isolated(click.Command):
    """A command whose work is done in another process where its arguments name code that is not of this project."""

    def invoke(self, context: click.Context) -> Any:
        seconds = context.params.pop("seconds", None)
        limits = NO_LIMITS if seconds is None else in_seconds("--seconds", seconds)
        theirs = sorted(set(_theirs(context.params)))
        state = context.find_object(State)
        if state and state.in_process and seconds is not None:
            raise UsageError("--seconds is not for --in-process: nothing could end it")
        if (not theirs and seconds is None) or (state and state.in_process):
            return super().invoke(context)
        function = self.callback
        try:
            return apart(Call(_carried_out, (function.__module__, function.__name__, context.params), limits))
        except ProcessEnded as error:
            if sys.stderr.isatty():
                click.echo(SHOW_CURSOR, err=True, nl=False)  # a display that was ended may have hidden it
            raise AvobenchError(": ".join(filter(None, (", ".join(theirs), str(error))))) from error


def _theirs(params: dict[str, Any]) -> Iterator[str]:
    """Values that name code of a user's. A file of data may be taken for one, which costs a second and no more."""
    if params.get("trust"):
        yield "a file that is trusted"
    for value in params.values():
        for each in value if isinstance(value, tuple | list) else (value,):
            if isinstance(each, str) and any(registry.runs_theirs(kind, each) for kind in registry.GROUPS):
                yield each


def _carried_out(module: str, name: str, params: dict[str, Any]) -> None:
    getattr(importlib.import_module(module), name).callback(**params)
    sys.stdout.flush()
