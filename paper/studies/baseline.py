"""What the baseline does to the variance of the score-function estimator of the gradient (paper, Equations 12, 13)."""

from pathlib import Path
from typing import Any

import numpy as np

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.streams import stream
from avobench.methods.avo_paper import AvoPaper, algorithm_1, score_gradient
from avobench.methods.proposal import TruncatedGaussian
from paper.experiments import NUM_OBSERVATIONS, POISSON
from paper.studies.files import StudyFile
from paper.tasks import PoissonExample

FILE = StudyFile("baseline")
KINDS = ("none", "optimal", "as_printed")
ITERATIONS = (100, 1000, 3000)
"""Of the example of Section 4.1: the proposal far from theta*, on its way, and at the end."""
BATCHES = 2000
"""Mini-batches behind each variance, which is then known to three per cent."""


def made(path: Path, seed: int = 0, batches: int = BATCHES) -> dict[str, Any]:
    """The record of the study at `path`: read, or, if that is missing or of another seed, made.

    `variances` holds for each of ITERATIONS and KINDS the variance over mini-batches of the gradient in the mean of the
    proposal and in its logarithm of the standard deviation. Raises StoreError when the file is damaged.
    """
    record = FILE.begun(path, "variances", seed=seed, batches=batches, iterations=list(ITERATIONS))
    if rows := record["variances"]:
        return record
    task, settings, rng = PoissonExample(), AvoPaper(**POISSON), stream(seed, "study", "baseline")
    theta = np.broadcast_to(task.targets()[0], (NUM_OBSERVATIONS, task.prior.dim))
    simulate = MeteredSimulator(task, (ITERATIONS[-1] + 1) * settings.batch_size, rng)
    problem = pose(task, task.simulate(theta, rng), simulate)
    q = TruncatedGaussian(problem.prior, problem.support)
    for iteration, state in enumerate(algorithm_1(problem, q, settings, rng)):
        if iteration in ITERATIONS:
            psi, gradients = state.psi.numpy(), {kind: [] for kind in KINDS}
            for _ in range(batches):
                u = q.sample(psi, settings.batch_size, rng)
                f = state.discriminator.log_one_minus_d(task.simulate(q.to_raw(u), rng))
                for kind in KINDS:
                    gradients[kind].append(score_gradient(q.score(psi, u), f, kind)[:, 0])
            for kind in KINDS:
                mean, log_std = np.var(gradients[kind], axis=0)
                rows.append({"iteration": iteration, "baseline": kind, "mean": mean, "log std": log_std})
    FILE.keep(path, record, "torch")
    return record
