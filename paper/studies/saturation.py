"""Whether the discriminator of avo-paper saturates on weinberg, where its proposal may stand still."""

from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.streams import stream
from avobench.methods.avo_paper import AvoPaper, algorithm_1
from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks.weinberg import Weinberg
from paper.experiments import BUDGET, NUM_OBSERVATIONS, READINGS
from paper.studies.files import StudyFile

FILE = StudyFile("saturation")
ITERATIONS = (20, 60, 300)
"""The iterations, of 3 333, after which the discriminator is looked at."""
NUM_TARGETS = 5
LOOKED_AT = 1000
"""Events simulated from the proposal at which it is looked at; they are beside the budget."""


def made(
    path: Path, seed: int = 0, iterations: tuple[int, ...] = ITERATIONS, num_targets: int = NUM_TARGETS
) -> dict[str, Any]:
    """The record of the study at `path`, of which each run that is lacking is made and written at once.

    `runs` holds for each the `target` and what R1 penalises (`r1_of`), and after each of the `iterations` the
    `largest` logit of the simulated events by its size, and the `share` of them at which log(1 - d) is exactly 0.
    Raises StoreError for a damaged file.
    """
    wanted = [
        ({"target": target, **reading}, partial(one, target, AvoPaper(**reading), seed, iterations))
        for target, reading in product(range(num_targets), READINGS.values())
    ]
    return FILE.completed(path, "runs", wanted, seed=seed, iterations=list(iterations))


def one(target: int, settings: AvoPaper, seed: int, iterations: tuple[int, ...]) -> dict[str, Any]:
    """The beginning of a run."""
    task, rng = Weinberg(), stream(seed, "study", "saturation", str(target))
    x = task.simulate(np.tile(task.targets()[target], (NUM_OBSERVATIONS, 1)), rng)
    problem = pose(task, x, MeteredSimulator(task, BUDGET, rng))
    q, largest, share = TruncatedGaussian(problem.prior, problem.support), [], []
    for iteration, state in enumerate(algorithm_1(problem, q, settings, rng)):
        if iteration in iterations:
            events = task.simulate(q.to_raw(q.sample(state.psi.numpy(), LOOKED_AT, rng)), rng)
            logits = state.discriminator.network(state.discriminator.inputs(events)).detach().numpy()
            largest.append(float(np.abs(logits).max()))
            share.append(float((state.discriminator.log_one_minus_d(events) == 0).mean()))
        if iteration == max(iterations):
            break
    return {"largest": largest, "share": share}


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a reading of R1 and iteration: the least, median and largest of `largest` over the runs.

    `no gradient` counts the runs in which log(1 - d) is 0 for all events, so that the proposal cannot move.
    """
    [record] = records
    runs = pd.DataFrame(record["runs"])
    rows = []
    for r1_of, of in runs.groupby("r1_of", sort=False):
        largest, share = np.stack(of["largest"]), np.stack(of["share"])
        for i, iteration in enumerate(record["iterations"]):
            row = {"R1 of": r1_of, "iteration": iteration, "runs": len(of), "least": largest[:, i].min()}
            row |= {"median": np.median(largest[:, i]), "largest": largest[:, i].max()}
            rows.append({**row, "no gradient": int((share[:, i] == 1).sum())})
    return pd.DataFrame(rows)
