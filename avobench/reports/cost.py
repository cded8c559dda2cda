"""Seconds against squared error: what a better estimate costs."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from avobench.bench.store.status import ESTIMATED
from avobench.reports.quantities import comparable, labelled
from avobench.reports.style import FLOOR, MARKERS, METHOD_ORDER, TASK_ORDER, by_task, colours, ordered

SHAPES = dict(zip(METHOD_ORDER, MARKERS, strict=False))
"""The mark of each of the paper's methods, whichever of them are shown."""


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure has one panel per task, and the table one row per task and method.

    A small mark is a cell: the seconds it took in simulator and method, one thread, and its squared error. The large
    mark is the median of both. The dashed line is the median floor. The panel of a task whose cells all failed says so.
    """
    frame = comparable(labelled(records))
    tasks, methods = ordered(frame["task"], TASK_ORDER), ordered(frame["method"], METHOD_ORDER)
    return by_task(frame[frame["status"].isin(ESTIMATED)], tasks, methods, _panel), numbers(frame)


def numbers(frame: pd.DataFrame) -> pd.DataFrame:
    """One row per task and method: cells, median seconds in simulator and method, median squared error and floor."""
    groups = frame.groupby(["task", "method"], sort=False)
    columns = ["simulator_seconds", "method_seconds", "seconds", "squared_error", "floor"]
    return groups[columns].median().add_prefix("median_").assign(cells=groups.size()).reset_index()


def _panel(axis: Axes, cells: pd.DataFrame, methods: list[str]) -> None:
    for method in methods:
        of_method = cells[cells["method"] == method]
        if of_method.empty:
            continue
        look = {"color": colours(methods)[method], "marker": SHAPES.get(method, "v"), "ls": "", "mew": 0}
        axis.plot(of_method["seconds"], of_method["squared_error"], ms=3, alpha=0.5, **look)
        median = of_method[["seconds", "squared_error"]].median()
        axis.plot(*median, ms=9, **{**look, "mec": "white", "mew": 1}, label=method)
    if cells["floor"].notna().any():
        axis.axhline(cells.drop_duplicates("target")["floor"].median(), color=FLOOR, ls="--", lw=1.2, label="floor")
    axis.set(xscale="log", yscale="log", xlabel="seconds per cell", ylabel="squared error")
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=12))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.xaxis.set_minor_locator(NullLocator())
