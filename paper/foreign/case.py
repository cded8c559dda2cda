"""One data set with a simulator of it, and the answer that was written down before any diagnosis was made."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task


@dataclass(frozen=True)
class Case:
    """A data set, the simulator that it is compared with, and what is missing in that simulator."""

    name: str
    task: Task
    events: Callable[[np.random.Generator], NDArray]
    """The events (N, d) or (N,), drawn from a generator; measured ones take no notice of it."""
    why: str
    """What happened to the events, and why these names tell it."""
    right: tuple[str, ...] = ()
    """Names that are right as a first one, as `effect` or `effect on feature`; none where nothing is missing."""
    defensible: tuple[str, ...] = ()
    """Names that tell a part of it, or the same less well."""

    def x(self) -> NDArray:
        """The events (N, d) or (N,), the same in each call."""
        return self.events(np.random.default_rng(list(self.name.encode())))
