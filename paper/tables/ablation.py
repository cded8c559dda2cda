"""What each difference between `avo` and `avo-paper` is worth, from the records of `python -m paper.study ablation`.

`python -m paper.tables.ablation` prints, for avo as it is and with each difference undone, the inefficiency on
every task and, in brackets, the largest ratio of squared error to floor. All rows have the study's targets and
repetitions, so the same observations. On weinberg both are those of c, the one quantity that the events determine.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from avobench.bench.store.store import Store
from avobench.reports.quantities import asymmetry_errors, labelled
from paper.studies.paper import ABLATION_TASKS, ABLATIONS, ablation
from paper.tables.targets import asymmetry_inefficiency, inefficiency_of

STORES = tuple(map(Path, ("results/reference", "results/dimension", "results/ablation")))


def worth(cells: pd.DataFrame, task: str) -> str:
    """Inefficiency and worst ratio of cells of one task, as the table has them."""
    if task == "weinberg":
        return f"{asymmetry_inefficiency(cells):.2g} ({np.max(np.divide(*asymmetry_errors(cells))):.2g})"
    return f"{inefficiency_of(cells):.2g} ({cells['ratio'].max():.2g})"


def table(stores: tuple[Path, ...] = STORES) -> pd.DataFrame:
    """A row a difference, a column a task, of the targets on which every row has all its records; else empty.

    Raises UsageError when there is no such folder.
    """
    records = {record["id"]: record for store in stores for record in Store(store).read_all()}
    rows = {"avo as it is": ({}, ABLATION_TASKS), **ABLATIONS}
    columns = {}
    for task in ABLATION_TASKS:
        cells = {label: ablation(task, settings) for label, (settings, tasks) in rows.items() if task in tasks}
        missing = {cell.target for own in cells.values() for cell in own if cell.id not in records}
        shown = {
            label: labelled([records[cell.id] for cell in own if cell.target not in missing])
            for label, own in cells.items()
            if any(cell.target not in missing for cell in own)
        }
        num_targets = max((own["target"].nunique() for own in shown.values()), default=0)
        columns[f"{task}, {num_targets} targets"] = {label: worth(own, task) for label, own in shown.items()}
    return pd.DataFrame(columns, index=list(rows), dtype=object).fillna("")


if __name__ == "__main__":
    print(table().to_string())
