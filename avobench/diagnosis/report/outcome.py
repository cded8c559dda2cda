"""The outcome of a diagnosis: the models before and after, the verdict, which fits are reported, and notes."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import settled
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.null import Inferred
from avobench.diagnosis.goodness_of_fit.gates import ExtendedModel
from avobench.diagnosis.goodness_of_fit.held_out import HeldOut
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.schema import Candidate, Gap, Verdict
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.settings import REPORT, TEST
from avobench.diagnosis.summary.bins import Bins
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import domain
from avobench.tasks import Task

OUTSIDE_FROM = 0.5
"""Probability of being outside the catalogue from which no name is told of a model that is rejected."""
MOST_LEFT = 0.5
"""Share of the gap that a model which is rejected may leave: from then on it leaves more than it explains."""


def share_left(before: Gap, after: Gap | None) -> float:
    """The share of the held-out gap that is left with effects: 1 if it did not shrink, or none was added."""
    if after is None or after.value >= before.value:
        return 1.0
    return float(np.clip((after.value - 1) / (before.value - 1), 0, 1)) if before.value > 1 else 0.0


@dataclass(frozen=True)
class Outcome:
    """The simulator as it is and with the effects that were added, and how each compares with held-out events."""

    null: ExtendedModel
    extended: ExtendedModel | None
    """The model with the effects; None where none was added."""
    posterior: Posterior | None
    """The probabilities of sets of effects; None where nothing disagrees."""
    alpha: float
    gap_before: Gap
    gap_after: Gap | None
    candidates: list[Candidate]
    """The effects that were tried on the task alone, best first."""
    withdrawn: tuple[Effect, ...] = ()
    """Effects that the search had added, which are none of the answer."""
    why: str = ""
    """What speaks against them."""

    @classmethod
    def of(
        cls,
        null: ExtendedModel,
        extended: ExtendedModel | None,
        posterior: Posterior | None,
        alpha: float,
        held_out: HeldOut,
        rng: np.random.Generator,
        effort: Effort,
        affordable: Callable[..., AbstractContextManager] = nullcontext,
    ) -> "Outcome":
        """The outcome by the tests and the held-out events, from which it follows what is probably outside.

        Where the simulated events end, `affordable` notes what is left out.

        Effects count if the gap on these events is smaller with them, and the model agrees with the measurement or the
        gap shrinks by more than its error. A model that does not agree must leave less of the gap than it explains, and
        it must be more probable than not that what is missing is in the catalogue.
        """
        before, after = held_out.gap(null.efficient, rng, effort.covariance), None
        with affordable("the gap with the effects that were found, which are left out"):
            after = held_out.gap(extended.efficient, rng, effort.covariance) if extended else None
        extended = extended if after else None  # an effect that loses events may take many for each that it leaves
        withdrawn: tuple[Effect, ...] = ()
        why = ""
        if extended:
            describes = _describes(extended, after, alpha)
            if after.value >= before.value:
                why = "on held-out events the gap is no smaller with it"
            elif not describes and not held_out.shrank(extended.efficient, null.efficient):
                why = "on held-out events the gap shrank by less than its error"
            else:
                share = share_left(before, after)
                likely = posterior.outside if posterior else 0.0
                if not describes and (share > MOST_LEFT or likely >= OUTSIDE_FROM):
                    why = f"with it {share:.0%} of the gap are left, and p = {extended.p_value:.2g}"
            if why:
                withdrawn, extended, after = extended.fit.model.effects, None, None
        candidates, single = [], posterior.single if posterior else []
        with affordable("the gaps of some of the effects that were tried"):
            for each in single:
                candidates.append(
                    Candidate(
                        **named(each.fit.model.effects[0].key, each.fit.model.task.labels).model_dump(),
                        score=single[0].evidence.at_least - each.evidence.at_least,
                        p_value=each.fit.p_value,
                        held_out_gap=held_out.gap(each.fit, rng, effort.fit).value,
                    )
                )
        return cls(null, extended, posterior, alpha, before, after, candidates, withdrawn, why)

    @property
    def disagree(self) -> bool:
        """True if the task alone was rejected."""
        return self.null.p_value < self.alpha

    @property
    def final(self) -> ExtendedModel:
        """The model that is reported: with the effects, or without where none was added."""
        return self.extended or self.null

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects that were added."""
        return self.extended.fit.model.effects if self.extended else ()

    @cached_property
    def verdict(self) -> Verdict:
        if not self.disagree:
            return Verdict.NOTHING
        if self.gap_after is None:
            return Verdict.UNEXPLAINED
        return Verdict.NAMED if _describes(self.final, self.gap_after, self.alpha) else Verdict.FAMILY

    @property
    def first(self) -> Fit:
        """The fit of the task alone that is reported.

        In its own metric a fit is efficient, but only where the model is right. Where it is wrong the two metrics want
        different parameters, and effects are compared in that of the target.
        """
        return self.null.fit if self.disagree else self.null.efficient

    def final_fit(self, target: Target, rng: np.random.Generator, effort: Effort) -> Fit:
        """The fit of the final model that is reported; in the target's metric where it is still rejected, as above."""
        if self.verdict == Verdict.FAMILY:
            num_events = int(effort.sharpen * target.num_events)
            return settled(self.final.fit, target, rng, num_events, effort.settle)
        return self.final.efficient if self.effects else self.first


