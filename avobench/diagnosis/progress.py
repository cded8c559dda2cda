"""How far a diagnosis is: its phase, and its simulated events beside those that it usually takes."""

from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Is told the phase, the simulated events so far, and about how many there will be."""


class Telling:
    """Tells `progress` whatever a meter tells."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.phase, self.used, self.total = progress, "first fit", 0, total

    def begin(self, phase: str, more: int = 0) -> None:
        """A phase begins, for which `more` events are expected than for those before."""
        self.phase = phase
        self.total = max(self.total, self.used + more)
        self(self.used)

    def __call__(self, used: int) -> None:
        self.used = used
        if self.progress is not None:
            self.progress(self.phase, used, max(used, self.total))
