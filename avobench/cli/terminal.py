"""The output of a command: text that gives the terminal no orders, and damaged records, which it names alike."""

import warnings
from collections.abc import Callable

import click

from avobench.api.terminal import plain
from avobench.bench.store.damage import DamagedRecord


def say(text: object, *, err: bool = False) -> None:
    """Print a line on standard output, or on standard error."""
    click.echo(plain(text), err=err)


def naming_damaged(command: Callable[[], int | None]) -> int:
    """The exit code of `command`, or 1 where it left a damaged record out; each is named once on standard error."""
    named: set[str] = set()
    show = warnings.showwarning

    def name(message: Warning | str, category: type[Warning], *where: object, **more: object) -> None:
        if not issubclass(category, DamagedRecord):
            show(message, category, *where, **more)
        elif str(message) not in named:
            named.add(str(message))
            say(f"avobench: {' '.join(str(message).split())}", err=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", DamagedRecord)
        warnings.showwarning = name
        code = command() or 0
    return code or (1 if named else 0)
