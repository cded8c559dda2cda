"""How fast AVO's step is, beside what bounds it: `make bench-avo`.

First the whole step against a plain implementation (`bench/plain_avo.py`), then the discriminator's update, by
autograd and fused (`methods/fused_step.py`), against the matrix products in it alone and against the memory traffic of
its optimiser. Everything is timed in turns, as processor time of this process with one thread, so that other work on
the machine counts little; a number is the median over the rounds.
"""

import time
from collections.abc import Callable
from functools import partial

import click
import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from avobench.bench.budget import MeteredSimulator, pose
from avobench.bench.registry import build, names
from avobench.methods.avo import Avo
from avobench.methods.avo_paper import AvoPaper
from avobench.methods.discriminator import Discriminator
from avobench.methods.fused_step import FusedStep
from avobench.speed.plain_avo import PlainAvo
from avobench.tasks import Task
from avobench.tasks.errors import AvobenchError

R1, RATE = 10.0, 1e-7
"""A rate that leaves the networks as they are: the plain one takes the logarithm of 1 - d, which a sure one makes 0."""
NUM_OBSERVATIONS = 1000
LARGE = 1 << 24
"""Numbers that no cache holds: 64 MiB of them."""


class Noise(Task):
    """Standard normal events whatever theta, of the shape of another task: a simulator that costs next to nothing."""

    name = "noise"

    def __init__(self, like: Task) -> None:
        self.parameter_names, self.prior, self.support = like.parameter_names, like.prior, like.support
        self.num_features, self.discriminator = like.num_features, like.discriminator

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return rng.standard_normal((len(theta), self.num_features))

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        return x.mean(axis=0)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        return float("nan")


def milliseconds(works: list[Callable[[], object]], rounds: int) -> list[float]:
    """Median processor time of each, taken in turns; a first round is not counted."""
    times = np.empty((rounds + 1, len(works)))
    for row in times:
        for i, work in enumerate(works):
            start = time.thread_time()
            work()
            row[i] = time.thread_time() - start
    return (1000 * np.median(times[1:], axis=0)).tolist()


def whole_step(task: Task, batch_size: int, rounds: int) -> dict[str, float]:
    """Milliseconds of an iteration, plain and as AvoPaper has it: M simulated events, one update of d and one of q."""
    noise, rng = Noise(task), np.random.default_rng(0)
    x = rng.standard_normal((NUM_OBSERVATIONS, task.num_features))
    hidden, p = task.discriminator.hidden, task.prior.dim
    plain = PlainAvo(x, lambda theta: noise.simulate(theta, rng), p, hidden, batch_size, rng, R1, RATE)
    few, many = 2, 7  # what remains of their difference is the iterations alone, without making the network
    rates = {"learning_rate": RATE, "proposal_learning_rate": RATE}

    def infer(step: str, iterations: int) -> None:
        simulate = MeteredSimulator(noise, iterations * batch_size, np.random.default_rng(0))
        method = AvoPaper(schedule="shared", batch_size=batch_size, step=step, **rates)
        method.infer(pose(noise, x, simulate), np.random.default_rng(0))

    runs = [partial(infer, step, iterations) for step in ("autograd", "fused") for iterations in (few, many)]
    times = milliseconds([plain.step, *runs], rounds)
    autograd, fused = (times[2] - times[1]) / (many - few), (times[4] - times[3]) / (many - few)
    measured = {"plain [ms]": times[0], "autograd [ms]": autograd, "fused [ms]": fused}
    return measured | {"plain / autograd": times[0] / autograd, "plain / fused": times[0] / fused}


