"""Squared errors of each method against the share of outliers: figure and table of the study `contamination`."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from avobench.reports.style import MARKERS, PALETTE, legend_below, panels
from paper.studies.contamination import METHODS, ROWS_OF_EFFECTS, SHARES, contaminated

LEAST = 0.01
"""Share up to which the axis is linear, since the first share is none."""


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task, share and method: medians over the targets of the one record of the study.

    The squared errors are summed over what is identifiable, as are those to the minimiser of the divergence. A pull is
    the difference from that minimiser in quoted errors, of each parameter; where parameters are open there is none.
    """
    tasks = {name: of.task for name, of in contaminated().items()}
    rows = []
    latest = {tuple(run[name] for name in ("task", "share", "target", "row")): run for run in records[0]["runs"]}
    for run in latest.values():  # of a method that changed the last one counts
        if run["task"] not in tasks:  # with an effect of the catalogue
            continue
        estimate, clean, minimiser = (np.array(run[name])[None] for name in ("estimate", "theta", "minimiser"))
        known = tasks[run["task"]].identifiable
        pulls = np.abs(estimate - minimiser)[0] / run["error"] if run["error"] else np.array([np.nan])
        if known(clean).shape != clean.shape:
            pulls = np.array([np.nan])
        rows.append(
            {name: run[name] for name in ("task", "share", "row", "seconds")}
            | {"to theta": ((known(estimate) - known(clean)) ** 2).sum()}
            | {"to minimiser": ((known(estimate) - known(minimiser)) ** 2).sum()}
            | {"pull": np.median(pulls), "worst pull": pulls.max(), "doubtful": bool(run["doubt"])}
        )
    frame = pd.DataFrame(rows)
    frame["task"], frame["row"] = pd.Categorical(frame["task"], tasks), pd.Categorical(frame["row"], METHODS)
    grouped = frame.groupby(["task", "share", "row"], observed=True, dropna=False)
    medians = dict.fromkeys(("to theta", "to minimiser", "pull", "seconds"), "median")
    numbers = grouped.agg({**medians, "worst pull": "max", "doubtful": "sum"})
    numbers.insert(0, "targets", grouped.size())
    return numbers.reset_index().rename(columns={"row": "method"}).astype({"task": str, "method": str})


def compared(records: list[dict[str, Any]], value: str = "to minimiser") -> pd.DataFrame:
    """A row a task and share, a column a method that has any: one column of `table`.

    A D stands behind a number where the method doubts the fit, on one target or more.
    """
    numbers = table(records).dropna(subset=value)
    numbers[value] = numbers[value].map("{:.3g}".format) + np.where(numbers["doubtful"] > 0, " D", "  ")
    wide = numbers.pivot(index=["task", "share"], columns="method", values=value)
    wide = wide.reindex(index=numbers[["task", "share"]].drop_duplicates().apply(tuple, axis=1))
    shown = [method for method in METHODS if method in wide]
    return wide[shown].rename_axis(columns=None).reset_index()


BEYOND = 4.0
"""Quoted errors from the minimiser beyond which a fit should be doubted."""


def effects(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a simulator and method, of the runs in which the simulator lacks an effect of the catalogue."""
    runs = _pulls([run for run in records[0]["runs"] if ": " in run["task"]])
    simulators = runs["task"].str.partition(": ")[0]
    runs["simulator"] = pd.Categorical(simulators, simulators.unique())
    runs["row"] = pd.Categorical(runs["row"], ROWS_OF_EFFECTS)
    return _counted(runs, ["simulator", "row"], "effects")


def outliers(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a method that quotes errors, of the runs with outliers or another law where no parameter is open."""
    tasks = {name: of.task for name, of in contaminated().items()}
    known = [name for name, task in tasks.items() if len(task.identifiable(task.targets(1))[0]) == task.prior.dim]
    runs = _pulls([run for run in records[0]["runs"] if run["task"] in known and run["share"] > 0 and run["error"]])
    runs["row"] = pd.Categorical(runs["row"], [row for row in METHODS if row in set(runs["row"])])
    return _counted(runs, ["row"], "fits")


def _pulls(runs: list[dict[str, Any]]) -> pd.DataFrame:
    """The runs, of a method that changed the last one, with `pull`: the largest difference in quoted errors."""
    frame = pd.DataFrame(runs).drop_duplicates(["task", "share", "target", "row"], keep="last")
    off = [np.abs(np.subtract(*pair)) for pair in zip(frame["estimate"], frame["minimiser"], strict=True)]
    frame["pull"] = [np.max(each / error) for each, error in zip(off, frame["error"], strict=True)]
    return frame


def _counted(runs: pd.DataFrame, by: list[str], size: str) -> pd.DataFrame:
    """Of each group the median and largest pull, the mean seconds, and how many are far off or in doubt.

    `beyond 4` counts the fits that are farther off than BEYOND, and `undoubted` those of them that carry no doubt.
    """
    runs["doubted"] = runs["doubt"] != ""
    runs["far"] = runs["pull"] > BEYOND
    runs["undoubted"] = runs["far"] & ~runs["doubted"]
    told = {size: ("pull", "size"), "median pull": ("pull", "median"), "worst pull": ("pull", "max")}
    told |= {"beyond 4": ("far", "sum"), "undoubted": ("undoubted", "sum"), "doubted": ("doubted", "sum")}
    numbers = runs.groupby(by, observed=True).agg(**told, seconds=("seconds", "mean"))
    return numbers.reset_index().rename(columns={"row": "method"})


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure, a panel a task, and its numbers."""
    numbers = table(records)
    tasks = [name for name, of in contaminated().items() if of.shares == SHARES and (numbers["task"] == name).any()]
    figure, axes = panels(tasks)
    for name, axis in zip(tasks, axes, strict=False):
        for i, method in enumerate(METHODS):
            of = numbers[(numbers["task"] == name) & (numbers["method"] == method)]
            if len(of):
                style = {"color": PALETTE[i % len(PALETTE)], "marker": MARKERS[i % len(MARKERS)], "ms": 4, "lw": 1}
                line = "--" if i >= len(PALETTE) else "-"  # where colours come again
                axis.plot(of["share"], of["to theta"], label=method, ls=line, **style)
        axis.set_xscale("symlog", linthresh=LEAST)
        axis.set(yscale="log", xlabel="share of outliers", xlim=(-LEAST / 5, 0.3))
        axis.set_ylabel("squared error\nto the clean theta")
    legend_below(figure, axes, METHODS, columns=3)
    return figure, numbers
