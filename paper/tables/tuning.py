"""What each candidate for a rival's settings came to on development targets, by `python -m paper.study tuning`.

`python -m paper.tables.tuning` prints the inefficiency of every candidate on every task (on weinberg of c, the one
quantity that the events determine), the geometric mean over tasks, by which one is chosen, and its seconds a cell.
These are development numbers: the best of several is better by luck, too.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import gmean

from avobench.bench.store.status import ESTIMATED
from avobench.bench.store.store import Store
from avobench.reports.quantities import efficient_median
from paper.studies.development import TASKS
from paper.studies.tuning import CANDIDATES, candidate

STORE = Path("results/tuning")


def table(records: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """A row a candidate, from records by id, on the targets that every candidate of the method has on every task.

    A method of which no target is complete has no row.
    """
    rows = []
    for method, candidates in CANDIDATES.items():
        for label, settings in candidates.items():
            common = set.intersection(*(_common(method, name, records) for name in TASKS))
            if not common:
                continue
            row: dict[str, Any] = {"method": method, "settings": label, "targets": len(common)}
            seconds, values = [], []
            for name in TASKS:
                own = [records[cell.id] for cell in candidate(method, settings, name) if cell.target in common]
                ratios = [inefficiency(name, record) for record in own]
                row[name] = np.median(ratios)
                values.append(row[name])
                seconds += [record["simulator_seconds"] + record["method_seconds"] for record in own]
            row |= {"geometric mean": gmean(values), "seconds": np.mean(seconds)}
            rows.append(row)
    return pd.DataFrame(rows)


def _common(method: str, task: str, records: dict[str, dict[str, Any]]) -> set[int]:
    """The targets of a task for which every candidate of a method has its record."""
    cells = [cell for settings in CANDIDATES[method].values() for cell in candidate(method, settings, task)]
    return {cell.target for cell in cells} - {cell.target for cell in cells if cell.id not in records}


def inefficiency(name: str, record: dict[str, Any]) -> float:
    """Squared error over its floor, in units of an efficient estimator's median; of a failure it is infinite."""
    if record["status"] not in ESTIMATED:
        return np.inf
    task, true = TASKS[name](), np.array(record["theta_true"])
    if name == "weinberg":
        found, wanted = task.asymmetry(np.array([record["theta_hat"], true]))
        floor = task.asymmetry_floor(true, record["num_observations"], record["budget"])
        return (found - wanted) ** 2 / floor / efficient_median((1.0,))
    return record["squared_error"] / record["floor"] / efficient_median(task.floor_shares)


def format_table(store: Path = STORE) -> str:
    """`table` of a results folder, to be read."""
    records = {record["id"]: record for record in Store(store).read_all()}
    return table(records).to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
