"""The paper's box plots (Figure 4): squared error of each method, one panel per task, with the floor drawn in."""

from typing import Any

import pandas as pd
import seaborn as sns
from matplotlib.figure import Figure

from avobench.bench.store.frame import labels, to_frame
from avobench.bench.store.status import ESTIMATED
from avobench.reports.quantities import comparable
from avobench.reports.style import FLOOR, METHOD_ORDER, TASK_ORDER, colours, ordered, panels


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure has one panel per task, and the table one row per box.

    Boxes show quartiles, whiskers reach to the extreme points, every cell is a point. The dashed line is the median
    floor over the targets shown and the band spans their floors. A panel shows the targets that all of its methods
    have, so that the boxes of an unfinished sweep compare like with like; all targets where there are none in common.
    Cells that are not `ok` have no squared error; their number stands below the method's name.
    """
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    frame = comparable(frame)
    return _figure(frame), numbers(frame)


def numbers(frame: pd.DataFrame) -> pd.DataFrame:
    rows = []
    for (task, method), cells in frame.groupby(["task", "method"], sort=False):
        errors, floors = cells["squared_error"].dropna(), cells["floor"]
        quartiles = errors.quantile([0, 0.25, 0.5, 0.75, 1]).tolist()
        rows.append(
            {
                "task": task,
                "method": method,
                "targets": cells["target"].nunique(),
                "cells": len(cells),
                "failed": int((~cells["status"].isin(ESTIMATED)).sum()),
                **dict(zip(("min", "lower_quartile", "median", "upper_quartile", "max"), quartiles, strict=True)),
                "mean": errors.mean(),
                "median_floor": floors.median(),
                "median_error_over_floor": (errors / floors).median(),
            }
        )
    return pd.DataFrame(rows)


def _figure(frame: pd.DataFrame) -> Figure:
    tasks = ordered(frame["task"], TASK_ORDER)
    methods = ordered(frame["method"], METHOD_ORDER)
    figure, axes = panels(tasks, size=(3.6, 2.7))
    for axis, task in zip(axes, tasks, strict=True):
        cells = frame[frame["task"] == task]
        _panel(axis, cells, methods, colours(methods))
        num_targets = cells["target"].nunique()
        axis.set_title(f"{task}: {num_targets} target{'s' * (num_targets > 1)}")
    return figure


def _panel(axis: Any, cells: pd.DataFrame, methods: list[str], colours: dict[str, Any]) -> None:
    shown = [method for method in methods if (cells["method"] == method).any()]
    common = {"data": cells, "x": "method", "y": "squared_error", "order": shown, "ax": axis}
    if cells["squared_error"].notna().any():  # seaborn cannot draw a panel without a single value
        sns.boxplot(
            **common, hue="method", palette=colours, whis=(0, 100), width=0.6, linewidth=0.9, saturation=1, legend=False
        )
        sns.stripplot(**common, color="0.15", size=2.5, jitter=0.15)
    floors = cells.drop_duplicates("target")["floor"].dropna()
    if len(floors):
        axis.axhspan(floors.min(), floors.max(), color=FLOOR, alpha=0.2, lw=0)
        axis.axhline(floors.median(), color=FLOOR, ls="--", lw=1)
        beside = {"xycoords": ("axes fraction", "data"), "ha": "left", "va": "center", "annotation_clip": False}
        axis.annotate("floor", (1.01, floors.median()), fontsize="small", **beside)
    axis.set_yscale("log")
    axis.set_xlabel("")
    axis.set_ylabel(r"squared error $\|\hat\theta - \theta^*\|^2$")
    ticks = []
    for method in shown:
        status = cells.loc[cells["method"] == method, "status"]
        failed = int((~status.isin(ESTIMATED)).sum())
        name = method.replace(" ", "\n")
        ticks.append(f"{name}\n{len(status) - failed} cells" + f", {failed} failed" * bool(failed))
    axis.set_xticks(range(len(shown)), ticks, fontsize="small")
