"""The paper's Figure 2, from the study `detector`: average response and single events at two offsets."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from avobench.tasks.alignment import MAX_ETA, NUM_COLUMNS, NUM_ROWS

EXTENT = (0, 2 * np.pi, -MAX_ETA, MAX_ETA)


def numbers(record: dict[str, Any]) -> pd.DataFrame:
    """One row per cell and theta: its row in eta and column in phi, the mean response, and the single events' hits."""
    frames = []
    for response in record["responses"]:
        frame = pd.DataFrame(np.indices((NUM_ROWS, NUM_COLUMNS)).reshape(2, -1).T, columns=["row", "column"])
        frame.insert(0, "theta", response["theta"])
        frame["mean"] = response["mean"]
        for number, hits in enumerate(response["events"]):
            frame[f"event_{number}"] = frame.index.isin(hits).astype(int)
        frames.append(frame)
    return pd.concat(frames)


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure and its numbers, of the one record of the study."""
    (record,) = records
    table = numbers(record)
    names = ["mean", *(name for name in table if name.startswith("event_"))]
    figure = Figure(figsize=(7.2, 3.9), layout="constrained")
    axes = figure.subplots(len(record["responses"]), len(names), sharex=True, sharey=True)
    for row, (theta, cells) in zip(axes, table.groupby("theta"), strict=True):
        for axis, name in zip(row, names, strict=True):
            image = cells[name].to_numpy().reshape(NUM_ROWS, NUM_COLUMNS)
            look = {"cmap": "viridis", "vmin": 0, "vmax": table["mean"].max()} if name == "mean" else {"cmap": "Greys"}
            axis.grid(False)
            axis.imshow(image, origin="lower", extent=EXTENT, aspect="auto", interpolation="nearest", **look)
        row[0].set_ylabel(rf"$\theta = {theta:g}$ mm,  $\eta$")
    for axis, name in zip(axes[0], names, strict=True):
        axis.set_title("average" if name == "mean" else f"event {int(name[6:]) + 1}")
    bar = figure.colorbar(axes[0, 0].images[0], ax=axes[:, 0], location="left", aspect=40)
    bar.set_label(f"share of {record['num_events']:,} events that hit the cell".replace(",", " "))
    for axis in axes[-1]:
        axis.set(xlabel=r"$\phi$", xticks=(0, np.pi, 2 * np.pi), xticklabels=("0", "π", "2π"))
    return figure, table
