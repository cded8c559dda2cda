"""How fast AVO's step is, beside what bounds it: `make bench-avo`.

First an iteration of `avo-paper` against a plain implementation (`plain_avo.py`). Then the discriminator's update as
`avo` makes it, by hand (`methods/fused_step.py`), against what PyTorch differentiates (`discriminator_steps.py`), the
matrix products in it alone and the memory traffic of its optimiser. Everything is timed in turns, as processor time of
one thread; a number is the median over the rounds.
"""

import copy
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import click
import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.plugins.registry import build, names
from avobench.methods.avo import Avo
from avobench.methods.avo_paper import AvoPaper
from avobench.methods.discriminator import mlp
from avobench.methods.fused_step import FusedStep
from avobench.tasks import Task
from avobench.tasks.errors import AvobenchError
from paper.speed.discriminator_steps import AutogradStep, StackedStep
from paper.speed.plain_avo import PlainAvo

R1 = 10.0
"""The paper's. A step takes as long whatever it is, unless it is zero."""
RATE = 1e-7
"""A rate that leaves the networks as they are: the plain one takes the logarithm of 1 - d, which a sure one makes 0."""
NUM_OBSERVATIONS = 1000
"""Events that batches are drawn from; a step takes as long whatever their number is."""
LARGE = 1 << 24
"""Numbers that no cache holds: 64 MiB of them."""
ADAM_ARRAYS = 7
"""Arrays of the size of the parameters that a step moves through memory. It reads parameters, gradient and two means,
and writes all but the gradient."""


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


def milliseconds(works: list[Callable[[], object]], rounds: int) -> list[float]:
    """Median processor time of each, taken in turns; a first round is not counted."""
    times = np.empty((rounds + 1, len(works)))
    for row in times:
        for i, work in enumerate(works):
            start = time.thread_time()
            work()
            row[i] = time.thread_time() - start
    return (1000 * np.median(times[1:], axis=0)).tolist()


def iteration(task: Task, batch_size: int, rounds: int) -> dict[str, float]:
    """Milliseconds of one, plain and as AvoPaper has it: M simulated events, one update of d and one of q."""
    noise, rng = Noise(task), np.random.default_rng(0)
    x = rng.standard_normal((NUM_OBSERVATIONS, task.num_features))
    hidden, p = task.discriminator.hidden, task.prior.dim
    plain = PlainAvo(x, lambda theta: noise.simulate(theta, rng), p, hidden, batch_size, rng, R1, RATE)
    few, many = 2, 7  # what remains of their difference is the iterations alone, without making the network
    rates = {"learning_rate": RATE, "proposal_learning_rate": RATE}

    def infer(iterations: int) -> None:
        simulate = MeteredSimulator(noise, iterations * batch_size, np.random.default_rng(0))
        method = AvoPaper(schedule="shared", batch_size=batch_size, **rates)
        method.infer(pose(noise, x, simulate), np.random.default_rng(0))

    times = milliseconds([plain.step, partial(infer, few), partial(infer, many)], rounds)
    ours = (times[2] - times[1]) / (many - few)
    return {"plain [ms]": times[0], "avo-paper [ms]": ours, "plain / avo-paper": times[0] / ours}


class Update(NamedTuple):
    """The networks that are updated, and the number of events in a batch."""

    of: str
    networks: int
    features: int
    hidden: tuple[int, ...]
    events: int
    """Observed ones, and as many simulated ones, for each network."""


def updates(problems: int = 15) -> list[Update]:
    """Those of `avo` for one problem and for as many as the benchmark has targets, and of `avo-paper` at M = 32."""
    avo, own = Avo(), {1: "poisson", 5: "carl", 32: "alignment, rows summed"}
    cases = [Update(f"avo, {own[d]}", 2, d, avo.hidden, avo.batch_size) for d in own]
    cases += [Update(f"avo, {own[d]}", 2 * problems, d, avo.hidden, avo.batch_size) for d in own]
    for name in ("poisson", "weinberg"):
        task, half = build("task", name, {}), AvoPaper().batch_size // 2
        shape = (1, task.num_features, task.discriminator.hidden)
        cases += [Update(f"avo-paper, {name}", *shape, events) for events in (half, 2 * half)]
    return cases