def to_choose_from(task: Task) -> tuple[str, ...]:
    """The names of the features of a task; none of a single count, which needs no name."""
    return () if task.num_features == 1 and domain(task) == "counts" else task.labels


def _describes(model: ExtendedModel, gap: Gap, alpha: float) -> bool:
    """True if a model agrees with the measurement, by the tests and, on held-out events, by the `gap`."""
    return model.p_value >= TEST.rejected_share * alpha and gap.low <= 1


def notes_of(
    outcome: Outcome, fit: Fit, target: Target, inferred: Inferred | None, num_events: int | None
) -> list[str]:
    """What a reader should know beside the numbers, a sentence each; `fit` is the final one."""
    notes = []
    gap = outcome.gap_before
    if outcome.verdict == Verdict.NAMED and gap.value < REPORT.faint:
        notes.append(
            f"A gap of {gap.value:.2g} seldom excludes that an effect outside the catalogue did this: compare "
            "docs/challenge.md."
        )
    if outcome.withdrawn:
        names = " and ".join(effect.name for effect in outcome.withdrawn)
        notes.append(f"{names} was tried and left out: {outcome.why}.")
    if outcome.disagree and gap.low <= 1:
        notes.append(unconfirmed(outcome))
    if inferred is not None:
        notes.append(inferred.note(outcome.first))
    if num_events is not None and num_events < REPORT.few_events:
        notes.append(
            f"{num_events} events make {target.rank} bins or less: the identifiability card says what so few cannot "
            "show."
        )
    if isinstance(target.summary, Bins) and (omitted := target.summary.left_out):
        notes.append(
            f"{omitted} pairs of features, far from each other in their order, are not compared: there are too many of "
            "them for so many events, or for the memory."
        )
    notes += prior_notes(outcome.first, "without effects")
    if outcome.effects:
        notes += prior_notes(fit, "with the added effects")
    return notes + bound_notes(fit)


def unconfirmed(outcome: Outcome) -> str:
    """Why there is a disagreement, though the held-out events show no gap."""
    rejecting = [name for name, gate in outcome.null.gates.items() if gate.corrected < outcome.alpha]
    if "summary" in rejecting:
        return "What was held out is too little to show by itself what the rest shows."
    return f"The gap is of the summary, and does not show what rejects the simulator: the {' and '.join(rejecting)}."


def prior_notes(fit: Fit, how: str) -> list[str]:
    """Parameters of the task that were fitted to a value outside the prior; `how` says by which fit."""
    task = fit.model.task
    fitted = zip(task.parameter_names, fit.params.tolist(), task.prior.low, task.prior.high, strict=False)
    return [
        f"{name} = {value:.4g}, fitted {how}, lies outside its prior, {low:g} to {high:g}."
        for name, value, low, high in fitted
        if not low <= value <= high
    ]


def bound_notes(fit: Fit) -> list[str]:
    """Parameters of the fit that ended at an end of their range."""
    names = [*fit.model.task.parameter_names, *(f"{e.name}: {p.name}" for e in fit.model.effects for p in e.parameters)]
    ends = {1: "upper", -1: "lower"}
    return [
        f"The fit ended at the {ends[at]} bound of {n}."
        for n, at in zip(names, fit.at_bound.tolist(), strict=True)
        if at
    ]
