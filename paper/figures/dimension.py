"""Inefficiency and seconds against the number of parameters: figure and table of the experiment `dimension`."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from avobench.reports.quantities import labelled, task_of
from avobench.reports.style import FLOOR, MARKERS, METHOD_ORDER, colours, legend_below, note, ordered, panels
from avobench.tasks import Task
from avobench.tasks.errors import StoreError
from paper.experiments import DETECTOR, DIMENSIONS, FAMILIES
from paper.quantities import WORST_RUN, efficient_median
from paper.tasks import Means32, Warped32

WHAT = {"warped": "means say little", "means": "means say all"}
"""What the mean of the events says about the parameters in each family of tasks."""
SPAN = 0.2
"""Share of the number of parameters over which the marks of the methods are spread."""


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a family of tasks, number of parameters and method; empty without records of these tasks."""
    families = (*FAMILIES, DETECTOR.rpartition("-")[0])
    studied = [record for record in records if _studied(record["task"]) and _task_of(record)]
    if not studied:
        return pd.DataFrame()
    frame = labelled(studied)
    frame[["family", "p"]] = frame["task"].str.rsplit("-", n=1, expand=True)
    frame["family"] = pd.Categorical(frame["family"], families)
    frame["method"] = pd.Categorical(frame["method"], ordered(frame["method"], METHOD_ORDER))
    rows = []
    for (family, p, method), cells in frame.astype({"p": int}).groupby(
        ["family", "p", "method"], observed=True, dropna=False
    ):
        ratios = cells["ratio"].to_numpy()
        rows.append(
            {
                "family": family,
                "parameters": p,
                "method": method,
                "targets": cells["target"].nunique(),
                "inefficiency": np.median(ratios) / efficient_median(_task_of(cells["record"].iloc[0]).floor_shares),
                "worst run / floor": ratios.max(),
                f"above {WORST_RUN:g}": int((ratios > WORST_RUN).sum()),
                "of these ok": int(((ratios > WORST_RUN) & (cells["status"] == "ok")).sum()),
                "seconds": cells["seconds"].mean(),
            }
        )
    return pd.DataFrame(rows)


def _task_of(record: dict[str, Any]) -> Task | type[Task] | None:
    """The task of a record, also where it is not registered."""
    return {each.name: each for each in (Warped32, Means32)}.get(record["task"]) or task_of(record)


def _studied(task: str) -> bool:
    return task == DETECTOR or task.rpartition("-")[0] in FAMILIES


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure, a panel a family and one of the seconds, and its numbers.

    Raises StoreError where there is no record of the study.
    """
    numbers = table(records)
    if numbers.empty:
        raise StoreError("there is no record of the tasks of this study: run `python -m paper.study dimension` first")
    methods = ordered(numbers["method"], METHOD_ORDER)
    figure, axes = panels([*(f"{family}: {WHAT[family]}" for family in FAMILIES), "seconds of a run"], columns=3)
    for axis, family in zip(axes, FAMILIES, strict=False):
        _panel(axis, numbers[numbers["family"] == family], methods, "inefficiency")
        axis.axhline(1, color=FLOOR, ls="--", lw=1.2, label="limit")
    _panel(axes[-1], numbers[numbers["family"] == FAMILIES[0]], methods, "seconds")
    legend_below(figure, axes, (*methods, "limit"))
    return figure, numbers


def _panel(axis: Axes, rows: pd.DataFrame, methods: list[str], what: str) -> None:
    if rows.empty:
        note(axis, "no records")
        return
    for i, method in enumerate(methods):
        curve = rows[(rows["method"] == method) & np.isfinite(rows[what])]
        x = curve["parameters"] * (1 + SPAN * ((i + 0.5) / len(methods) - 0.5))
        axis.plot(x, curve[what], color=colours(methods)[method], marker=MARKERS[i % len(MARKERS)], ms=5, label=method)
    axis.set(xscale="log", yscale="log", xlabel="parameters", ylabel=what, xticks=DIMENSIONS, xticklabels=DIMENSIONS)
    axis.xaxis.set_minor_locator(NullLocator())
