"""Where the time of a sweep goes, from its records, and Pythia's speed against a bare loop: `make bench-cost`."""

import statistics
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from numpy.typing import NDArray

from avobench.bench.budget import MeteredSimulator
from avobench.bench.registry import build
from avobench.bench.store import Store, labels, to_frame
from avobench.tasks.alignment import SETTINGS, Alignment, start_pythia
from avobench.tasks.base import NUM_TARGETS
from avobench.tasks.carl import MIXING

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


def pythia_rates(rounds: int = 9, num_events: int = 4000) -> tuple[list[float], list[float]]:
    """Events a second of processor time of `Alignment.simulate` and of a bare `nextBatch` loop, taken in turns."""
    task, rng = Alignment(), np.random.default_rng(0)
    pythia = start_pythia((*SETTINGS, "Random:seed = 1"))
    theta = np.zeros((num_events, 1))
    task.simulate(theta, rng)
    ours, bare = [], []
    for _ in range(rounds):
        start = time.thread_time()
        for _ in range(num_events // 1000):
            pythia.nextBatch(1000)
        bare.append(num_events / (time.thread_time() - start))
        start = time.thread_time()
        task.simulate(theta, rng)
        ours.append(num_events / (time.thread_time() - start))
    return ours, bare


def bare_poisson(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
    return rng.poisson(np.exp(theta))


def bare_carl(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
    n = len(theta)
    z = np.empty((n, 5))
    z[:, 0], z[:, 1] = rng.normal(theta[:, 0], 1), rng.normal(theta[:, 1], 3)
    left = rng.random(n) < 1 / 2
    z[:, 2] = rng.normal(np.where(left, -2, 2), np.where(left, 1, 1 / 2))
    z[:, 3], z[:, 4] = rng.exponential(1 / 3, n), rng.exponential(2, n)
    return z @ MIXING.T


def bare_weinberg(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
    """Rejection, the other exact way, drawing again what was refused: the density is largest at an end."""
    c = 2 * np.tanh(10 * (2 * theta[:, 0] - 90) / 90) * theta[:, 1]
    x, left = np.empty(len(c)), np.arange(len(c))
    while len(left):
        proposed = rng.uniform(-1, 1, len(left))
        kept = rng.uniform(0, 2 + np.abs(c[left])) < 1 + proposed**2 + c[left] * proposed
        x[left[kept]] = proposed[kept]
        left = left[~kept]
    return x[:, None]


BARE = {"poisson": bare_poisson, "carl": bare_carl, "weinberg": bare_weinberg}
"""What one would write for the same distribution with NumPy alone, without checks."""


def numpy_rates(batch: int, num_events: int = 500_000, rounds: int = 9) -> pd.DataFrame:
    """Events a second of the metered simulator and of bare NumPy, `batch` at a time, by processor time, in turns."""
    rows = []
    for name, bare in BARE.items():
        task, rng = build("task", name, {}), np.random.default_rng(0)
        theta = task.prior.sample(batch, rng)
        calls = max(1, num_events // batch // rounds)
        simulators = (MeteredSimulator(task, batch * calls * (rounds + 1), rng), partial(bare, rng=rng))
        times = np.empty((rounds + 1, 2))
        for row in times:
            for i, simulate in enumerate(simulators):
                start = time.thread_time()
                for _ in range(calls):
                    simulate(theta)
                row[i] = time.thread_time() - start
        rate = batch * calls / np.median(times[1:], axis=0)
        ratio = np.median(times[1:, 0] / times[1:, 1])
        rows.append({"task": name, "at a time": batch, "events/s": rate[0], "bare": rate[1], "times the bare": ratio})
    return pd.DataFrame(rows)


def pythia_scaling(processes: int, num_events: int = 8000) -> float:
    """Events per second of so many processes together, each with its own Pythia, started before."""
    with Parallel(n_jobs=processes, batch_size=1) as parallel:
        ready = [delayed(_pythia_seconds)(1000) for _ in range(2 * processes)]
        parallel(ready)  # starts Python, and imports
        spans = parallel(delayed(_pythia_seconds)(num_events) for _ in range(processes))
    return sum(num_events / span for span in spans)


def _pythia_seconds(num_events: int) -> float:
    task, rng = Alignment(), np.random.default_rng(0)
    theta = np.zeros((num_events, 1))
    task.simulate(theta[:1000], rng)  # starts Pythia
    start = time.perf_counter()
    task.simulate(theta, rng)
    return time.perf_counter() - start


def main() -> None:
    arguments = sys.argv[1:]
    only_records = "--only-records" in arguments
    folders = [argument for argument in arguments if argument != "--only-records"]
    print(format_cost(Store(Path(folders[0] if folders else "results/reference"))))
    if only_records:
        return
    ours, bare = pythia_rates()
    ratio = statistics.median(a / b for a, b in zip(ours, bare, strict=True))
    print(
        f"Pythia: {statistics.median(ours):.0f} events/s simulated, {statistics.median(bare):.0f} in a bare nextBatch "
        f"loop, median ratio {ratio:.2f} over {len(ours)} rounds side by side"
    )
    one, two = (pythia_scaling(processes) for processes in (1, 2))
    print(f"Pythia in processes: {one:.0f} events/s in one, {two:.0f} in two, {two / one:.2f} times as many")
    print()
    rates = pd.concat([numpy_rates(batch) for batch in (32, 128, 100_000)])
    print(rates.sort_values("task", kind="stable").to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    main()