def discriminator_step(
    task: Task, batch_size: int, rounds: int, hidden: tuple[int, ...] | None = None
) -> dict[str, float]:
    """Milliseconds of one update from M / 2 observed and M / 2 simulated events, and of what bounds it.

    Of the task's network, or of one with the layers `hidden`.
    """
    rng = np.random.default_rng(0)
    noise = Noise(task)
    x = rng.standard_normal((NUM_OBSERVATIONS, task.num_features))
    problem = pose(noise, x, MeteredSimulator(noise, 1, rng))
    n, hidden = batch_size // 2, hidden or task.discriminator.hidden
    real, synthetic = x[:n], x[n : 2 * n]
    by_autograd, by_hand = (Discriminator(problem, hidden, np.random.default_rng(0)) for _ in range(2))
    optimiser = torch.optim.RMSprop(by_autograd.parameters(), lr=RATE)
    fused = FusedStep([by_hand.network], RATE, R1, "probability")

    def autograd() -> None:
        optimiser.zero_grad()
        by_autograd.loss(real, synthetic, R1, "probability").backward()
        optimiser.step()

    works = [autograd, lambda: fused(by_hand.inputs(real)[None], by_hand.inputs(synthetic)[None]), products(by_hand, n)]
    autograd_ms, fused_ms, products_ms = milliseconds(works, rounds)
    parameters = sum(p.numel() for p in by_hand.parameters())
    traffic = 5 * 4 * parameters / bandwidth()
    return {
        "parameters": parameters,
        "autograd [ms]": autograd_ms,
        "fused [ms]": fused_ms,
        "products [ms]": products_ms,
        "share": products_ms / fused_ms,
        "traffic [ms]": traffic,
        "share of both": (products_ms + traffic) / fused_ms,
    }


def products(discriminator: Discriminator, n: int) -> Callable[[], None]:
    """The matrix products of one update from n observed and n simulated events, into buffers that stand.

    A layer has five: events up, the chain of R1 down and up, events down (not below the first layer), and the gradient
    from all three sets of rows.
    """
    weights = [p.detach() for p in discriminator.parameters() if p.ndim == 2][:-1]
    work = []
    for i, weight in enumerate(weights):
        q, p = weight.shape
        x, z = torch.randn(3 * n, p), torch.randn(3 * n, q)
        work += [(x[: 2 * n], weight.T), (z[:n], weight), (x[:n], weight.T), (z.T, x)]
        work += [(z[: 2 * n], weight)] if i else []
    buffers = [torch.empty(len(a), b.shape[1]) for a, b in work]

    def multiply() -> None:
        for (a, b), out in zip(work, buffers, strict=True):
            torch.mm(a, b, out=out)

    return multiply


def bandwidth(rounds: int = 5) -> float:
    """Bytes per millisecond that one thread reads and writes of an array beyond the caches."""
    source, target = torch.ones(LARGE), torch.empty(LARGE)
    (copy,) = milliseconds([lambda: target.copy_(source)], rounds)
    return 2 * 4 * LARGE / copy


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--task", "tasks", multiple=True, metavar="NAME", help="Whose network; repeatable.  [all]")
@click.option("--batch-size", "batch_sizes", multiple=True, type=int, default=(32, 256), show_default=True)
@click.option("--rounds", default=9, show_default=True)
def main(tasks: tuple[str, ...], batch_sizes: tuple[int, ...], rounds: int) -> None:
    """Print AVO's time a step, beside a plain implementation, matrix products alone, and the optimiser's traffic."""
    torch.set_num_threads(1)
    try:
        cases = [(build("task", name, {}), size) for size in batch_sizes for name in tasks or names("task")]
    except AvobenchError as error:
        raise click.ClickException(str(error)) from error
    avo = Avo()
    tuned = partial(discriminator_step, hidden=avo.hidden)
    own = [(task, 2 * avo.batch_size) for task, size in cases if size == batch_sizes[0]]
    tables = {
        "whole step": (whole_step, cases),
        "discriminator step": (discriminator_step, cases),
        f"discriminator step with the network of avo, {'-'.join(map(str, avo.hidden))}": (tuned, own),
    }
    for title, (measure, sizes) in tables.items():
        rows = [{"task": task.name, "M": size, **measure(task, size, rounds)} for task, size in sizes]
        click.echo(f"{title}, median of {rounds} rounds")
        click.echo(pd.DataFrame(rows).to_string(index=False, float_format="{:.3g}".format) + "\n")


if __name__ == "__main__":
    main()
