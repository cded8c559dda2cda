"""The conformance suite: does a task, method or effect, ours or a user's, keep its contract?

Checks come in rounds. Seeds are fixed, so a verdict is repeatable.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from avobench.bench.conformance import effects, methods, tasks
from avobench.bench.conformance.promises import BrokenPromise
from avobench.bench.plugins import registry
from avobench.tasks.errors import SimulatorError, raised, text_of
from avobench.tasks.meter import Meter

ROUNDS = {"method": methods.rounds, "effect": effects.rounds}


@dataclass(frozen=True)
class Result:
    """The outcome of one check; `why` is one line, empty for one that passed."""

    passed: bool
    what: str
    why: str = ""


def run(kind: str, name: str, meter: Meter | None = None) -> Iterator[Result]:
    """Check the task, method or effect `name` by default settings; results as they come.

    A round is tried only if all checks of the one before passed, so that one fault is told once. A `meter` counts the
    events of a task. Raises UsageError alone: where there is no such object, or a package that it needs is not
    installed.
    """
    if kind == "effect":
        subject = effects.subjects(name)
        for task, _ in subject:
            registry.require_packages("task", task)
    else:
        subject = registry.build(kind, name, {})
        registry.require_packages(kind, subject)
    rounds = tasks.rounds(name, subject, meter or Meter()) if kind == "task" else ROUNDS[kind](name, subject)
    for checks in rounds:
        passed = True
        for what, check in checks:
            result = _result(what, check)
            passed &= result.passed
            yield result
        if not passed:
            return


def _result(what: str, check: Callable[[], None]) -> Result:
    try:
        check()
    except (Exception, SystemExit) as error:
        ours = isinstance(error, (BrokenPromise, SimulatorError))
        return Result(False, what, " ".join((text_of if ours else raised)(error).split()))
    return Result(True, what)
