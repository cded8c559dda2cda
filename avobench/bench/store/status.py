"""The outcomes that a cell may have, each with a sentence, and the reason of a failure."""

from enum import StrEnum
from typing import Any


class Status(StrEnum):
    """Outcome of a cell; `ok` exactly when an estimate was made within the budget and nothing speaks against it."""

    OK = "ok"
    BUDGET_EXHAUSTED = "budget_exhausted"
    """The method asked for more events than the budget holds before it had an estimate."""
    SIMULATOR_ERROR = "simulator_error"
    """The task's simulator, summary or floor raised, or returned something of the wrong shape, type or value."""
    OUTSIDE_SUPPORT = "outside_support"
    """The method asked for events at parameters where the simulator is not defined."""
    METHOD_ERROR = "method_error"
    """The method raised."""
    INVALID_ESTIMATE = "invalid_estimate"
    """The method returned something that is not a finite estimate within the support."""
    CRASHED = "crashed"
    """The worker process ended twice in this cell: killed, by a fault in compiled code, or by itself."""
    TIMED_OUT = "timed_out"
    """The cell took longer than its limit of time, and its worker process was ended."""
    OUT_OF_MEMORY = "out_of_memory"
    """The worker process took more memory than the limit of a cell, and was ended."""
    DOUBTFUL = "doubtful"
    """An estimate was made within the budget, and the method does not vouch for it; the message says why."""


ESTIMATED = (Status.OK, Status.DOUBTFUL)
"""The outcomes with an estimate, which is scored: a doubtful one may be as good as any, and counts as it is."""
LOST = (Status.CRASHED, Status.TIMED_OUT, Status.OUT_OF_MEMORY)
"""The worker process was lost, and with it how far the cell was."""


def reason(record: dict[str, Any]) -> str:
    """Status and message of a cell that failed, in a line."""
    return f"{record['status']}: {' '.join(record['message'].split()) or 'no message'}"
