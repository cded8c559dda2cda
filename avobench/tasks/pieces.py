"""Events made by several processes at once: each piece has a random stream of its own, so jobs change no event."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import joblib
import numpy as np
from joblib.externals.loky.process_executor import TerminatedWorkerError
from numpy.typing import NDArray

from avobench.tasks.checked import checked_events
from avobench.tasks.contract import Task, twin
from avobench.tasks.errors import ProcessEnded
from avobench.tasks.region import regions

PIECES = 16
"""A request of a method is made in so many pieces: more than most machines have cores, and few to begin."""


def in_pieces(
    task: Task, theta: Sequence[NDArray[np.float64]], seeds: Sequence[np.random.SeedSequence], jobs: int
) -> NDArray:
    """Events as those of `checked_events` for pieces of theta, (n, p) each, with a seed each: all in order (N, d)."""
    task_regions = regions(task)
    counts = [region.counts.copy() for region in task_regions]
    calls = [joblib.delayed(_made)(task, *each) for each in zip(theta, seeds, strict=True)]
    try:
        made, more = zip(*joblib.Parallel(n_jobs=min(jobs, len(calls)))(calls), strict=True)
    except TerminatedWorkerError as error:
        raise ProcessEnded("crashed", "a worker process was ended (killed, or out of memory)") from error
    for k, region in enumerate(task_regions):  # other processes have counted in copies
        region.counts = counts[k] + sum(each[k] for each in more)
    return np.concatenate(made)


def _made(
    task: Task, theta: NDArray[np.float64], seed: np.random.SeedSequence
) -> tuple[NDArray, list[NDArray[np.int64]]]:
    """Events as those of `checked_events`, and what they added to the counts of each region of the task."""
    task_regions = regions(task)
    before = [region.counts.copy() for region in task_regions]
    x = checked_events(task, theta, np.random.default_rng(seed))
    return x, [region.counts - old for region, old in zip(task_regions, before, strict=True)]


def spread(task: Task, jobs: int | None) -> Task:
    """A twin of a task whose events so many processes make; the task itself for None."""
    if jobs is None:
        return task
    regions(task)  # where it works is learnt here, and not by each process
    return twin(task, simulate=partial(_spread, task, jobs))


def _spread(task: Task, jobs: int, theta: NDArray[np.float64], rng: np.random.Generator, *alter: Any) -> NDArray:
    task.require_support(theta)
    seeds = np.random.SeedSequence(rng.integers(2**63, size=2).tolist()).spawn(min(PIECES, len(theta)))
    return in_pieces(task, np.array_split(theta, len(seeds)), seeds, jobs)