def discriminator_update(update: Update, rounds: int) -> dict[str, float]:
    """Milliseconds by hand, how many times as long the other ways take, and the share of what bounds it."""
    rng = np.random.default_rng(0)
    networks = [mlp(update.features, update.hidden, rng) for _ in range(update.networks)]
    real, synthetic = torch.randn(2, update.networks, update.events, update.features)
    ways = {
        "autograd, foreach": AutogradStep(copy.deepcopy(networks), RATE, R1, "foreach"),
        "autograd, fused": AutogradStep(copy.deepcopy(networks), RATE, R1, "fused"),
        "stacked, foreach": StackedStep(networks, RATE, R1, "foreach"),
        "stacked, fused": StackedStep(networks, RATE, R1, "fused"),
    }
    by_hand = FusedStep(copy.deepcopy(networks), RATE, R1)
    works = [partial(step, real, synthetic) for step in (by_hand, *ways.values())]
    hand_ms, *others, products_ms = milliseconds([*works, products(by_hand, update.events)], rounds)
    traffic = ADAM_ARRAYS * 4 * by_hand.flat.numel() / bandwidth()
    return {
        "by hand [ms]": hand_ms,
        **{f"{name} / by hand": ms / hand_ms for name, ms in zip(ways, others, strict=True)},
        "products / by hand": products_ms / hand_ms,
        "with traffic": (products_ms + traffic) / hand_ms,
    }


def products(step: FusedStep, n: int) -> Callable[[], None]:
    """The matrix products of one update from n observed and n simulated events, into buffers that stand.

    A layer has five: events up, the chain of R1 down and up, events down (not below the first), and the gradient.
    """
    weights = [tensor for tensor in step.tensors if tensor.ndim == 3][:-1]
    work = []
    for i, weight in enumerate(weights):
        t, q, p = weight.shape
        x, z = torch.randn(t, 3 * n, p), torch.randn(t, 3 * n, q)
        work += [(x[:, : 2 * n], weight.mT), (z[:, :n], weight), (x[:, :n], weight.mT), (z.mT, x)]
        work += [(z[:, : 2 * n], weight)] if i else []
    buffers = [torch.empty(len(a), a.shape[1], b.shape[2]) for a, b in work]

    def multiply() -> None:
        for (a, b), out in zip(work, buffers, strict=True):
            torch.bmm(a, b, out=out)

    return multiply


def bandwidth(rounds: int = 5) -> float:
    """Bytes per millisecond that one thread reads and writes of an array beyond the caches."""
    source, target = torch.ones(LARGE), torch.empty(LARGE)
    (copy,) = milliseconds([lambda: target.copy_(source)], rounds)
    return 2 * 4 * LARGE / copy


def show(title: str, rows: list[dict[str, object]]) -> None:
    click.echo(title)
    click.echo(pd.DataFrame(rows).to_string(index=False, float_format="{:.3g}".format) + "\n")


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--task", "tasks", multiple=True, metavar="NAME", help="Whose iterations of avo-paper; repeatable.  [all]"
)
@click.option("--batch-size", "batch_sizes", multiple=True, type=int, default=(32, 256), show_default=True)
@click.option("--rounds", default=9, show_default=True)
def main(tasks: tuple[str, ...], batch_sizes: tuple[int, ...], rounds: int) -> None:
    """Print AVO's time a step: beside a plain implementation, by hand beside PyTorch's, and beside what bounds it."""
    torch.set_num_threads(1)
    try:
        cases = [(build("task", name, {}), size) for size in batch_sizes for name in tasks or names("task")]
    except AvobenchError as error:
        raise click.ClickException(str(error)) from error
    rows = [{"task": task.name, "M": size, **iteration(task, size, rounds)} for task, size in cases]
    show(f"an iteration of avo-paper, median of {rounds} rounds", rows)
    rows = []
    for update in updates():
        hidden = "-".join(map(str, update.hidden))
        rows.append({**update._asdict(), "hidden": hidden, **discriminator_update(update, rounds)})
    show(f"an update of the discriminators with Adam and R1, median of {rounds} rounds", rows)


if __name__ == "__main__":
    main()
