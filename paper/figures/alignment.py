"""The paper's Figure 3, from the study `alignment`: the offset of the detector found at theta* = 1 mm."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avobench.bench.store.status import Status
from avobench.reports.style import METHOD_COLOURS, TRUTH
from avobench.tasks.errors import StoreError
from paper.proposals import convergence, density

THETA = np.linspace(-3, 3, 301)


def chosen(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The records of the study `alignment`, by repetition; raises StoreError when there are none."""
    found = [record for record in records if record["task"] == "alignment-example" and record["status"] == Status.OK]
    if not found:
        raise StoreError("there are no such records; `python -m paper.study alignment` makes them")
    return sorted(found, key=lambda record: record["repetition"])


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure and its numbers: each run has a line of its own."""
    records = chosen(records)
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.subplot_mosaic([["proposal", "proposal"], ["distance", "loss"]])
    rows = []

    def line(panel: str, curve: str, repetition: int, x: NDArray, y: NDArray, **look: Any) -> None:
        axes[panel].plot(x, y, lw=1.2, **look)
        rows.append(pd.DataFrame({"panel": panel, "curve": curve, "repetition": repetition, "x": x, "y": y}))

    true = records[0]["theta_true"][0]
    line("proposal", "before", 0, THETA, density(records[0], THETA, final=False), color=TRUTH, ls=":", label="before")
    look: dict[str, Any] = {"color": METHOD_COLOURS["avo-paper"], "alpha": 0.7}
    for record in records:
        repetition, curve = record["repetition"], convergence(record)
        after = density(record, THETA, final=True)
        label = None if repetition else f"after, {len(records)} runs"
        line("proposal", "after", repetition, THETA, after, label=label, **look)
        line("distance", "after", repetition, curve["simulations"], curve["distance"], **look)
        line("loss", "after", repetition, curve["simulations"], curve["loss"], **look)
    axes["proposal"].axvline(true, color=TRUTH, lw=1)
    axes["proposal"].annotate(r"$\theta^*$", (true, 0), (4, 3), textcoords="offset points")
    axes["proposal"].set(xlabel=r"$\theta$ [mm]", ylabel=r"$q(\theta\,|\,\psi)$ [1/mm]")
    axes["proposal"].legend()
    axes["distance"].set(xlabel="simulations", ylabel=r"$|\theta^* - $mean of $q|$ [mm]", ylim=(0, None))
    axes["loss"].set(xlabel="simulations", ylabel=r"$-\log q(\theta^*\,|\,\psi)$")
    return figure, pd.concat(rows)
