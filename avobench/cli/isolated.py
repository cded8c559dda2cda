"""Commands that run code of the user's: in another process, so that code which ends its process ends no command."""

import importlib
import sys
from collections.abc import Iterator
from typing import Any

import click

from avobench.bench.plugins import registry
from avobench.bench.processes.apart import Call, apart
from avobench.cli.state import State
from avobench.tasks.errors import AvobenchError, ProcessEnded


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
