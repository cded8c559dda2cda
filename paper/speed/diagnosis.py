"""How the time of a diagnosis grows with the measured events and with the catalogue: `make bench-diagnosis`.

Measured events have one effect of the catalogue, strong enough that its name is looked for at every size.
"""

import multiprocessing
import time

import click
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.bench.cells.state import peak_memory_mib, reset_peak_memory
from avobench.bench.events import check_events
from avobench.bench.plugins import registry
from avobench.diagnosis.run import diagnose
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks import Task
from paper.speed.growth import exponent, show

HIDDEN = {"poisson": ("zero_inflation", 0.2), "weinberg": ("scale", 0.1), "carl": ("offset", 0.5)}
"""The effect that is missing on each task, in its plainest shape on the first feature, and its strength."""
EVENTS = (2_000, 10_000, 50_000, 250_000)
SHARES = (0.25, 0.5, 1.0)
"""Shares of the catalogue that are searched, in its order, with the missing effect in front."""


def _hidden_first(task: Task) -> list[Effect]:
    """The catalogue, with the effect of HIDDEN in front."""
    name, _ = HIDDEN[task.name]
    return sorted(catalogue(task), key=lambda effect: effect.key not in {(name, None), (name, 0)})


def _measured(task_name: str, num_events: int, rng: np.random.Generator, pieces: int = 1) -> NDArray:
    """Events (n, d) at the middle of the prior with the effect of HIDDEN, made in so many pieces."""
    task = registry.build("task", task_name, {})
    model = Model(task, (_hidden_first(task)[0],))
    params = [*np.add(task.prior.low, task.prior.high) / 2, HIDDEN[task_name][1]]
    sizes = [len(piece) for piece in np.array_split(np.arange(num_events), pieces)]
    return np.concatenate([model.simulate(np.tile(params, (size, 1)), rng) for size in sizes])


def measure(task_name: str, num_events: int, share: float, seed: int = 0) -> dict[str, float | str]:
    """A row: what a diagnosis with this share of the catalogue takes, and the effect that it names."""
    task = registry.build("task", task_name, {})
    effects = _hidden_first(task)
    chosen = effects[: max(round(share * len(effects)), 1)]
    x = _measured(task_name, num_events, np.random.default_rng(seed))
    start = time.process_time()
    found = diagnose(task, x, seed=seed, effects=chosen).diagnosis
    seconds = time.process_time() - start
    named = ", ".join(effect.name for effect in found.effects) or "-"
    return {
        "task": task_name,
        "events": num_events,
        "effects": len(chosen),
        "seconds": seconds,
        "simulated": found.num_simulations,
        "named": named,
    }


LARGE = {"poisson": 10_000_000, "carl": 3_000_000}
"""Rows of the tables whose memory is measured: one column of counts, and five of numbers."""
LARGE_SIMULATIONS = 50_000_000
"""Limit on simulated events. Memory does not grow with their number."""


def memory(task_name: str, num_events: int, seed: int = 0) -> dict[str, float | str]:
    """A row: the memory [GB] that a process has with so many events, and at most while it diagnoses them in order."""
    task = registry.build("task", task_name, {})
    x = _measured(task_name, num_events, np.random.default_rng(seed), max(num_events // 100_000, 1))
    reset_peak_memory()
    held, start = peak_memory_mib(), time.process_time()
    x, _ = check_events(task, x)
    found = diagnose(task, x, seed=seed, num_simulations=LARGE_SIMULATIONS, ordered=True).diagnosis
    return {
        "task": task_name,
        "events": num_events,
        "compared": found.num_events,
        "GB before": (held or np.nan) / 1024,
        "GB at most": (peak_memory_mib() or np.nan) / 1024,
        "seconds": time.process_time() - start,
        "simulated": found.num_simulations,
    }


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--largest", type=int, default=EVENTS[-1], show_default=True, help="Measured events, at most.")
@click.option("--memory", "only_memory", is_flag=True, help="Instead the memory of diagnoses of millions of rows.")
def main(largest: int, only_memory: bool) -> None:
    """Print the seconds of diagnoses against measured events and against the size of the catalogue."""
    if only_memory:
        with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as alone:  # the peak is of a process
            show(pd.DataFrame([alone.apply(memory, row) for row in LARGE.items()]))
        return
    sizes = [size for size in EVENTS if size <= largest]
    if len(sizes) < 2:
        raise click.UsageError(f"--largest must be at least {EVENTS[1]}")
    measure("poisson", sizes[0], SHARES[0])  # imports and first calls
    tables = {
        "events": [(size, 1.0) for size in sizes],
        "effects": [(min(50_000, sizes[-1]), share) for share in SHARES],
    }
    for what, points in tables.items():
        table = pd.DataFrame([measure(task, *point) for task in HIDDEN for point in points])
        show(table)
        for task, rows in table.groupby("task", sort=False):
            click.echo(f"{task}: seconds ~ {what}^{exponent(rows[what], rows['seconds']):.2f}")
        click.echo()


if __name__ == "__main__":
    main()
