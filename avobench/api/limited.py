"""The limit of time of a call from Python, which the argument `seconds` gives."""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from avobench.api.progress import cursor_kept
from avobench.bench.processes.apart import apart_within

P = ParamSpec("P")
R = TypeVar("R")


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
