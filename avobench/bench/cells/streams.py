"""Random streams, and the observed events that every method is given."""

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.contract import stable_hash


def stream(seed: int, *words: object) -> np.random.Generator:
    """The random stream that belongs to `words` under the root seed."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(stable_hash(*map(str, words)),)))


def observe(task: Task, target: int, num_observations: int, seed: int) -> NDArray:
    """The observed events of a target, the same for every method and repetition: (N, d)."""
    theta = np.repeat(task.targets()[target : target + 1], num_observations, axis=0)
    return checked_events(task, theta, stream(seed, "observation", task.name, target))
