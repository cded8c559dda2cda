"""What a record says of a cell: the outcomes that there are, and a record of which nothing more is known."""

from enum import StrEnum
from typing import Any

from avobench.bench.cell import Cell
from avobench.bench.versions import versions

SCHEMA_VERSION = 1
"""Of records; raised when a field changes its meaning."""


class Status(StrEnum):
    """Outcome of a cell; `ok` exactly when an estimate was made within the budget."""

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
    """The worker process died twice in this cell."""


def reason(record: dict[str, Any]) -> str:
    """Status and message of a cell that failed, in a line."""
    return f"{record['status']}: {' '.join(record['message'].split()) or 'no message'}"


def blank_record(cell: Cell, status: Status, message: str) -> dict[str, Any]:
    """A record with every field of the schema, for a cell of which nothing more is known."""
    return {
        "schema_version": SCHEMA_VERSION,
        "id": cell.id,
        **cell.identity,
        "parameter_names": list(cell.build_task().parameter_names),
        "status": str(status),
        "message": message,
        "theta_hat": None,
        "squared_error": None,
        "floor": None,
        "floor_likelihood": None,
        "how": None,
        "spread_of": None,
        "mean": None,
        "std": None,
        "trace": [],
        "simulations_requested": None,
        "simulations_used": None,
        "simulations_discarded": None,
        "simulations_refused": None,
        "observation_seconds": 0.0,
        "simulator_seconds": 0.0,
        "method_seconds": 0.0,
        "harness_seconds": 0.0,
        "peak_memory_mib": None,
        "started": None,
        "versions": versions(),
    }
