"""The problem that a method is given: the observation, the metered simulator, and what is known of the parameters."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.tasks import Box, Discriminator


class Simulator(Protocol):
    """The only way to simulate: it counts the events, and refuses a request that would exceed the budget."""

    @property
    def budget(self) -> int: ...

    @property
    def used(self) -> int: ...

    @property
    def remaining(self) -> int: ...

    def __call__(self, theta: ArrayLike) -> NDArray:
        """One event per row: theta (n, p) in raw units -> x (n, d).

        Raises SupportError for a theta that is not finite, of the wrong shape or outside the support, BudgetExhausted
        when fewer than n events remain, SimulatorError when the simulator fails.
        """

    def repeat(self, theta: ArrayLike, n: int) -> NDArray:
        """n events per row: theta (m, p) -> x (m, n, d). Raises as `__call__` does."""


@dataclass(frozen=True)
class Problem:
    """One inference problem: all that an honest method uses.

    It offers neither the true parameters nor a second way to simulate. A method that looks for them all the same, in
    the private parts of these objects or in the frames of its callers, finds them: it runs in the same process.
    """

    parameter_names: tuple[str, ...]
    prior: Box
    """Uniform prior, in raw units; any where the method says `by_moments`."""
    support: Box
    """The box in which the simulator may be called; it contains the prior."""
    x_observed: NDArray
    """Observed events (N, d), read-only."""
    simulate: Simulator
    summary: Callable[[NDArray], NDArray[np.float64]]
    """Summary statistic of a set of events: (n, d) -> (k,)."""
    discriminator: Discriminator
    """The network that the paper gives to this task."""
    feature_names: tuple[str, ...] = ()
    """One a feature, where they have names."""
    event_shape: tuple[int, ...] = ()
    """Shape of an event whose features form an image; () where they are a plain list."""
    cyclic_axes: tuple[int, ...] = ()
    """Axes of `event_shape` along which a cyclic shift of an event is as probable as the event."""
