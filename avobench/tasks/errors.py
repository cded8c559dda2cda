"""Every error that avobench raises on purpose. The command line prints each as one line."""

from collections.abc import Iterable
from difflib import get_close_matches
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import ValidationError


class AvobenchError(Exception):
    """Base of all; its text is one sentence that says what to do."""


class UsageError(AvobenchError):
    """The request itself cannot be met: unknown name, impossible number, wrong path. Exit code 2."""


class StoreError(AvobenchError):
    """The results folder cannot be used as it is. Exit code 1."""


class SimulatorError(AvobenchError):
    """A simulator raised, or returned events of the wrong shape, type or value."""


class SupportError(AvobenchError):
    """A method asked for parameters outside the simulator's support, or of the wrong shape."""


class BudgetExhausted(AvobenchError):
    """The metered simulator refused a request because it would exceed the budget. Nothing was simulated for it."""


class InvalidEstimate(AvobenchError):
    """The answer of a method cannot be recorded as an estimate."""


class ProcessEnded(AvobenchError):
    """A process ended before it had a result: `how` is "crashed", "timed_out" or "out_of_memory"; the text says why."""

    def __init__(self, how: str, why: str) -> None:
        super().__init__(how, why)
        self.how = how

    def __str__(self) -> str:
        return self.args[1]


def text_of(error: BaseException) -> str:
    """The text of an exception of anybody's, which may fail to give it."""
    try:
        return str(error)
    except Exception as why:
        return f"(its text cannot be had: {type(why).__name__})"


def raised(error: BaseException) -> str:
    """The exception that code of a user's raised, in words: the type of the exception and its text."""
    return f"{type(error).__name__}: {text_of(error)}"


def first_fault(error: "ValidationError") -> tuple[str, str]:
    """Where pydantic found something wrong first, as `a.b.0`, and what."""
    first = error.errors(include_url=False)[0]
    return ".".join(map(str, first["loc"])), first["msg"].removeprefix("Value error, ")


def shown(value: object) -> str:
    """What was given, as a part of a line: at most 60 characters of it."""
    try:
        return " ".join(repr(value).split())[:60]
    except Exception:  # of a user's class
        return type(value).__name__


def if_uneven(values: object) -> str:
    """What is to be done with events that hold different numbers of values, as of particles; "" for plain numbers.

    `values` are the cells of a column, or the rows of what is no array.
    """
    first = next(iter(values), None) if isinstance(values, Iterable) else None
    if isinstance(first, str) or not isinstance(first, Iterable):
        return ""
    return (
        "; reduce events with different numbers of values to the same ones each, such as `[(len(e), sum(e)) for e in "
        "events]`, or compare the spectrum of all values by the `of` of avobench.Table"
    )


def optional(module: str, what: str, extra: str) -> ModuleType:
    """A module that not every installation has. Raises UsageError, which says `what` needs it and how to install it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise UsageError(f"{what} needs {module}, which is not installed: {installed_by(extra)}") from error


def installed_by(extra: str) -> str:
    """The command that installs an optional part of the package, for the end of a message."""
    return f"in a clone of avobench, pip install '.[{extra}]'"


def did_you_mean(name: str, names: Iterable[str], n: int = 1, cutoff: float = 0.6) -> str:
    """A question after those of the `names` that are spelled like `name`; "" where there is none."""
    near = get_close_matches(name, list(names), n, cutoff)
    return f"did you mean {' or '.join(near)}?" if near else ""


def whole(name: str, value: object, least: int) -> int:
    """A setting that is a whole number from `least` to 2^63 - 1, such as 20000 or 2e4. Raises UsageError for others."""
    number = None
    if hasattr(value, "__index__") and not isinstance(value, bool):
        number = value.__index__()
    elif isinstance(value, float) and value.is_integer():
        number = int(value)
    if number is None or not least <= number < 2**63:
        raise UsageError(f"{name} must be a whole number from {least} to 2^63 - 1, got {shown(value)}")
    return number
