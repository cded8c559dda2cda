"""What `avo` and `smm` do on targets that nothing was chosen on: `python -m paper.tables.fresh`.

A row a task and method, from the records of `python -m paper.study fresh`. `mean / floor` is the mean squared error
over the mean floor, on weinberg over the ideal posterior mean's; below 1 is chance. `astray` counts runs above 100
floors, and of these those that the method vouched for. The last columns are coverage (`avobench.reports.coverage`).
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import norm

from avobench.bench.store.store import Store
from avobench.reports.coverage import LEVELS, distances
from avobench.reports.quantities import ideal_errors, labelled
from avobench.reports.style import METHOD_ORDER, TASK_ORDER, ordered
from paper.studies.fresh import TASKS
from paper.tables.targets import WORST_RUN, asymmetry_inefficiency, inefficiency_of

STORE = Path("results/fresh")


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task and method; empty without records of the study."""
    return pd.DataFrame(_rows(labelled([_as_own(record) for record in records])) if records else [])


def _as_own(record: dict[str, Any]) -> dict[str, Any]:
    """The record with the task under whose name its floor and its parameters are known, whose targets it has not."""
    own = {task.name: task.of.name for task in TASKS}
    return {**record, "task": own[record["task"]]} if record["task"] in own else record


def _rows(frame: pd.DataFrame) -> Iterator[dict[str, Any]]:
    for task in ordered(frame["task"], TASK_ORDER):
        for method in ordered(frame[frame["task"] == task]["method"], METHOD_ORDER):
            cells = frame[(frame["task"] == task) & (frame["method"] == method)]
            best = ideal_errors(cells) if task == "weinberg" else cells["floor"].to_numpy(float)
            astray = cells["ratio"] > WORST_RUN
            yield {
                "task": task,
                "method": method,
                "targets": cells["target"].nunique(),
                "inefficiency": asymmetry_inefficiency(cells) if task == "weinberg" else inefficiency_of(cells),
                "mean / floor": cells["squared_error"].mean() / best.mean(),
                "worst": cells["ratio"].max(),
                "astray": int(astray.sum()),
                "ok of these": int((astray & (cells["status"] == "ok")).sum()),
                "doubtful": int((cells["status"] == "doubtful").sum()),
                "seconds": cells["seconds"].mean(),
                **_coverage(cells["record"].tolist()),
            }


def _coverage(records: list[dict[str, Any]]) -> dict[str, str]:
    found = [away for record in records if (away := distances(record)) is not None]
    away = np.concatenate(found) if found else np.empty(0)
    return {
        f"within {level:.0%}": f"{(away <= norm.ppf((1 + level) / 2)).mean():.0%}" if found else "-" for level in LEVELS
    }


def format_table(store: Path = STORE) -> str:
    """`table` of a results folder, to be read."""
    return table(Store(store).read_all()).to_string(index=False, float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
