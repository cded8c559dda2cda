"""Commands that run code of the user's: in another process, so that code which ends its process ends no command."""

import importlib
import sys
from collections.abc import Iterator
from typing import Any

import click

from avobench.api.progress import cursor_kept
from avobench.bench.plugins import registry
from avobench.bench.processes.calls import NO_LIMITS, Call, apart, in_seconds
from avobench.cli.state import State
from avobench.tasks.errors import AvobenchError, ProcessEnded, UsageError


class Isolated(click.Command):
    """A command whose work is done in another process where its arguments name code that is not of this project."""

    def invoke(self, context: click.Context) -> Any:
        seconds = context.params.pop("seconds", None)
        limits = NO_LIMITS if seconds is None else in_seconds("--seconds", seconds)
        theirs = sorted(set(_theirs(context.params)))
        state = context.find_object(State)
        if state and context.params.get("bank"):
            state.resumes = True
        if state and state.in_process and seconds is not None:
            raise UsageError("--seconds is not for --in-process: nothing could end it")
        if (not theirs and seconds is None) or (state and state.in_process):
            return super().invoke(context)
        function = self.callback
        try:
            with cursor_kept():
                return apart(Call(_carried_out, (function.__module__, function.__name__, context.params), limits))
        except ProcessEnded as error:
            raise AvobenchError(": ".join(filter(None, (", ".join(theirs), str(error))))) from error


def _theirs(params: dict[str, Any]) -> Iterator[str]:
    """Values that name code of a user's. A file of data may be taken for one, which costs a second and no more."""
    if params.get("trust"):
        yield "a file that is trusted"
    if params.get("sets"):
        yield params["sets"]
    for value in params.values():
        for each in value if isinstance(value, tuple | list) else (value,):
            if isinstance(each, str) and any(registry.runs_theirs(kind, each) for kind in registry.GROUPS):
                yield each


def _carried_out(module: str, name: str, params: dict[str, Any]) -> None:
    getattr(importlib.import_module(module), name).callback(**params)
    sys.stdout.flush()
