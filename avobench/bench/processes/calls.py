"""Calls in processes of their own, so that one which ends, hangs or fills the memory is told and not suffered.

A process is started with a new interpreter, not forked, so it shares no threads and no GPU with this one, and a script
needs no `if __name__ == "__main__"`. It is given one call after the other. No class of a user's is sent back.

The processes are those of joblib's loky. Its executor is not used: one process that dies breaks all of its others off,
and a call can neither be given a limit nor be ended by itself. pebble 5.2 was measured as fast (0.3 s for a first call,
0.6 s for 2000), but a call whose process dies while it unpickles its arguments never ends, what a call has started
outlives its limit of time, and the limit of memory must be kept within the process, which was late by seconds where
compiled code holds the interpreter's lock.
"""

import math
import multiprocessing.process
import multiprocessing.resource_tracker
import os
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pickle import PicklingError
from typing import Any

import cloudpickle
import psutil
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.backend import resource_tracker
from joblib.externals.loky.backend.context import get_context

from avobench.tasks import errors
from avobench.tasks.errors import AvobenchError, ProcessEnded, UsageError, raised, shown

WATCH_SECONDS = 0.25
"""Time and memory are looked at this often: a process that fills 1 GiB a second is seen within 256 MiB."""
GRACE_SECONDS = 2.0
"""A process that was asked to end has so long to tidy up: removing a temporary file takes milliseconds."""
PARENT_SECONDS = 0.5
"""A process looks this often whether the one that started it is still there."""
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMEXPR", "NUMBA")}
"""Without these, libraries would share a product of matrices out to threads, with other rounding."""
SAFE_PATH = "PYTHONSAFEPATH"
MIB = 2**20  # bytes
_KEPT: "ContextVar[list[_Process] | None]" = ContextVar("kept", default=None)
"""Processes without work, within `kept`."""


@dataclass(frozen=True)
class Limits:
    """The limits of a call in its process; None is no limit. Processes that it starts itself are not counted."""

    seconds: float | None = None
    """The limit of time by the clock on the wall, the loading of packages included."""
    mib: float | None = None
    """The limit of resident memory, in MiB."""

    def times(self, n: int) -> "Limits":
        """The limits of n pieces of work at once."""
        return Limits(*(None if each is None else n * each for each in (self.seconds, self.mib)))


NO_LIMITS = Limits()


def in_seconds(name: str, seconds: object) -> Limits:
    """The limit of time that a user asks for. Raises UsageError, with the name that it has there, for what is none."""
    if isinstance(seconds, bool) or not isinstance(seconds, int | float) or not 0 < seconds < math.inf:
        raise UsageError(f"{name} must be a number above 0, got {shown(seconds)}")
    return Limits(seconds=float(seconds))


@dataclass(frozen=True)
class Call:
    """A function of a module with its arguments, all of which can be pickled, and what it may take."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limits: Limits = NO_LIMITS


class Fault(Exception):
    """A call raised what it should not have; the text names it, and the cause shows where."""


class _Trace(Exception):
    """The traceback of an exception that was raised in another process."""


def apart(call: Call) -> Any:
    """Carry a call out in a process of its own; raises its AvobenchError or OSError, ProcessEnded or Fault."""
    ((_, outcome),) = outcomes(1, [call])
    if isinstance(outcome, ProcessEnded):
        raise outcome
    return outcome


def apart_within(seconds: float, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Return what a function returns in a process of its own, which is ended after so many seconds.

    What it is given and what it returns may be of classes and functions of a script or a notebook. Raises as `apart`
    does, and UsageError for seconds that are none, or for what cannot be sent.
    """
    limits = in_seconds("seconds", seconds)
    try:
        sent = cloudpickle.dumps((function, arguments, options))
    except (TypeError, PicklingError, AttributeError) as error:
        raise UsageError(f"what is given cannot be sent to the process that `seconds` limits: {error}") from error
    return cloudpickle.loads(apart(Call(_unpacked, (sent,), limits)))


def _unpacked(sent: bytes) -> bytes:
    function, arguments, options = cloudpickle.loads(sent)
    return cloudpickle.dumps(function(*arguments, **options))


def outcomes(jobs: int | None, calls: Iterable[Call]) -> Iterator[tuple[int, Any]]:
    """The place of each call and what became of it, as they end; begun in their order, so many at a time.

    The outcome is what the call returned, or the ProcessEnded that tells how its process ended, which does not touch
    the others; what else `apart` would raise is raised. When the generator is closed, all processes are ended, but for
    those that are `kept`. Where `jobs` is None, calls are carried out in this process and without limits.
    """
    if jobs is None:
        for place, call in enumerate(calls):
            yield place, call.function(*call.arguments)
        return
    waiting = deque(enumerate(calls))
    busy: dict[_Process, int] = {}
    idle: list[_Process] = [] if (kept_ones := _KEPT.get()) is None else kept_ones
    try:
        while waiting or busy:
            while waiting and len(busy) < jobs:
                place, call = waiting.popleft()
                process = idle.pop() if idle else _Process()
                busy[process] = place
                process.begin(call)
            wait([process.pipe for process in busy], WATCH_SECONDS)
            for process, place in list(busy.items()):
                if (outcome := process.outcome()) is not None:
                    del busy[process]
                    if process.alive:
                        idle.append(process)
                    if isinstance(outcome[0], BaseException) and not isinstance(outcome[0], ProcessEnded):
                        raise outcome[0]
                    yield place, outcome[0]
    finally:
        for process in busy:
            process.terminate()
        for process in busy:
            process.end()
        if kept_ones is None:
            _end_all(idle)


