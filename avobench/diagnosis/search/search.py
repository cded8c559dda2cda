"""Which effects to add to a model that the events reject: one after the other, or two at once."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit, polish, refine
from avobench.diagnosis.fit.known import Base
from avobench.diagnosis.search.candidates import CLOSES, beside, candidates, clears_feature, reshaped
from avobench.diagnosis.search.ranking import TIE, Ranked, cost, left, likely, ranking, tied, unit_of
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect

VETO = 2.5
"""Of the scatter of the events kept aside, in standard errors: a gap that grows on them by more vetoes an effect."""
STILL = 0.2
"""Of alpha: the level at which a model with an effect is still rejected: no shape of the catalogue is exactly right."""
PAIR_LEAVES, PAIR_CLEAR, PAIR_ALONE, CHANCE = 0.3, 0.1, 0.2, 1.65
"""A second effect must leave less than the first share of what the first effect left; unless it leaves less than the
second, it must close more than the third of the whole gap by itself, or have no rival, or leave no more than chance: so
many standard deviations of chi-squared. A third must have no rival, nor a second where the first may be all."""
PARTNERS = 3
"""Effects to which a second one is added at once, where none alone closes enough."""
Rank = Callable[..., tuple[list[Ranked], Base]]
"""That of a Search, `ranked`."""
RIVALS, FIRSTS = 3, 5
"""Of the effects that may be the second, for which the first is tried in other shapes; others that may be the first."""


@dataclass(frozen=True)
class Search:
    """What a search for effects needs beside the model that it begins with."""

    target: Target
    x: NDArray
    """The measured events that are fitted (N, d)."""
    aside: NDArray[np.float64]
    """The mean summary of those kept aside (K,)."""
    num_aside: int
    effects: list[Effect]
    alpha: float
    max_effects: int
    rng: np.random.Generator
    effort: Effort
    jobs: int

    def steps_from(self, before: Step) -> tuple[list[Step], list[str]]:
        """The steps from a rejected model on, an effect more in each, until one is not rejected; and notes."""
        steps, notes = [before], []
        worse = partial(grew, target=self.target, mean=self.aside, num_events=self.num_aside)
        clears = partial(clears_feature, target=self.target)
        while len(steps) <= self.max_effects and steps[-1].p_value < self.alpha:
            rejected = len(steps) == 1 or steps[-1].p_value < STILL * self.alpha
            if self._spent(steps) or (len(steps) > 1 and not _shown(steps[-1], rejected, self.alpha)):
                break
            if len(steps) == 1:
                ranks, known = self.ranked(steps[0].fit, 1 - CLOSES)
            else:
                others = steps[0].added.others if len(steps) == 2 else ()
                ranks, known = self.ranked(steps[-1].fit, PAIR_LEAVES, others)
            steps[-1] = replace(steps[-1], ranks=ranks)
            step = _accepted(steps, worse, clears, rejected)
            two = rejected and len(steps) <= 2 <= self.max_effects and not self._spent(steps)
            if two and not _enough(steps, step, clears):
                pair = _pair(steps, self.ranked, worse)
                if pair and (step is None or cost(pair[0][-1].added.fit) < cost(step.added.fit)):
                    steps, known = pair
                    step = steps[-1]
            if step is None:
                break
            steps, more = self._with(step, steps, known)
            steps, notes = self._first_again(self._without_second(steps)), notes + more
        if steps[-1].p_value < self.alpha and self._spent(steps):
            notes.append("the search ended early, since it had taken as many simulated events as a diagnosis may")
        return steps, notes

    def _spent(self, steps: list[Step]) -> bool:
        """Whether as many events were simulated as a diagnosis may take."""
        return steps[-1].fit.model.events.used >= self.effort.enough * max(len(self.x), self.effort.few)

    def _with(self, step: Step, steps: list[Step], known: Base | None) -> tuple[list[Step], list[str]]:
        """The steps, of which the last is to be `step`, and one with the effect that comes after it; and notes."""
        fit, base, notes = self._refined(step.added.fit, known)
        return [*steps[:-1], step, Step.of(fit, self.target, self.x, self.rng, self.effort, base)], notes

    def _without_second(self, steps: list[Step]) -> list[Step]:
        """The steps without their second effect, if the first describes the events alone from where it is beside it.

        The fit without the second had then gone astray.
        """
        if len(steps) != 3:
            return steps
        pair = steps[-1].fit.model
        model = replace(pair, effects=pair.effects[:-1], stretch=pair.stretch[:-1])
        per_round = max(self.effort.least, int(self.effort.rounds * len(self.x)))
        fit = refine(model, self.target, steps[-1].fit.unit[: model.dim], 0.01, self.rng, num_events=per_round)
        if excess(fit) - 2 * fit.gap_error > CHANCE * noise(fit):
            return steps
        key, found = model.effects[0].key, [entry.fit for entry in steps[0].ranks]
        ranks = ranking([fit, *found], steps[0].fit.gap)
        (first,) = (entry for entry in ranks if entry.effect.key == key)
        rivals = tuple(entry for entry in ranks if entry is not first and entry.score < first.score + TIE)
        alone, _ = self._with(replace(steps[0], ranks=ranks, chosen=first, rivals=rivals), steps[:1], None)
        return alone if alone[-1].p_value >= self.alpha else steps

    def _first_again(self, steps: list[Step]) -> list[Step]:
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
            base = rival.fit.known(self.target, int(self.effort.base * len(self.x)), self.rng)
            fit = beside(pair, base, rival.fit, self.target, self.rng, self.effort, null.fit.gap)
            if likely(fit, pair, null.fit.gap):
                fit, *_ = self._refined(fit, base)
            found[rival.effect.key] = fit, base
        best = min((fit for fit, _ in found.values()), key=cost)
        unit = unit_of(left(best) - best.dof, null.fit.gap)
        costs = {key: cost(fit, unit) for key, (fit, _) in found.items()}
        first = min([chosen, *rivals], key=lambda entry: costs[entry.effect.key])
        ties = [e for e in [chosen, *rivals] if e is not first and costs[e.effect.key] < costs[first.effect.key] + TIE]
        untried = [entry for entry in null.ties if entry.effect.key not in {*costs, second.key}]
        null = replace(null, chosen=first, rivals=(*ties, *untried))
        if first is chosen:
            return [null, *steps[1:]]
        fit, base = found[first.effect.key]
        one = Step(first.fit, first.fit, {}, chosen=Ranked(second, fit, 0.0), rivals=tuple(one.ties))
        return self._with(one, [null, one], base)[0]

    def ranked(self, fit: Fit, leaves: float, others: tuple[Fit, ...] = ()) -> tuple[list[Ranked], Base]:
        """Effects to add to a fit, best first, fitted closely if one may leave less than a share `leaves` of its gap.

        Also the fit's model, made known. `others` are fits of its last effect in other shapes.
        """
        used, without = _keys(fit), fit.gap
        free = [e for e in self.effects if e.key not in used]
        effort = self.effort if not used else replace(self.effort, families=self.effort.families_beside)

        def hopeful(one: Fit) -> bool:
            return excess(one) - 2 * one.gap_error < leaves * excess(fit) or clears_feature(one, fit, self.target)

        options = {"hopeful": hopeful, "gap_without": without, "jobs": self.jobs}
        fits, known = candidates(fit, self.target, free, self.x, self.rng, effort, **options)
        ranks = ranking(fits, without)
        if ranks and others and excess(ranks[0].fit) > noise(ranks[0].fit):
            foremost = ranks[:1] + tied(ranks)[: RIVALS - 1]
            pairs = [entry.fit for entry in foremost]
            better = reshaped(pairs, known, others, self.target, self.rng, self.effort, without)
            kept = [entry.fit for entry in ranks if all(entry is not one for one in foremost)]
            ranks = ranking([fit for fit, _ in better] + kept, without)
            known = next((base for fit, base in better if fit is ranks[0].fit), known)
        return ranks, known

    def _refined(self, fit: Fit, known: Base | None) -> tuple[Fit, Base | None, list[str]]:
        """The fit of an added effect with more events, the model without it if that is `known`, and notes."""
        base = known if known and known.model.effects == fit.model.effects[:-1] else None
        fit, notes = widened(fit, self.target, self.rng, self.effort)
        many = int(self.effort.again[-1] * len(self.x))
        again = polish(fit, self.target, self.rng, many, rounds=8, base=base)
        return min(again, fit, key=lambda fit: fit.gap), base, notes


def _keys(fit: Fit) -> set[tuple]:
    return {effect.key for effect in fit.model.effects}


def grew(new: Fit, old: Fit, target: Target, mean: NDArray[np.float64], num_events: int) -> bool:
    """Whether the gap to the mean summary (K,) of events kept aside grows from one fit to another beyond their scatter.

    If the new one is right, what it leaves of them is noise, also along the difference d of the two: normal, of
    variance 1 from these events, and their share of those that were fitted from the fit. The gap grows where it is
    below -|d| / 2, which chance alone brings about for a weak effect.
    """
    after, before = (np.sqrt(num_events) * ((mean - fit.predicted) @ target.whitening) for fit in (new, old))
    d = before - after
    error = np.sqrt(1 + (1 + new.noise + old.noise) * num_events / target.num_events)
    z = float(after @ d) / max(float(np.linalg.norm(d)) * error, 1e-12)
    return float(after @ after) > float(before @ before) and z < -VETO


def _accepted(
    steps: list[Step], worse: Callable[[Fit, Fit], bool], clears: Callable[[Fit, Fit], bool], rejected: bool
) -> Step | None:
    """The last step with the effect that may be added to its model, the first of its ranks as a rule; None for none.

    Else the first that clears a feature which no effect acts on yet. `rejected`: whether the model without it must be
    wrong, not only may be.
    """
    last = steps[-1]
    if last.ranks and not worse(last.ranks[0].fit, last.fit) and _closes(steps, rejected):
        return last
    for entry in last.ranks:
        if clears(entry.fit, last.fit) and not worse(entry.fit, last.fit):
            feature, within = entry.effect.feature, entry.score + TIE
            rivals = [one for one in last.ranks if one is not entry and one.effect.feature == feature]
            return replace(last, chosen=entry, rivals=tuple(one for one in rivals if one.score < within))
    return None


def _closes(steps: list[Step], rejected: bool) -> bool:
    """Whether the first of the last step's ranks closes enough of the whole gap to be added; `rejected` as above."""
    last, whole = steps[-1], excess(steps[0].fit)
    best = last.ranks[0]
    if len(steps) == 1:
        return excess(best.fit) < (1 - CLOSES) * whole
    if last.fit.gap - best.fit.gap < TIE + best.fit.gap_error:
        return False
    share = excess(best.fit) / max(excess(last.fit), 1e-9)
    single = {entry.effect.key: entry.fit for entry in steps[0].ranks}.get(best.effect.key)
    alone = single is not None and whole - excess(single) > PAIR_ALONE * whole
    no_rival, no_more = not tied(last.ranks), excess(best.fit) < CHANCE * noise(best.fit)
    if (len(steps) > 2 or not rejected) and not no_rival:
        return False
    return share < PAIR_CLEAR or (share < PAIR_LEAVES and (alone or no_rival or no_more))


