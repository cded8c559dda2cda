"""A limit of time for a call in this process, so that a function which hangs is told and not waited for."""

import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from avobench.tasks.errors import UsageError


class _Over(BaseException):
    """The time is over; no Exception, so that the function that hangs does not take it for one of its own."""


@contextmanager
def limited_to(seconds: float, what: str) -> Iterator[None]:
    """End the block after so many seconds by UsageError, which says `what` hangs.

    It is ended as by Ctrl-C: within Python, not within compiled code, and in the main thread only, not on Windows.
    """
    if not 0 < seconds < math.inf:
        raise UsageError(f"seconds must be a number above 0, got {seconds}")
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return

    def over(number: int, frame: object) -> None:
        raise _Over

    began, before = time.monotonic(), signal.signal(signal.SIGALRM, over)
    left, interval = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except _Over:
        raise UsageError(f"{what} has not returned after {seconds:g} s; mend it, or allow more `seconds`") from None
    finally:
        # An alarm that was set before is set again.
        signal.setitimer(signal.ITIMER_REAL, left and max(left - (time.monotonic() - began), 1e-3), interval)
        signal.signal(signal.SIGALRM, before)
