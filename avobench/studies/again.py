"""Whether the records of a folder come out again: `python -m avobench.studies.again FOLDER TASK METHOD NUMBER`.

The first NUMBER cells of a task and method by their names, as `avobench list` has them, are carried out once more with
the method as it is now. Prints for each the largest difference of the two estimates in the prior's widths: 0 where they
are the same to the last bit, and up to 1e-5 where another processor rounds otherwise.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.cell import Cell
from avobench.bench.store import Store
from avobench.bench.trial import execute
from avobench.tasks.errors import UsageError

GIVEN = ("task", "task_settings", "method", "method_settings", "target", "repetition", "budget", "num_observations")
"""The fields of a record that make its cell, with the seed."""


def table(records: list[dict[str, Any]], task: str, method: str, number: int) -> pd.DataFrame:
    """A row a cell, by repetition and target. Raises UsageError where there is none."""
    chosen = [record for record in records if (record["task"], record["method"]) == (task, method)]
    if not chosen:
        raise UsageError(f"there is no record of {method} on {task}")
    chosen.sort(key=lambda record: (record["repetition"], record["target"]))
    return pd.DataFrame([_row(record) for record in chosen[:number]])


def _row(record: dict[str, Any]) -> dict[str, Any]:
    cell = Cell(*(record[name] for name in GIVEN), record["seed"])
    if cell.id != record["id"]:
        raise UsageError(f"the record of {cell.label} is that of another version: run its sweep again")
    found, width = execute(cell)["theta_hat"], cell.build_task().prior.width
    apart = np.nan if None in (found, record["theta_hat"]) else np.abs(np.subtract(found, record["theta_hat"]) / width)
    return {
        **{name: record[name] for name in ("task", "method", "target", "repetition")},
        "difference": np.max(apart),
    }


def format_table(folder: Path, task: str, method: str, number: int) -> str:
    """`table` of a results folder, to be read."""
    return table(Store(folder).read_all(), task, method, number).to_string(index=False)


if __name__ == "__main__":
    print(format_table(Path(sys.argv[1]), *sys.argv[2:4], int(sys.argv[4])))
