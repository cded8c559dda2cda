"""Commands that run code of the user's: in another process, so that code which ends its process ends no command."""

import importlib
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Any

import click

from avobench.bench.plugins import registry
from avobench.bench.processes.apart import Call, apart
from avobench.tasks.errors import AvobenchError, ProcessEnded


@dataclass
class State:
    """What holds for the whole command, whichever it is."""

    debug: bool = False
    """Show tracebacks."""
    in_process: bool = False
    """Run the user's code in this process, for a debugger."""
    resumes: bool = False
    """Whether the command, when it was stopped and is given again, goes on from what was finished; it sets this."""
    interrupted: bool = False
    """Whether Ctrl-C came, whatever was made of it by what it interrupted."""

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """The handler of Ctrl-C: as Python's own, and remembered."""
        self.interrupted = True
        signal.default_int_handler(number, frame)


class Isolated(click.Command):
    """A command whose work is done in another process where its arguments name code that is not of this project."""

    def invoke(self, context: click.Context) -> Any:
        theirs = sorted(set(_theirs(context.params)))
        state = context.find_object(State)
        if not theirs or (state and state.in_process):
            return super().invoke(context)
        function = self.callback
        try:
            return apart(Call(_carried_out, (function.__module__, function.__name__, context.params)))
        except ProcessEnded as error:
            raise AvobenchError(f"{', '.join(theirs)}: {error}") from error


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
