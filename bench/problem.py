"""What a method is given: the observation, the metered simulator, and what is known of the parameters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.bench.budget import MeteredSimulator
from avobench.tasks import Box, Discriminator, Task


@dataclass(frozen=True)
class Problem:
    """One inference problem. It holds neither the true parameters nor any other way to simulate."""

    parameter_names: tuple[str, ...]
    prior: Box
    """Uniform prior, in raw units."""
    support: Box
    """Where the simulator may be called; contains the prior."""
    x_observed: NDArray
    """Observed events (N, d), read-only."""
    simulate: MeteredSimulator
    summary: Callable[[NDArray], NDArray[np.float64]]
    """Summary statistic of a set of events: (n, d) -> (k,)."""
    discriminator: Discriminator
    """The network that the paper gives to this task."""

    @classmethod
    def of(cls, task: Task, x_observed: NDArray, simulate: MeteredSimulator) -> "Problem":
        x_observed.setflags(write=False)
        return cls(
            task.parameter_names, task.prior, task.support, x_observed, simulate, task.summary, task.discriminator
        )
