"""Where the time of a sweep goes, from its records: `make bench-cost`."""

import sys
from pathlib import Path
from typing import Any

import pandas as pd

from avobench.bench.store.frame import labels, to_frame
from avobench.bench.store.store import Store
from avobench.tasks.contract import NUM_TARGETS

LARGE = 100
"""Cells from which a sweep has its own line."""
PARTS = ("observation", "simulator", "method", "harness")


def cost_table(store: Store) -> pd.DataFrame:
    """Mean seconds of a cell and peak memory of its worker, one row per task and method."""
    records = store.read_all()
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    groups = frame.groupby(["task", "method"])
    columns = {f"{part} [s]": groups[f"{part}_seconds"].mean() for part in PARTS}
    return pd.DataFrame({"cells": groups.size(), **columns, "peak memory [MiB]": groups["peak_memory_mib"].max()})


def harness_share(store: Store) -> float:
    """Share of all processor time spent that is neither observation, simulator nor method.

    In the workers it is what the records call harness; in the process that leads the sweep, its own processor time
    (with one job the two are one process, whose time outside of the cells is wall time less that of the cells).
    """
    inside = outside = 0.0
    for sweep in _timed(store):
        alone = sweep["jobs"] == 1 and sweep.get("backend", "local") != "dask"
        inside += sweep["cell_seconds"]
        outside += sweep["wall_seconds"] - sweep["cell_seconds"] if alone else sweep["cpu_seconds"]
    frame = to_frame(store.read_all())
    of_cells = frame["harness_seconds"].sum() / sum(frame[f"{part}_seconds"].sum() for part in PARTS)
    return (outside + of_cells * inside) / (outside + inside)


def _timed(store: Store) -> list[dict[str, Any]]:
    """The sweeps that wrote down what their cells took. A cell made anew counts in each of its sweeps."""
    return [sweep for sweep in store.sweeps() if "cell_seconds" in sweep]


def format_cost(store: Store) -> str:
    """The cost table as text, and below it what the harness adds."""
    table, timed = cost_table(store), _timed(store)
    busy = sum(sweep["cell_seconds"] for sweep in timed) / sum(sweep["wall_seconds"] * sweep["jobs"] for sweep in timed)
    target = sum(table[f"{part} [s]"].sum() for part in PARTS) / 60
    lines = [
        table.reset_index().to_string(index=False, float_format=lambda value: f"{value:.4g}"),
        f"\none target of every task with every method: {target:.0f} core-minutes; "
        f"all {NUM_TARGETS}: {NUM_TARGETS * target / 60:.1f} core-hours",
        f"harness: {harness_share(store):.2%} of the processor time of all sweeps",
        f"workers were in a cell for {busy:.1%} of the time; the rest is starting them and waiting for the last cell\n",
    ]
    for sweep in timed:
        if sweep["cells"] >= LARGE:
            minutes = sweep["wall_seconds"] / 60
            lines.append(
                f"{sweep['cells']} cells with {sweep['jobs']} jobs in {minutes:.0f} minutes: {sweep['command']}"
            )
    return "\n".join(lines)


if __name__ == "__main__":
    print(format_cost(Store(Path(sys.argv[1] if sys.argv[1:] else "results/reference"))))
