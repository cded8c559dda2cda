"""Where the time of a sweep goes, from its records: `make bench-cost`."""

import sys
from pathlib import Path

import pandas as pd

from avobench.bench.store import Store, labels, to_frame
from avobench.tasks.base import NUM_TARGETS

PARTS = ("observation", "simulator", "method", "harness")


def cost_table(store: Store) -> pd.DataFrame:
    """Mean seconds of a cell and peak memory of its worker, a row a task and method."""
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
    frame = to_frame(store.read_all())
    work = sum(frame[f"{part}_seconds"].sum() for part in PARTS[:-1])
    harness = frame["harness_seconds"].sum()
    for sweep in store.sweeps():
        alone = sweep["jobs"] == 1 and sweep.get("backend", "local") != "dask"
        harness += sweep["wall_seconds"] - sweep["cell_seconds"] if alone else sweep["cpu_seconds"]
    return harness / (work + harness)


def format_cost(store: Store) -> str:
    """The cost table as text, and below it what the harness adds."""
    table = cost_table(store).reset_index().to_string(index=False, float_format=lambda value: f"{value:.4g}")
    busy = sum(to_frame(store.read_all())[f"{part}_seconds"].sum() for part in PARTS)
    available = sum(sweep["wall_seconds"] * sweep["jobs"] for sweep in store.sweeps())
    target = sum(cost_table(store)[f"{part} [s]"].sum() for part in PARTS) / 60
    return "\n".join(
        [
            table,
            "",
            f"one target of every task with every method: {target:.0f} core-minutes; "
            f"all {NUM_TARGETS}: {NUM_TARGETS * target / 60:.1f} core-hours",
            f"harness: {harness_share(store):.2%} of the processor time of all sweeps",
            f"workers were in a cell for {busy / available:.1%} of the time; "
            "the rest is starting them and waiting for the last cell",
        ]
    )


if __name__ == "__main__":
    print(format_cost(Store(Path(sys.argv[1] if sys.argv[1:] else "results/reference"))))
