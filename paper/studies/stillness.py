"""Why the proposal of `avo-paper` can stand still: `python -m paper.studies.stillness`.

The first hundred iterations of its run on target 13 of weinberg, with R1 of d as printed and with R1 of the logit.
After each the discriminator is asked about events apart from those of the run. The columns say in how many iterations
every logit of observed events is larger than 17 in size, so that d is 0 or 1 to rounding; in how many R1 of d is
exactly 0, log(1 - d) is exactly 0 on all simulated events, and the proposal's gradient is exactly 0, so that it stood
still.

With a logit far below 0 on all simulated events, log(1 - d) is 0 and so is the proposal's gradient. R1 of d has the
factor d (1 - d), squared: where d saturates it is 0 as well, and nothing holds the network. R1 of the logit has no such
factor. Logits of a thousand multiply what is lost to rounding, so another machine makes other runs, which saturate as
these do.
"""

from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import Trial
from avobench.methods.avo_paper import algorithm_1
from avobench.methods.discriminator import input_gradient_penalty
from avobench.methods.proposal import TruncatedGaussian
from paper.experiments import NUM_OBSERVATIONS

TARGET = 13
"""One of six of the benchmark's 15 on which the committed run stands still for more than a third of its trace."""
ITERATIONS = 100
"""Of the run, from its start."""
EVENTS = 100
"""Of either class, of which the discriminator is asked after an iteration."""
SATURATED = 17.0
"""Logit beyond which d is as near to 0 or 1 as float32 tells."""


def row(settings: dict[str, Any], iterations: int = ITERATIONS) -> dict[str, Any]:
    """What the first iterations of `avo-paper` with these settings do, counted in iterations."""
    trial = Trial(Cell("weinberg", {}, "avo-paper", settings, TARGET, 0, 160_000, NUM_OBSERVATIONS, 0))
    problem, rng, task = trial.problem, np.random.default_rng(0), trial.cell.build_task()
    q, seen, largest = TruncatedGaussian(problem.prior, problem.support), [], 0.0
    for iteration, state in enumerate(algorithm_1(problem, q, trial.method, trial.rng)):
        if iteration:
            d = state.discriminator
            x = task.simulate(q.to_raw(q.sample(state.psi.numpy(), EVENTS, rng)), rng)
            real = d.inputs(problem.x_observed[:EVENTS]).requires_grad_()
            logit = d.network(real)
            r1 = input_gradient_penalty(logit, real, "probability").item()
            size, f = logit.abs(), d.log_one_minus_d(x)
            seen.append((size.min().item() > SATURATED, r1 == 0, not f.any(), not state.psi.grad.any()))
            largest = size.max().item()
        if iteration == iterations:
            break
    names = ("d saturated", "R1 of d is 0", "log(1 - d) is 0", "still")
    counts = dict(zip(names, np.sum(seen, axis=0).tolist(), strict=True))
    return {"iterations": iterations, **counts, "largest logit at the end": largest}


def format_table() -> str:
    """A row a reading of R1, to be read."""
    readings = {"d": "probability", "logit": "logit"}
    rows = [{"R1 of": name, **row({"r1_of": reading})} for name, reading in readings.items()]
    return pd.DataFrame(rows).to_string(index=False, float_format=lambda value: f"{value:.3g}")


if __name__ == "__main__":
    print(format_table())
