"""What `avo` and `smm` do on targets that nothing was chosen on: `python -m avobench.reports.fresh`.

A row a task and method, from the records of `avobench study fresh`. `mean / floor` is the mean squared error over the
mean floor, on weinberg over the ideal posterior mean's; below 1 is chance. `astray` counts runs above 100 floors, and
of these those that the method vouched for. The last columns are coverage: how many of the true parameters lie within 1
and within 1.96 quoted standard errors of their estimates, 68 and 95 % where the errors are right.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.bench.store import Store
from avobench.reports.quantities import ideal_errors, labelled
from avobench.reports.style import METHOD_ORDER, TASK_ORDER, ordered
from avobench.reports.targets import WORST_RUN, asymmetry_inefficiency, inefficiency_of
from avobench.studies.fresh import TASKS

STORE = Path("results/fresh")
WITHIN = {"68 %": 1.0, "95 %": 1.96}
"""Quoted standard errors, within which so many of the true parameters should lie."""


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
                **_coverage(pulls(cells["record"].tolist())),
            }


def pulls(records: list[dict[str, Any]]) -> NDArray[np.float64]:
    """Errors over their quoted standard errors, of all parameters of the records that quote them: (n,)."""
    found = [
        np.subtract(record["theta_hat"], record["theta_true"]) / np.array(record["standard_error"], float)
        for record in records
        if record.get("standard_error") is not None
    ]
    return np.abs(np.concatenate(found)) if found else np.empty(0)


def _coverage(distances: NDArray[np.float64]) -> dict[str, str]:
    return {
        f"within {name}": f"{(distances <= most).mean():.0%}" if distances.size else "-"
        for name, most in WITHIN.items()
    }


def format_table(store: Path = STORE) -> str:
    """`table` of a results folder, to be read."""
    return table(Store(store).read_all()).to_string(index=False, float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
