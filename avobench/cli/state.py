"""The state of a command line as a whole, whichever command it is of."""

import os
import signal
import time
from dataclasses import dataclass
from types import FrameType

STOPPED = 130
"""The exit code after Ctrl-C."""
STOPPING_SECONDS = 3.0
"""A stop may take so long: processes are given two seconds to tidy up. An impatient Ctrl-C disturbs it no more."""


@dataclass
class State:
    debug: bool = False
    """Show tracebacks."""
    in_process: bool = False
    """Run the user's code in this process, for a debugger."""
    resumes: bool = False
    """True if the command, when it was stopped and is given again, goes on from what was finished; it sets this."""
    interrupted: float | None = None
    """The time at which Ctrl-C first came, by the monotonic clock, whatever was made of it by what it interrupted."""

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
        kept = "finished work is kept, and the same command continues from it"
        return f"avobench: stopped; {kept if self.resumes else 'nothing was kept, and the same command starts again'}"