@contextmanager
def kept() -> Iterator[None]:
    """Within the block a process that has finished its calls serves the next ones: starting one takes a second."""
    idle: list[_Process] = []
    before = _KEPT.set(idle)
    try:
        yield
    finally:
        _KEPT.reset(before)
        _end_all(idle)


def _end_all(idle: "list[_Process]") -> None:
    for process in idle:
        process.pipe.close()  # which they take as the end, all at once
    for process in idle:
        process.end()


class _Process:
    def __init__(self) -> None:
        context = get_context("loky")
        self.pipe, theirs = context.Pipe()
        self._process: multiprocessing.process.BaseProcess = context.Process(
            target=_serve, args=(theirs, os.getpid()), env=ONE_THREAD
        )
        with _safe_path():
            for tracker in (multiprocessing.resource_tracker, resource_tracker):
                tracker.ensure_running()  # its own start would unblock the signal
            with _interrupts_held():
                self._process.start()
        theirs.close()
        self.alive = True
        self._began, self._limits = 0.0, Limits()

    def begin(self, call: Call) -> None:
        self._began, self._limits = time.monotonic(), call.limits
        with suppress(OSError):  # it is dead, which `outcome` tells
            self.pipe.send((call.function, call.arguments))

    def outcome(self) -> tuple[Any] | None:
        """The outcome of the call, in a tuple of one; None while it is under way."""
        alive = self._process.is_alive()  # asked for first: what it sent before it ended is in the pipe then
        if self.pipe.poll():
            try:
                kind, value, trace = self.pipe.recv()
            except (EOFError, OSError):
                return (self._died(),)
            if kind == "fault":
                fault = Fault(value)
                fault.__cause__ = _Trace(trace)
                return (fault,)
            if kind == "raised":
                value.__cause__ = _Trace(trace)
            return (value,)
        if not alive:  # and a process that it forked off holds the pipe open
            return (self._died(),)
        if (ended := self._over()) is not None:
            self.end(grace=0)
            return (ended,)
        return None

    def _died(self) -> ProcessEnded:
        self._process.join(GRACE_SECONDS)  # the pipe closes a moment before
        code = self._process.exitcode
        self.end()
        if code is not None and code < 0:
            name = signal.Signals(-code).name if -code in iter(signal.Signals) else f"signal {-code}"
            why = " (the system does that when it has no memory left)" if name == "SIGKILL" else ""
            return ProcessEnded("crashed", f"the process was ended by {name}{why}")
        return ProcessEnded("crashed", f"the process ended itself, with exit code {code}")

    def _over(self) -> ProcessEnded | None:
        """The limit that the process exceeds; None where it exceeds none."""
        seconds, mib = self._limits.seconds, self._limits.mib
        if seconds is not None and time.monotonic() - self._began > seconds:
            return ProcessEnded("timed_out", f"ended after {seconds:g} s, the limit of time")
        with suppress(psutil.Error):
            if mib is not None and (used := psutil.Process(self._process.pid).memory_info().rss / MIB) > mib:
                return ProcessEnded("out_of_memory", f"ended with {used:.0f} MiB of memory, the limit is {mib:g} MiB")
        return None

    def terminate(self) -> None:
        with suppress(psutil.Error):
            psutil.Process(self._process.pid).terminate()

    def end(self, grace: float = GRACE_SECONDS) -> None:
        """End it, with all processes that it started; it has `grace` seconds to do so itself."""
        self.alive = False
        family = []
        with suppress(psutil.Error):
            process = psutil.Process(self._process.pid)
            family = [*process.children(recursive=True), process]
        self.pipe.close()
        self._process.join(grace)
        for process in family:
            with suppress(psutil.Error):
                process.kill()
        self._process.join()


@contextmanager
def _safe_path() -> Iterator[None]:
    """Within the block Python starts without the current folder on its path: a random.py in it is not Python's."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        os.environ.pop(SAFE_PATH)
        if before is not None:
            os.environ[SAFE_PATH] = before


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C waits within the block; a process that is started in it is not reached by it while it loads packages."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, parent: int) -> None:
    """The life of a process: it carries out what it is sent until nobody sends anything more."""
    os.environ.pop(SAFE_PATH)  # what a simulator starts finds its own files
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process; the one that began it ends the others
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    with suppress(EOFError, OSError, KeyboardInterrupt):  # nobody sends, nobody takes, it is to end
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        while True:
            answer = _answer(*pipe.recv())
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            try:
                pipe.send(answer)
            except (TypeError, AttributeError, PicklingError) as error:
                pipe.send(("fault", raised(error), traceback.format_exc()))
    # Else multiprocessing would wait for joblib's workers, before the functions that run at exit remove their folders.
    get_reusable_executor().shutdown(kill_workers=True)


def _answer(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[str, Any, str]:
    try:
        return "value", function(*arguments), ""
    except (Exception, SystemExit) as error:
        # A class of a user's would be imported where it arrives, with the code that goes with it.
        ours = isinstance(error, AvobenchError | OSError) and type(error).__module__ in (errors.__name__, "builtins")
        failure = error if ours else raised(error)
        return "raised" if ours else "fault", failure, traceback.format_exc()


def _end_with(parent: int) -> None:
    """End this process when the one that started it is gone: nobody is left to take what it makes."""
    while os.getppid() == parent:
        time.sleep(PARENT_SECONDS)
    os._exit(1)
