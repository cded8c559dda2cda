"""Which effects to add to a model that the events reject: one after the other, or two at once."""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort, addition
from avobench.diagnosis.fit.descent import refine
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.known import KnownModel
from avobench.diagnosis.fit.sharpening import sharpen
from avobench.diagnosis.gates.held_out import HeldOut
from avobench.diagnosis.progress import Telling
from avobench.diagnosis.search.acceptance import CHANCE, PAIR_LEAVES, accepted, enough, excess, scatter, shown
from avobench.diagnosis.search.candidates import candidates
from avobench.diagnosis.search.features import CLOSES, clears_feature
from avobench.diagnosis.search.joint import beside, reshaped
from avobench.diagnosis.search.pairs import best_pair
from avobench.diagnosis.search.ranking import TIE, Ranked, cost, left, likely, ranking, tied, yardstick_of
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.tasks.errors import BudgetExhausted
from avobench.tasks.meter import Meter

STILL = 0.2
"""Share of alpha at which a model with an effect is still rejected: no shape of the catalogue is exactly right."""
RIVALS = 3
"""Effects that may be the second, best first, for which the first is tried in other shapes: each costs fits."""
FIRSTS = 5
"""Effects tied with the first of two, best first, that are tried in its place beside the second."""


@dataclass(frozen=True)
class Search:
    """What a search for effects needs beside the model that it begins with."""

    target: Target
    x: NDArray
    """The measured events that are fitted (N, d)."""
    held_out: HeldOut
    """The measured events kept aside."""
    effects: list[Effect]
    alpha: float
    max_effects: int
    rng: np.random.Generator
    effort: Effort
    jobs: int
    telling: Telling | None = None
    """What is told which effect is looked for."""

    def steps_from(self, before: Step) -> tuple[list[Step], list[str]]:
        """The steps from a rejected model on, an effect more in each, until one is not rejected; and notes.

        Where the simulated events end, the steps that were complete.
        """
        kept: list[list[Step]] = [[before]]
        try:
            return self._steps_from(before, kept)
        except BudgetExhausted:
            return kept[-1], []

    def _steps_from(self, before: Step, kept: list[list[Step]]) -> tuple[list[Step], list[str]]:
        """The same, adding to `kept` the steps whenever they are complete."""
        steps, notes = [before], []
        worse = self.held_out.grew
        clears = partial(clears_feature, target=self.target)
        while len(steps) <= self.max_effects and steps[-1].p_value < self.alpha:
            if self.telling is not None:
                self.telling.begin(f"search for effect {len(steps)}")
            rejected = len(steps) == 1 or steps[-1].p_value < STILL * self.alpha
            if self._spent(steps) or (len(steps) > 1 and not shown(steps[-1], rejected, self.alpha)):
                break
            if len(steps) == 1:
                ranks, known = self.ranked(steps[0].fit, 1 - CLOSES)
            else:
                others = steps[0].added.others if len(steps) == 2 else ()
                ranks, known = self.ranked(steps[-1].fit, PAIR_LEAVES, others)
            steps[-1] = replace(steps[-1], ranks=ranks)
            step = accepted(steps, worse, clears, rejected)
            two = rejected and len(steps) <= 2 <= self.max_effects and not self._spent(steps)
            if two and not enough(steps, step, clears):
                both = None
                with suppress(BudgetExhausted):  # the single effect then stands
                    both = best_pair(steps, self.ranked, worse)
                if both and (step is None or cost(both[0][-1].added.fit) < cost(step.added.fit)):
                    steps, known = both
                    step = steps[-1]
            if step is None:
                break
            steps, more = self._with(step, steps, known)
            kept.append(steps)
            steps, notes = self.first_again(self.without_second(steps)), notes + more
            kept.append(steps)
        if steps[-1].p_value < self.alpha and self._spent(steps):
            notes.append("the search ended early, since it had taken as many simulated events as a diagnosis may")
        return steps, notes

    def _spent(self, steps: list[Step]) -> bool:
        """Whether as many events were simulated as a diagnosis may take."""
        return steps[-1].fit.model.events.used >= self.effort.enough * max(len(self.x), self.effort.few)

    def _with(self, step: Step, steps: list[Step], known: KnownModel | None) -> tuple[list[Step], list[str]]:
        """The steps, of which the last is to be `step`, and one with the effect that comes after it; and notes."""
        fit, known, notes = self._refined(step.added.fit, known)
        return [*steps[:-1], step, Step.of(fit, self.target, self.x, self.rng, self.effort, known)], notes

    def without_second(self, steps: list[Step]) -> list[Step]:
        """The steps without their second effect, if the first describes the events alone from where it is beside it.

        The fit without the second had then gone astray.
        """
        if len(steps) != 3:
            return steps
        pair = steps[-1].fit.model
        model = replace(pair, effects=pair.effects[:-1], stretch=pair.stretch[:-1])
        per_round = max(self.effort.least, int(self.effort.rounds * len(self.x)))
        fit = refine(model, self.target, steps[-1].fit.point[: model.dim], 0.01, self.rng, num_events=per_round)
        if excess(fit) - 2 * fit.noiseless_q_error > CHANCE * scatter(fit):
            return steps
        key, found = model.effects[0].key, [entry.fit for entry in steps[0].ranks]
        ranks = ranking([fit, *found], steps[0].fit.noiseless_q)
        (first,) = (entry for entry in ranks if entry.effect.key == key)
        rivals = tuple(entry for entry in ranks if entry is not first and entry.score < first.score + TIE)
        alone, _ = self._with(replace(steps[0], ranks=ranks, chosen=first, rivals=rivals), steps[:1], None)
        return alone if alone[-1].p_value >= self.alpha else steps

    def first_again(self, steps: list[Step]) -> list[Step]:
        """The steps with the first of two effects chosen anew, beside the second, from those that it was tied with.

        Without the second, each had the values that imitate that one best.
        """
        if len(steps) != 3:
            return steps
        null, one, pair = steps[0], steps[1], steps[2].fit
        chosen, second = null.added, pair.model.effects[-1]
        within = [entry for entry in null.ranks if entry.score < chosen.score + TIE]
        rivals = [entry for entry in within if entry.effect.key not in _keys(pair)][:FIRSTS]
        found = {chosen.effect.key: (pair, None)}
        for rival in rivals:
            known = rival.fit.known(self.target, int(self.effort.known * len(self.x)), self.rng)
            fit = beside(pair, known, rival.fit, self.target, self.rng, self.effort, null.fit.noiseless_q)
            if likely(fit, pair, null.fit.noiseless_q):
                fit, *_ = self._refined(fit, known)
            found[rival.effect.key] = fit, known
        best = min((fit for fit, _ in found.values()), key=cost)
        yardstick = yardstick_of(left(best) - best.dof, null.fit.noiseless_q)
        costs = {key: cost(fit, yardstick) for key, (fit, _) in found.items()}
        first = min([chosen, *rivals], key=lambda entry: costs[entry.effect.key])
        ties = [e for e in [chosen, *rivals] if e is not first and costs[e.effect.key] < costs[first.effect.key] + TIE]
        untried = [entry for entry in null.ties if entry.effect.key not in {*costs, second.key}]
        null = replace(null, chosen=first, rivals=(*ties, *untried))
        if first is chosen:
            return [null, *steps[1:]]
        fit, known = found[first.effect.key]
        one = Step(first.fit, first.fit, {}, chosen=Ranked(second, fit, 0.0), rivals=tuple(one.ties))
        return self._with(one, [null, one], known)[0]

    def ranked(self, fit: Fit, leaves: float, others: tuple[Fit, ...] = ()) -> tuple[list[Ranked], KnownModel]:
        """Effects to add to a fit, best first, fitted closely if one may leave less than `leaves` of its excess.

        Also the fit's model, made known. `others` are fits of its last effect in other shapes.
        """
        used, without = _keys(fit), fit.noiseless_q
        free = [e for e in self.effects if e.key not in used]
        effort = self.effort if not used else replace(self.effort, families=self.effort.families_beside)

        def hopeful(one: Fit) -> bool:
            leaves_little = excess(one) - 2 * one.noiseless_q_error < leaves * excess(fit)
            return leaves_little or clears_feature(one, fit, self.target)

        options = {"hopeful": hopeful, "q_without": without, "jobs": self.jobs}
        meter = fit.model.events.meter if fit.model.events is not None else Meter()
        with meter.keeping(addition(effort, self.target.num_events)):
            fits, known = candidates(fit, self.target, free, self.x, self.rng, effort, **options)
        ranks = ranking(fits, without)
        if ranks and others and excess(ranks[0].fit) > scatter(ranks[0].fit):
            foremost = ranks[:1] + tied(ranks)[: RIVALS - 1]
            pairs = [entry.fit for entry in foremost]
            better = reshaped(pairs, known, others, self.target, self.rng, self.effort, without)
            kept = [entry.fit for entry in ranks if all(entry is not one for one in foremost)]
            ranks = ranking([fit for fit, _ in better] + kept, without)
            known = next((known for fit, known in better if fit is ranks[0].fit), known)
        return ranks, known

    def _refined(self, fit: Fit, known: KnownModel | None) -> tuple[Fit, KnownModel | None, list[str]]:
        """The fit of an added effect with more events, the model without it if that is `known`, and notes."""
        known = known if known and known.model.effects == fit.model.effects[:-1] else None
        fit, notes = widened(fit, self.target, self.rng, self.effort)
        many = int(self.effort.again[-1] * len(self.x))
        again = sharpen(fit, self.target, self.rng, many, rounds=8, known=known)
        return min(again, fit, key=lambda fit: fit.noiseless_q), known, notes


def _keys(fit: Fit) -> set[tuple]:
    return {effect.key for effect in fit.model.effects}


def widened(fit: Fit, target: Target, rng: np.random.Generator, effort: Effort) -> tuple[Fit, list[str]]:
    """The fit with the bound of its last effect's strength doubled, if it ended there and the bound is a guess."""
    effect = fit.model.effects[-1]
    at = fit.model.dim - len(effect.parameters)
    if not (effect.parameters[0].soft and fit.at_bound[at] > 0):
        return fit, []
    stretch = (*(fit.model.stretch or (1.0,) * len(fit.model.effects))[:-1], 2.0)
    model = replace(fit.model, stretch=stretch)
    again = refine(model, target, model.to_cube(fit.params), 0.1, rng, num_events=effort.least)
    return again, [f"the bound of {effect.name}: {effect.parameters[0].name} was doubled, since the fit ended there"]
