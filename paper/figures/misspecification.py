"""The width of AVO's proposal against a hidden effect, beside the diagnosis, of the study `misspecification`."""

from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from avobench.reports.style import FLOOR, MARKERS, PALETTE, panels
from paper.studies.misspecification import TASKS

LEAST = 1e-300
"""Below this a p-value is drawn and printed as if it were this."""
LINEAR = 0.01
"""Strength up to which the axis of the strengths is linear, since the first is none."""


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """The medians of the one record of the study, to be read."""
    numbers = medians(records[0])
    numbers["p_value"] = [f"< {LEAST:g}" if p < LEAST else f"{p:.2g}" for p in numbers["p_value"]]
    return numbers


def medians(record: dict[str, Any]) -> pd.DataFrame:
    """One row per task and strength: medians over the repetitions of the proposal's width and of the p-value."""
    runs = pd.DataFrame(record["runs"])
    runs["width"] = [sum(width) / len(width) for width in runs["width"]]
    runs["task"] = pd.Categorical(runs["task"], TASKS)
    grouped = runs.groupby(["task", "strength"], observed=True, dropna=False)
    told = {"runs": ("width", "size"), "width": ("width", "median"), "p_value": ("p_value", "median")}
    return grouped.agg(**told).reset_index()


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure, widths above and p-values below, one column per task, and its numbers."""
    (record,) = records
    runs = pd.DataFrame(record["runs"])
    tasks = sorted(runs["task"].unique(), key=TASKS.index)
    figure, axes = panels([f"{task}: {what}" for what in ("the proposal", "the diagnosis") for task in tasks])
    for column, task in enumerate(tasks):
        of_task, (above, below) = runs[runs["task"] == task], axes[column :: len(tasks)]
        widths = of_task.explode("width")
        above.plot(widths["strength"], widths["width"].astype(float), MARKERS[0], color=PALETTE[0], ms=4, alpha=0.6)
        ends = [of_task["strength"].min(), of_task["strength"].max()]
        above.plot(ends, ends, color=FLOOR, ls="--", lw=1.2, label="hidden width")
        above.set(ylabel="std / prior's std")
        above.set_yscale("symlog", linthresh=LINEAR)
        above.legend(loc="lower right")
        below.plot(
            of_task["strength"],
            of_task["p_value"].clip(lower=LEAST),
            MARKERS[1],
            color=PALETTE[1],
            ms=4,
            alpha=0.6,
            clip_on=False,
        )
        below.axhline(0.05, color=FLOOR, ls="--", lw=1.2, label="0.05")
        below.set(ylabel="p-value", yscale="log", ylim=(of_task["p_value"].clip(lower=LEAST).min() / 10, 1))
        below.yaxis.set_major_locator(LogLocator(10.0 ** (100 if of_task["p_value"].min() < 1e-100 else 10)))
        below.yaxis.set_minor_locator(NullLocator())
        below.legend(loc="lower left")
        for axis in (above, below):
            axis.set_xscale("symlog", linthresh=LINEAR)
            axis.set(xlabel="hidden std / prior's std", xlim=(-LINEAR / 5, 1.5 * ends[1]))
    return figure, medians(record)
