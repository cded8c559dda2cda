"""How time and memory grow with the work, and whether memory grows with the number of cells: `make bench-scaling`.

Exponents are slopes through the logarithms. The settings are cheap, so that the growth is seen and not the networks.
"""

import os
import tempfile
import time
from pathlib import Path
from typing import Any

import click
import numpy as np
import pandas as pd

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.state import peak_memory_mib, reset_peak_memory
from avobench.bench.cells.trial import execute
from avobench.bench.processes.local import LocalBackend
from avobench.bench.store.status import Status, reason
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import View, run
from avobench.tasks.errors import AvobenchError
from paper.speed.cost import PARTS

TASK = "poisson"
METHODS = {"avo-paper": {"hidden": [16], "batch_size": 512}, "abc-smc": {"events_per_theta": 64, "population_size": 25}}
SIZES = (10_000, 100_000, 1_000_000)
TINY = {
    "avo-paper": (96, ["avo-paper.hidden=[4]"]),
    "abc-smc": (2400, ["abc-smc.events_per_theta=16", "abc-smc.population_size=15"]),
}
"""Budget and settings of a cell that is nearly all harness and package: two iterations, a few generations."""


def exponent(x: pd.Series, y: pd.Series) -> float:
    """The b of y = a x^b, fitted to the logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def one_cell(method: str, budget: int, num_observations: int) -> dict[str, float]:
    """Seconds of a cell in this process, its highest memory [MiB], and how much of it was not in use before."""
    reset_peak_memory()
    before = peak_memory_mib() or np.nan
    record = execute(Cell(TASK, {}, method, METHODS[method], 0, 0, budget, num_observations, 0))
    require_ok([record])
    seconds = sum(record[f"{part}_seconds"] for part in PARTS)
    peak = record["peak_memory_mib"] or np.nan
    return {"seconds": seconds, "peak [MiB]": peak, "above start [MiB]": peak - before}


def against_budget_and_observations(method: str, sizes: tuple[int, ...] = SIZES) -> pd.DataFrame:
    """A row for each size of one, the other at the smallest size: time and memory."""
    rows = []
    for what in ("budget", "observations"):
        for size in sizes:
            budget, num_observations = (size, sizes[0]) if what == "budget" else (sizes[0], size)
            rows.append({"against": what, "size": size, **one_cell(method, budget, num_observations)})
    return pd.DataFrame(rows)


def sweep(
    targets: int, repetitions: int, jobs: int, budget: int, folder: Path, method: str = "avo-paper"
) -> dict[str, float]:
    """A sweep of small cells in workers that stand ready: cells, wall seconds, memory [MiB].

    Memory is the highest of the process that leads (with one job it is the worker), and of any worker.
    """
    store = Store(folder, create=True)
    backend = LocalBackend(jobs, store.running)

    def small(last: int, repetitions: int, budget: int, seed: int) -> list[Cell]:
        return plan([TASK], [method], f"0-{last}", repetitions, budget, 100, seed, TINY[method][1])

    run(small(0, 2 * jobs, TINY[method][0], 1), store, backend, View())  # starts the workers
    cells = small(targets - 1, repetitions, budget, 0)
    reset_peak_memory()
    before, start = peak_memory_mib() or np.nan, time.perf_counter()
    records = run(cells, store, backend, View())
    seconds = time.perf_counter() - start
    require_ok(records)
    leader, worker = peak_memory_mib() or np.nan, max(record["peak_memory_mib"] or np.nan for record in records)
    memory = {"leader [MiB]": leader, "of it new [MiB]": leader - before, "largest worker [MiB]": worker}
    return {"cells": len(cells), "seconds": seconds, **memory}


def require_ok(records: list[dict[str, Any]]) -> None:
    """Raise AvobenchError for the first record that is not: it measures something else."""
    for record in records:
        if record["status"] != Status.OK:
            raise AvobenchError(f"{record['task']} {record['method']}: {reason(record)}")


def show(table: pd.DataFrame) -> None:
    click.echo(table.to_string(index=False, float_format="{:.3g}".format))


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--largest", type=click.Choice([str(size) for size in SIZES[1:]]), default=str(SIZES[-1]))
@click.option("--cells", default=1000, show_default=True, help="Of the largest sweep of tiny cells.")
def main(largest: str, cells: int) -> None:
    """Print time and memory against budget, observations, targets, workers and cells, with the exponent of each."""
    sizes = tuple(size for size in SIZES if size <= int(largest))
    for method in METHODS:
        one_cell(method, sizes[0], sizes[0])  # imports and first calls
        table = against_budget_and_observations(method, sizes)
        click.echo(f"{method} on {TASK}")
        show(table)
        for what, part in table.groupby("against", sort=False):
            last = part.iloc[-2:]
            seconds = f"seconds ~ size^{exponent(part['size'], part['seconds']):.2f}"
            seconds += f" (last decade {exponent(last['size'], last['seconds']):.2f})"
            click.echo(f"{what}: {seconds}, peak memory ~ size^{exponent(part['size'], part['peak [MiB]']):.3f}")
        click.echo()

    with tempfile.TemporaryDirectory() as folder:
        cores = os.cpu_count() or 1
        sweeps = {
            "targets": [(n, 2, 1) for n in (1, 4, 15)],
            "workers": [(8, 2, n) for n in (1, 2, 4, 8, 16, 32) if n <= cores],
        }
        for name, values in sweeps.items():
            rows = []
            for i, (targets, repetitions, jobs) in enumerate(values):
                measured = sweep(targets, repetitions, jobs, 100 * TINY["avo-paper"][0], Path(folder) / f"{name}{i}")
                rows.append({name: targets if name == "targets" else jobs, **measured})
            table = pd.DataFrame(rows)
            show(table)
            click.echo(f"{name}: seconds ~ {name}^{exponent(table[name], table['seconds']):.2f}\n")

        sizes = [size for size in (10, 100, 1000, 10_000) if size <= cells]
        for method, (budget, _) in TINY.items():
            at = Path(folder) / method
            table = pd.DataFrame([sweep(10, size // 10, 2, budget, at / f"{size}", method) for size in sizes])
            click.echo(f"cells of {method}")
            show(table)
            for name in ("leader [MiB]", "largest worker [MiB]"):
                slope = np.polyfit(table["cells"], table[name], 1)[0]
                power = exponent(table["cells"], table[name])
                click.echo(f"{name[:-6]}: {1024 * slope:.2g} KiB a cell, memory ~ cells^{power:.3f}")
            click.echo()


if __name__ == "__main__":
    main()