def _shown(step: Step, rejected: bool, alpha: float) -> bool:
    """Whether the summary shows something that one more effect may close: what only the classifier sees has no name."""
    return excess(step.fit) >= TIE if rejected else step.gates["summary"].p_value < alpha


def _enough(steps: list[Step], step: Step | None, clears: Callable[[Fit, Fit], bool]) -> bool:
    """Whether no other pair need be looked for: there is an effect to add, and a second leaves no more than chance."""
    if step is None or len(steps) == 1:
        return step is not None
    fit = step.added.fit
    return clears(fit, step.fit) or excess(fit) < CHANCE * noise(fit)


def _pair(steps: list[Step], search: Rank, worse: Callable[[Fit, Fit], bool]) -> tuple[list[Step], Base] | None:
    """Two effects that together leave next to nothing, where none alone closes half of the gap.

    Or where one does, but a second beside it is not enough: the pair then begins with that second, or with another that
    the first was tied with.
    """
    null, whole = steps[0], excess(steps[0].fit)
    enough = PAIR_CLEAR * whole
    firsts = [entry for entry in null.ranks if 0 < excess(entry.fit) < (1 - PAIR_ALONE) * whole]
    if len(steps) > 1:
        enough = min(enough, PAIR_LEAVES * excess(steps[1].fit))
        second = [entry.effect.key for entry in steps[1].ranks[:1]]
        firsts = [e for e in firsts if e.effect.key in second or any(e is tie for tie in null.ties)]
    return _beginning_with(firsts[:PARTNERS], enough, null, search, worse)


