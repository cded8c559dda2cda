"""The efficiency of each method: the squared error against the simulations used so far."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avobench.bench.store.status import ESTIMATED
from avobench.reports.quantities import comparable, labelled, task_of
from avobench.reports.style import FLOOR, by_task, colours
from avobench.tasks.errors import StoreError

NUM_POINTS = 24
"""Numbers of simulations at which the traces are read, from 1/160 of the budget to all of it."""


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure has one panel per task, and the table one row per point of a line.

    A line is the median over the cells of the squared error that the estimate of that moment has; the band is its
    quartiles. It begins where all cells have an estimate. The dashed line is the floor with as many simulations. The
    panel of a task whose cells all failed says so. Raises StoreError where no cell has an estimate.
    """
    frame = labelled(records)
    table = pd.concat([numbers(cells) for _, cells in comparable(frame).groupby("task", sort=False)])
    if table.empty:
        raise StoreError("no cell has an estimate to draw")
    return by_task(table, frame["task"], _panel), table


def numbers(cells: pd.DataFrame) -> pd.DataFrame:
    """Quartiles of the squared error and the floor, for the cells of one task, a row per method and simulations.

    The floor, a median over targets, is missing for a task that is not registered here.
    """
    budget = cells["budget"].max()
    grid = np.unique(np.geomspace(budget / 160, budget, NUM_POINTS).round().astype(int))
    floors = np.median([_floor(record, grid) for record in cells.drop_duplicates("target")["record"]], axis=0)
    frames = []
    for method, of_method in cells.groupby("method", sort=False):
        errors = np.array([errors_at(record, grid) for record in of_method["record"] if record["status"] in ESTIMATED])
        if not len(errors):
            continue
        begun = np.isfinite(errors).all(axis=0)
        quartiles = np.quantile(errors[:, begun], [0.25, 0.5, 0.75], axis=0)
        names = ("lower_quartile", "median", "upper_quartile")
        numbers = {"simulations": grid[begun], **dict(zip(names, quartiles, strict=True)), "floor": floors[begun]}
        frames.append(
            pd.DataFrame({"task": of_method["task"].iloc[0], "method": method, "cells": len(errors), **numbers})
        )
    return pd.concat(frames) if frames else pd.DataFrame()


def errors_at(record: dict[str, Any], simulations: NDArray[np.int64]) -> NDArray[np.float64]:
    """Squared error of the last estimate made with at most so many simulations, NaN before the first: (n,) -> (n,).

    The last of all is the estimate itself, which need not be the last point of the trace.
    """
    trace = [*(record["trace"] or []), {"simulations": record["simulations_used"], "theta": record["theta_hat"]}]
    theta = np.array([point["theta"] for point in trace], float).reshape(len(trace), -1)
    errors = ((theta - record["theta_true"]) ** 2).sum(axis=1)
    last = np.searchsorted([point["simulations"] for point in trace], simulations, side="right")
    return np.concatenate([[np.nan], errors])[last]


def _floor(record: dict[str, Any], simulations: NDArray[np.int64]) -> NDArray[np.float64]:
    task = task_of(record)
    if task is None:
        return np.full(len(simulations), np.nan)
    theta = np.array(record["theta_true"])
    return np.array([task.floor(theta, record["num_observations"], int(n)) for n in simulations])


def _panel(axis: Axes, table: pd.DataFrame, methods: list[str]) -> None:
    for method in methods:
        curve = table[table["method"] == method]
        if curve.empty:
            continue
        colour = colours(methods)[method]
        axis.plot(curve["simulations"], curve["median"], color=colour, label=method)
        axis.fill_between(
            curve["simulations"], curve["lower_quartile"], curve["upper_quartile"], color=colour, alpha=0.15
        )
        axis.plot(curve["simulations"].iloc[-1], curve["median"].iloc[-1], "o", ms=4, color=colour)
    floor = table.drop_duplicates("simulations").sort_values("simulations")
    axis.plot(floor["simulations"], floor["floor"], color=FLOOR, ls="--", lw=1.2, label="floor")
    axis.set(xscale="log", yscale="log", xlabel="simulated events", ylabel="squared error")
