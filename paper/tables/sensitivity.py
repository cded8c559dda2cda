"""What plain Algorithm 1 came to with each candidate of `python -m paper.study sensitivity`, on development targets.

`python -m paper.tables.sensitivity` prints a row a candidate: the inefficiency on every task, the geometric mean
over tasks, by which one is chosen, the largest share of a run in which the proposal stood exactly still, and seconds a
cell. These are development numbers: the best of several is better by luck, too.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import gmean

from avobench.bench.store.store import Store
from avobench.reports.quantities import still
from paper.studies.sensitivity import CANDIDATES, TASKS, candidate
from paper.tables.tuning import inefficiency

STORE = Path("results/sensitivity")


def table(records: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """A row a candidate, from records by id, in the order of CANDIDATES.

    A candidate that lacks a record has no row.
    """
    rows = []
    for label in CANDIDATES:
        cells = {task: candidate(label, task) for task in TASKS}
        if not all(cell.id in records for own in cells.values() for cell in own):
            continue
        own = {task: [records[cell.id] for cell in cells[task]] for task in TASKS}
        row: dict[str, Any] = {"settings": label, "targets": len(own[TASKS[0]])}
        row |= {task: float(np.median([inefficiency(task, record) for record in own[task]])) for task in TASKS}
        row["geometric mean"] = gmean([row[task] for task in TASKS])
        every = [record for task in TASKS for record in own[task]]
        row["still"] = f"{max(map(still, every)):.0%}"
        row["seconds"] = np.mean([record["simulator_seconds"] + record["method_seconds"] for record in every])
        rows.append(row)
    return pd.DataFrame(rows)


def format_table(store: Path = STORE) -> str:
    """`table` of a results folder, to be read."""
    records = {record["id"]: record for record in Store(store).read_all()}
    return table(records).to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
