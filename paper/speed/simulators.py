"""Simulators against what one would write without this package: bare NumPy, and a bare loop of Pythia's `nextBatch`.

Both are timed in turns in one run, by processor time, because machines differ and are busy: `make bench-speed`.
"""

import time
from functools import partial

import click
import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from numpy.typing import NDArray

from avobench.bench.cells.budget import MeteredSimulator
from avobench.bench.plugins.registry import build
from avobench.tasks.alignment import CHUNK, SETTINGS, Alignment, start_pythia
from avobench.tasks.carl import MIXING


def pythia_rates(ways: list[tuple[int, int]], rounds: int = 5, num_events: int = 4000) -> pd.DataFrame:
    """A row for each number of processes at work at once, with the events asked for at a time.

    Events per second by wall time, of the metered simulator and of a bare `nextBatch` loop; of both, how many times as
    many as in the first row; and the median share of the bare rate that the simulator reaches.
    """
    rows = []
    for processes, batch in ways:
        with Parallel(n_jobs=processes, batch_size=1) as parallel:
            ready = [delayed(_pythia_seconds)(1, CHUNK, batch) for _ in range(2 * processes)]
            parallel(ready)  # starts Python, and imports
            work = [delayed(_pythia_seconds)(rounds, num_events, batch) for _ in range(processes)]
            seconds = np.array(parallel(work))  # (processes, rounds, 2 simulators, 2 clocks)
        wall, cpu = seconds[..., 0], seconds[..., 1]
        ours, bare = (rounds * num_events / wall.sum(axis=1)).sum(axis=0)
        share = np.median(cpu[..., 1] / cpu[..., 0])
        rows.append(
            {"processes": processes, "at a time": batch, "events/s": ours, "bare": bare, "share of bare": share}
        )
    table = pd.DataFrame(rows)
    for name in ("events/s", "bare"):
        table[f"{name}, times the first"] = table[name] / table[name].iloc[0]
    return table


def _pythia_seconds(rounds: int, num_events: int, batch: int) -> NDArray[np.float64]:
    """Wall and processor seconds of both simulators in each round: (rounds, 2, 2)."""
    task, rng = Alignment(), np.random.default_rng(0)
    simulate = MeteredSimulator(task, rounds * num_events + batch, rng)
    pythia = start_pythia((*SETTINGS, f"ParticleDecays:tau0Max = {task.max_tau0}", "Random:seed = 1"))
    theta = np.zeros((batch, 1))

    def ours() -> None:
        for _ in range(num_events // batch):
            simulate(theta)

    def bare() -> None:
        for _ in range(num_events // CHUNK):
            pythia.nextBatch(CHUNK)

    simulate(theta)  # starts its Pythia
    seconds = np.empty((rounds, 2, 2))
    for row in seconds:
        for i, work in enumerate((ours, bare)):
            start = time.perf_counter(), time.thread_time()
            work()
            row[i] = np.subtract((time.perf_counter(), time.thread_time()), start)
    return seconds


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
    """Events per second of the metered simulator and of bare NumPy, `batch` at a time, by processor time, in turns."""
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


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--rounds", default=9, show_default=True, help="Of both simulators in turns, after a first one.")
def main(rounds: int) -> None:
    """Print the speed of all simulators beside bare ones."""
    rates = pd.concat([numpy_rates(batch, rounds=rounds) for batch in (32, 160, 100_000)])
    click.echo(rates.sort_values("task", kind="stable").to_string(index=False, float_format="{:.3g}".format))
    click.echo("\nPythia")
    ways = [(1, 4 * CHUNK), (2, 4 * CHUNK), (1, 32)]
    click.echo(pythia_rates(ways, rounds).to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    main()
