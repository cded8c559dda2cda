"""What holds for a command line as a whole, whichever command it is of."""

import signal
from dataclasses import dataclass
from types import FrameType


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
