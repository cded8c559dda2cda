"""What a method is given: the observation, the metered simulator, and what is known of the parameters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.bench.budget import MeteredSimulator, checked_summary
from avobench.tasks import Box, Discriminator, Task


@dataclass(frozen=True)
class Problem:
    """One inference problem: all that a method may use. It offers neither the true parameters nor a second way to
    simulate."""

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
    event_shape: tuple[int, ...] = ()
    """Of an event whose features form an image; () where they are a plain list."""
    cyclic_axes: tuple[int, ...] = ()
    """Axes of `event_shape` along which a cyclic shift of an event is as probable as the event."""

    @classmethod
    def of(cls, task: Task, x_observed: NDArray, simulate: MeteredSimulator) -> "Problem":
        x_observed.setflags(write=False)
        return cls(
            task.parameter_names,
            task.prior,
            task.support,
            x_observed,
            simulate,
            lambda x: checked_summary(task, x),
            task.discriminator,
            task.event_shape,
            task.cyclic_axes,
        )
