"""What the loop found: its verdict, and which fits are reported."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.answer.quoted import Move, ambiguity
from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.sharpening import settled
from avobench.diagnosis.gates import regions as gates
from avobench.diagnosis.gates.held_out import HeldOut
from avobench.diagnosis.schema import Region, Verdict
from avobench.diagnosis.search.search import STILL
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import domain
from avobench.tasks import Task


@dataclass(frozen=True)
class Found:
    """The models that the loop went through, an effect more in each, and what they were compared with."""

    task: Task
    target: Target
    x: NDArray
    """The measured events that were fitted (N, d)."""
    held_out: HeldOut
    steps: list[Step]
    """The first is the task alone."""
    alpha: float

    @property
    def disagree(self) -> bool:
        """Whether the task alone was rejected."""
        return self.steps[0].p_value < self.alpha

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Those that were added."""
        return self.steps[-1].fit.model.effects if len(self.steps) > 1 else ()

    @cached_property
    def verdict(self) -> Verdict:
        if not self.disagree:
            return Verdict.NOTHING
        if not self.effects:
            return Verdict.UNEXPLAINED
        return Verdict.NAMED if self.steps[-1].p_value >= STILL * self.alpha else Verdict.REDUCED

    @property
    def first(self) -> Fit:
        """The fit of the task alone that is reported.

        In its own metric a fit is efficient, but only where the model is right. Where it is wrong the two metrics want
        different parameters, and the gap is measured in that of the loop.
        """
        return self.steps[0].fit if self.disagree else self.steps[0].own

    def last(self, rng: np.random.Generator, effort: Effort) -> Fit:
        """The fit of the final model that is reported; in the loop's metric where it is still rejected, as above."""
        if self.verdict == Verdict.REDUCED:
            many = int(effort.sharpen * len(self.x))
            return settled(self.steps[-1].fit, self.target, rng, many, effort.settle)
        return self.steps[-1].own if self.effects else self.first

    def moves(self, last: Fit, rng: np.random.Generator, effort: Effort) -> list[Move]:
        """Where theta would be with other effects, or other shapes, that the data allow beside the `last` fit."""
        many = int(effort.sharpen * len(self.x))
        return [
            move for step in self.steps[:-1] for move in ambiguity(last, step.added, step.ties, self.target, rng, many)
        ]

    def regions(self, rng: np.random.Generator) -> list[Region]:
        """Where the task alone disagrees with the events; nothing where it does not."""
        if not self.disagree:
            return []
        one_count = self.task.num_features == 1 and domain(self.task) == "counts"
        names = () if one_count else self.task.labels
        return gates.regions(self.steps[0].fit, self.target, self.x, rng, self.alpha, names)