def _beginning_with(
    firsts: list[Ranked], enough: float, null: Step, search: Rank, worse: Callable[[Fit, Fit], bool]
) -> tuple[list[Step], Base] | None:
    """The best pair that begins with one of these effects and leaves no more than `enough`.

    The steps up to the first of them, with the ranks that the second leads, and the model with the first alone.
    """
    found = [(one, *search(one.fit, max(enough / excess(one.fit), PAIR_CLEAR), one.others)) for one in firsts]
    found = [(first, ranks, known) for first, ranks, known in found if ranks]
    if not found:
        return None
    found.sort(key=lambda each: cost(each[1][0].fit))
    first, ranks, known = found[0]
    best = ranks[0]
    if excess(best.fit) > enough or worse(best.fit, null.fit):
        return None
    rivals = tuple(
        one
        for one, (second, *_), _ in found[1:]
        if second.effect.key == best.effect.key and cost(second.fit) < cost(best.fit) + TIE
    )
    return [replace(null, chosen=first, rivals=rivals), Step(first.fit, first.fit, {}, ranks)], known


def excess(fit: Fit) -> float:
    """By how much chi-squared exceeds its degrees of freedom."""
    return max(fit.gap - fit.dof, 0.0)


def noise(fit: Fit) -> float:
    """Standard deviation of chi-squared."""
    return float(np.sqrt(2 * fit.dof))


def widened(fit: Fit, target: Target, rng: np.random.Generator, effort: Effort) -> tuple[Fit, list[str]]:
    """The fit with the bound of its last effect's strength doubled, if it ended there and the bound is a guess."""
    effect = fit.model.effects[-1]
    at = fit.model.dim - len(effect.parameters)
    if not (effect.parameters[0].soft and fit.at_bound[at] > 0):
        return fit, []
    stretch = (*(fit.model.stretch or (1.0,) * len(fit.model.effects))[:-1], 2.0)
    model = replace(fit.model, stretch=stretch)
    again = refine(model, target, model.to_unit(fit.params), 0.1, rng, num_events=effort.least)
    return again, [f"the bound of {effect.name}: {effect.parameters[0].name} was doubled, since the fit ended there"]
