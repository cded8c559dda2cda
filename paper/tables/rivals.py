"""`avo` beside each rival at its best: `python -m paper.tables.rivals`.

A row for each answer of a method on a task: the estimate and, where it has a posterior with another mean, that mean.
`targets` says of how many targets a row is; a test takes those that both have. The inefficiency is the median squared
error over the floor in units of an efficient estimator's; on weinberg, where the events determine c alone, it is the
mean squared error over that of the ideal posterior mean. `avo ahead` is the p-value of the paired test of
`avobench.reports.quantities.ahead`.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from avobench.bench.store.store import Store
from avobench.reports.quantities import ahead, by_mean, labelled, task_of
from avobench.reports.style import METHOD_ORDER, TASK_ORDER, ordered
from paper.tables.targets import (
    METHOD,
    beside_ideal,
    in_units_of_the_best,
    median,
    ratio_of_means,
    told_interval,
    worst,
)

STORES = tuple(map(Path, ("results/reference", "results/rivals", "results/smm", "results/plain")))


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row an answer. Records of tasks that are not registered here are left out."""
    frame = labelled([record for record in records if task_of(record) is not None])
    return pd.DataFrame([row for task in ordered(frame["task"], TASK_ORDER) for row in _rows(task, frame)])


def _rows(task: str, frame: pd.DataFrame) -> Iterator[dict[str, Any]]:
    cells = frame[frame["task"] == task]
    own = cells[cells["method"] == METHOD]
    values, statistic = (beside_ideal, ratio_of_means) if task == "weinberg" else (in_units_of_the_best, median)
    for method in ordered(cells["method"], METHOD_ORDER):
        estimates = cells[cells["method"] == method]
        means = by_mean(estimates)
        other = (estimates["spread_of"] == "posterior").any() and not means["ratio"].equals(estimates["ratio"])
        for answer, found in (("estimate", estimates), ("mean", means))[: 1 + other]:
            measured = values(found)
            yield {
                "task": task,
                "method": method,
                "answer": answer,
                "targets": found["target"].nunique(),
                "inefficiency": statistic(measured),
                "95 %": told_interval(measured, found["target"], statistic),
                "worst run / floor": worst(found["ratio"].to_numpy()),
                "seconds": found["seconds"].mean(),
                "avo ahead": "-" if method == METHOD else f"p = {ahead(own, found):.2g}",
            }


def format_table(stores: tuple[Path, ...] = STORES) -> str:
    """`table` of results folders, to be read."""
    records = [record for store in stores for record in Store(store).read_all()]
    return table(records).to_string(index=False, float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
