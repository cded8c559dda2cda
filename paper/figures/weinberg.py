"""The paper's Figure 5: on weinberg every method fits the observed density, however far its parameters are."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avobench.bench.cells.streams import observe
from avobench.bench.store.status import ESTIMATED
from avobench.reports.quantities import comparable, labelled, task_of
from avobench.reports.style import METHOD_ORDER, TRUTH, colours, ordered
from avobench.tasks.errors import StoreError

NUM_ROWS = 4
"""Targets that are shown; more make the panels too small to read."""
X = np.linspace(-1, 1, 101)


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure, one row per target and one column per method, and its numbers.

    The first targets that all methods have, in their first repetition. The observed events, a histogram with error bars
    of one standard deviation, are drawn again from the seed in the record. Raises StoreError without such records.
    """
    shown = [record for record in records if record["task"] == "weinberg" and record["status"] in ESTIMATED]
    if not shown:
        raise StoreError("there are no records of weinberg with an estimate to draw")
    cells = labelled(shown)
    cells = comparable(cells[cells["repetition"] == 0])
    methods = ordered(cells["method"], METHOD_ORDER)
    targets = sorted(cells["target"].unique())[:NUM_ROWS]
    figure = Figure(figsize=(1.9 * len(methods) + 0.4, 1.5 * len(targets) + 0.4), layout="constrained")
    axes = figure.subplots(len(targets), len(methods), sharex=True, sharey="row", squeeze=False)
    rows = []
    for row, target in zip(axes, targets, strict=True):
        for axis, method in zip(row, methods, strict=True):
            found = cells[(cells["target"] == target) & (cells["method"] == method)]
            if len(found):
                rows.append(_panel(axis, found.iloc[0]["record"], method, colours(methods)[method]))
        true = ", ".join(f"{value:.2f}" for value in cells[cells["target"] == target].iloc[0]["record"]["theta_true"])
        row[0].set_ylabel(rf"$\theta^* = ({true})$", fontsize="small")
        row[0].set_ylim(bottom=0)
    for axis, method in zip(axes[0], methods, strict=True):
        axis.set_title(method)
    for axis in axes[-1]:
        axis.set_xlabel(r"$\cos A$")
    figure.supylabel("density", fontsize="medium")
    return figure, pd.concat(rows)


def _panel(axis: Axes, record: dict[str, Any], method: str, colour: Any) -> pd.DataFrame:
    task, theta = task_of(record), np.array(record["theta_hat"])
    observed = observe(task, record["target"], record["num_observations"], record["seed"])[:, 0]
    counts, edges = np.histogram(observed, 20, (-1, 1))
    middles, scale = (edges[1:] + edges[:-1]) / 2, len(counts) / 2 / len(observed)
    axis.errorbar(middles, counts * scale, np.sqrt(counts) * scale, fmt=".", ms=3, lw=0.8, color=TRUTH)
    axis.plot(X, task.density(X, theta), color=colour, lw=1.6)
    axis.annotate(
        rf"$\hat\theta = ({theta[0]:.2f}, {theta[1]:.2f})$",
        (0.5, 0.04),
        xycoords="axes fraction",
        ha="center",
        fontsize="small",
    )
    return pd.DataFrame(
        {
            "target": record["target"],
            "method": method,
            "e_beam_hat": theta[0],
            "g_f_hat": theta[1],
            "cos_a": middles,
            "observed_density": counts * scale,
            "observed_std": np.sqrt(counts) * scale,
            "fitted_density": task.density(middles, theta),
        }
    )
