"""How fast the discriminators' update of `avo` is, which has its gradients by hand: `make bench-avo`.

It is timed in turns with the same update by PyTorch's derivatives, as processor time of one thread.
"""

import copy
import time
from collections.abc import Callable, Sequence
from functools import partial

import click
import numpy as np
import pandas as pd
import torch
from torch import Tensor
from torch.nn import Sequential

from avobench.methods.avo import Avo
from avobench.methods.discriminator import cross_entropy, input_gradient_penalty, mlp
from avobench.methods.fused_step import DECAY, DECAY_SQUARE, EPS, FusedStep

R1 = 10.0
"""The paper's. A step takes as long whatever it is, unless it is zero."""
RATE = 1e-4
"""A step takes as long whatever it is."""
TARGETS = 15
"""As many problems at once as the benchmark has targets; `avo` has two networks for each."""
FEATURES = {"poisson": 1, "carl": 5, "alignment, rows summed": 32}


class AutogradStep:
    """FusedStep's update by autograd: one loss for each network, and one optimiser for all.

    It is called with observed and simulated events, (T, n, d) and (T, m, d) for T networks.
    """

    def __init__(self, networks: Sequence[Sequential], learning_rate: float, r1: float) -> None:
        self.networks, self.r1 = networks, r1
        parameters = [p for network in networks for p in network.parameters()]
        decay = (DECAY, DECAY_SQUARE)
        self.optimiser = torch.optim.Adam(parameters, lr=learning_rate, betas=decay, eps=EPS, foreach=True)

    def __call__(self, real: Tensor, synthetic: Tensor) -> None:
        self.optimiser.zero_grad()
        for network, x_real, x_synthetic in zip(self.networks, real, synthetic, strict=True):
            x_real = x_real.detach().requires_grad_(self.r1 > 0)
            logit_real = network(x_real)
            loss = cross_entropy(logit_real, network(x_synthetic))
            if self.r1:
                loss = loss + self.r1 * input_gradient_penalty(logit_real, x_real, "probability")
            loss.backward()
        self.optimiser.step()


def milliseconds(works: list[Callable[[], object]], rounds: int) -> list[float]:
    """Median processor time of each, taken in turns; a first round is not counted."""
    times = np.empty((rounds + 1, len(works)))
    for row in times:
        for i, work in enumerate(works):
            start = time.thread_time()
            work()
            row[i] = time.thread_time() - start
    return (1000 * np.median(times[1:], axis=0)).tolist()


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--rounds", default=9, show_default=True)
def main(rounds: int) -> None:
    """Print the time of an update by hand, and how many times as long autograd takes."""
    torch.set_num_threads(1)
    rows, avo, rng = [], Avo(), np.random.default_rng(0)
    for count in (2, 2 * TARGETS):
        for task, features in FEATURES.items():
            networks = [mlp(features, avo.hidden, rng) for _ in range(count)]
            batches = torch.randn(2, count, avo.batch_size, features)
            steps = FusedStep(copy.deepcopy(networks), RATE, R1), AutogradStep(networks, RATE, R1)
            by_hand, autograd = milliseconds([partial(step, *batches) for step in steps], rounds)
            rows.append(
                {"of": task, "networks": count, "by hand [ms]": by_hand, "autograd / by hand": autograd / by_hand}
            )
    click.echo(pd.DataFrame(rows).to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    main()
