"""What stands for measured events where there is no single sample of them: published tables, or several data sets."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.summary.bins import Summary
from avobench.diagnosis.summary.target import Target, summary_of, target_of
from avobench.tasks import Task


class Part(ABC):
    """A random part of a measurement; `len` is the number of events that would tell as much, about."""

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def split(self, aside: float, rng: np.random.Generator) -> "tuple[Part, Part]":
        """What is fitted, and the share `aside` that no fit sees. They are independent."""

    @property
    @abstractmethod
    def first(self) -> Target:
        """What is fitted before anything is known of theta."""

    @abstractmethod
    def target(self, simulated: NDArray) -> Target:
        """What is fitted, by a summary that suits simulated events (n, d) near the fit."""

    @abstractmethod
    def seen_by(self, summary: Summary) -> tuple[NDArray[np.float64], int]:
        """The mean (K,) by the summary of a target of another part, and how many events it is of, about."""

    @abstractmethod
    def as_events(self, task: Task, simulated: NDArray, rng: np.random.Generator) -> NDArray:
        """Events (m, d) of which each feature has the values that were measured, for what effects read off events.

        What was not measured is as it is in simulated events (n, d).
        """


Measured = NDArray | Part
"""Measured events (n, d), or what stands for them."""


def split(x: Measured, aside: float, rng: np.random.Generator) -> tuple[Measured, Measured]:
    """What is fitted, and the share `aside` that no fit sees."""
    if isinstance(x, Part):
        return x.split(aside, rng)
    shuffled, cut = rng.permutation(len(x)), len(x) - int(aside * len(x))
    return x[shuffled[:cut]], x[shuffled[cut:]]


def target_for(task: Task, x: Measured, simulated: NDArray) -> Target:
    """The target of what was measured, with bins that suit simulated events (n, d) too."""
    return x.target(simulated) if isinstance(x, Part) else target_of(x, summary_of(task, x, simulated), simulated)
