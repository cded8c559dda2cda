"""Whether the records of a folder come out again: `python -m paper.studies.again FOLDER TASK METHOD TARGETS`.

The cells of a task, a method and targets, as `avobench run` takes them, are carried out once more with the method as it
is now. Prints for each the largest difference of the two estimates in the prior's widths: 0 where they are the same to
the last bit. Where the records are from another processor, which rounds otherwise, training goes another way, and the
estimates of `avo` were found apart by 1e-4.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.bench.plugins import registry
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import parse_targets
from avobench.tasks.errors import UsageError

GIVEN = ("target", "repetition", "budget", "num_observations", "seed")
"""The fields of a record that make its cell, with its task and method and their settings."""


def table(records: list[dict[str, Any]], task: str, method: str, targets: list[int]) -> pd.DataFrame:
    """A row a cell, by repetition and target. Raises UsageError where there is none."""
    names = registry.build("task", task, {}).name, registry.build("method", method, {}).name
    chosen = [r for r in records if (r["task"], r["method"]) == names and r["target"] in targets]
    if not chosen:
        raise UsageError(f"there is no record of {method} on {task} and these targets")
    chosen.sort(key=lambda record: (record["repetition"], record["target"]))
    return pd.DataFrame([_row(record, task, method) for record in chosen])


def _row(record: dict[str, Any], task: str, method: str) -> dict[str, Any]:
    cell = Cell(task, record["task_settings"], method, record["method_settings"], *(record[name] for name in GIVEN))
    if cell.id != record["id"]:
        raise UsageError(f"the record of {cell.label} is that of another version: run its sweep again")
    found, width = execute(cell)["theta_hat"], cell.build_task().prior.width
    apart = np.nan if None in (found, record["theta_hat"]) else np.abs(np.subtract(found, record["theta_hat"]) / width)
    of = {name: record[name] for name in ("task", "method", "target", "repetition")}
    return {**of, "difference": np.max(apart)}


def format_table(folder: Path, task: str, method: str, targets: str) -> str:
    """`table` of a results folder, to be read."""
    return table(Store(folder).read_all(), task, method, parse_targets(targets)).to_string(index=False)


if __name__ == "__main__":
    print(format_table(Path(sys.argv[1]), *sys.argv[2:5]))
