"""What each difference between `avo` and `avo-paper` is worth, from the records of `avobench study ablation`.

`python -m avobench.reports.ablation` prints, for avo as it is and with each difference undone, the inefficiency on
every task and, in brackets, the largest ratio of squared error to floor. All rows have the study's targets and
repetitions, so the same observations. On weinberg both are those of c, the one quantity that the events determine.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from avobench.bench.store import Store
from avobench.bench.study import ABLATION_TASKS, ABLATIONS, ablation
from avobench.reports.quantities import asymmetry_errors, labelled
from avobench.reports.targets import asymmetry_inefficiency, inefficiency_of

STORES = Path("results/reference"), Path("results/ablation")


def worth(cells: pd.DataFrame, task: str) -> str:
    """Inefficiency and worst ratio of cells of one task, as the table has them."""
    if task == "weinberg":
        return f"{asymmetry_inefficiency(cells):.2g} ({np.max(np.divide(*asymmetry_errors(cells))):.2g})"
    return f"{inefficiency_of(cells):.2g} ({cells['ratio'].max():.2g})"


def table(stores: tuple[Path, ...] = STORES) -> pd.DataFrame:
    """A row a difference, a column a task; "-" where it means nothing on the task or a record is missing."""
    records = {record["id"]: record for store in stores for record in Store(store).read_all()}
    rows = []
    for label, (settings, tasks) in {"avo as it is": ({}, ABLATION_TASKS), **ABLATIONS}.items():
        row = {"": label, **dict.fromkeys(ABLATION_TASKS, "-")}
        for task in tasks:
            found = [records.get(cell.id) for cell in ablation(task, settings)]
            if None not in found:
                row[task] = worth(labelled(found), task)
        rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    print(table().to_string(index=False))
