"""What the loop found: its verdict, and which fits are reported."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import GAP, Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.sharpening import settled
from avobench.diagnosis.goodness_of_fit import regions as gates
from avobench.diagnosis.goodness_of_fit.held_out import HeldOut
from avobench.diagnosis.report.quoted import Move, ambiguity
from avobench.diagnosis.schema import Gap, Region, Verdict
from avobench.diagnosis.search.candidates import MOST, Weighed
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import domain
from avobench.tasks import Task

STILL = 0.2
"""Share of alpha at which a model with an effect is still rejected: no shape of the catalogue is exactly right."""


@dataclass(frozen=True)
class Found:
    """The models that the loop went through, an effect more in each, and what they were compared with."""

    task: Task
    target: Target
    x: NDArray
    """The measured events that were fitted (N, d)."""
    steps: list[Step]
    """The task alone, and with the effects that were added, if any were."""
    posterior: Posterior | None
    """How probable which effects are; None where nothing disagrees."""
    alpha: float
    gap_before: Gap
    """On events kept aside, of the task alone."""
    gap_after: Gap | None
    """With the effects; None where none was added."""
    candidates: list[tuple[Weighed, float]]
    """The task with each of the effects that were tried on it alone, best first, and its gap."""
    withdrawn: tuple[Effect, ...] = ()
    """Effects that the search had added, which the events kept aside do not confirm."""

    @classmethod
    def of(
        cls,
        task: Task,
        target: Target,
        x: NDArray,
        held_out: HeldOut,
        steps: list[Step],
        posterior: Posterior | None,
        alpha: float,
        rng: np.random.Generator,
        effort: Effort,
    ) -> "Found":
        """What the `steps` of the loop are worth by the events kept aside.

        Effects count with which the model agrees with the measurement, by the gates and on these events, or with which
        the gap there at least shrinks by more than its error.
        """
        before = held_out.gap(steps[0].own, rng, effort.covariance)
        after = held_out.gap(steps[-1].own, rng, effort.covariance) if len(steps) > 1 else None
        withdrawn: tuple[Effect, ...] = ()
        if after and not _describes(steps[-1], after, alpha) and not held_out.shrank(steps[-1].own, steps[0].own):
            withdrawn, steps, after = steps[-1].fit.model.effects, steps[:1], None
        single = posterior.single if posterior else []
        tried = [(one, held_out.gap(one.fit, rng, effort.fit).value) for one in single]
        return cls(task, target, x, steps, posterior, alpha, before, after, tried, withdrawn)

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
        if self.gap_after is None:
            return Verdict.UNEXPLAINED
        return Verdict.NAMED if _describes(self.steps[-1], self.gap_after, self.alpha) else Verdict.REDUCED

    @property
    def first(self) -> Fit:
        """The fit of the task alone that is reported.

        In its own metric a fit is efficient, but only where the model is right. Where it is wrong the two metrics want
        different parameters, and effects are compared in that of the loop.
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
        if not (self.posterior and self.effects):
            return []
        return ambiguity(last, self.steps[-1].fit, self.posterior.allowed, self.target, rng, many)

    def regions(self, rng: np.random.Generator) -> list[Region]:
        """Where the task alone disagrees with the events; nothing where it does not."""
        if not self.disagree:
            return []
        one_count = self.task.num_features == 1 and domain(self.task) == "counts"
        names = () if one_count else self.task.labels
        return gates.regions(self.steps[0].fit, self.target, self.x, rng, self.alpha, names)


def gap_events(effort: Effort) -> int:
    """Simulated events, at most, of the gaps before and after, and of those with each effect that was tried alone.

    Those that the first search leaves, and the two that are tried again from where they are beside each other.
    """
    return GAP * (2 * effort.covariance + (MOST[0] + 2) * effort.fit)


def _describes(step: Step, gap: Gap, alpha: float) -> bool:
    """Whether a model agrees with the measurement, by the gates and, on the events kept aside, by the `gap`."""
    return step.p_value >= STILL * alpha and gap.low <= 1
