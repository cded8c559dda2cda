"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.budget import MeteredSimulator
from avobench.bench.errors import UsageError
from avobench.bench.problem import Problem
from avobench.diagnosis.classifier import classifier_gate, correction
from avobench.diagnosis.detect import HOPELESS, cell_gate, summary_gate, target_of
from avobench.diagnosis.effects import Effect
from avobench.diagnosis.effects.catalogue import catalogue, domain
from avobench.diagnosis.effort import Effort, effort_for
from avobench.diagnosis.fit import Base, Fit, Target, polish, refine, scan, settled
from avobench.diagnosis.identifiability import card
from avobench.diagnosis.localise import intervals, significant
from avobench.diagnosis.model import Model
from avobench.diagnosis.name import CLOSES, candidates, clears_feature, reshaped
from avobench.diagnosis.pictures import pictures
from avobench.diagnosis.pixels import Pixels, pixels_of
from avobench.diagnosis.pool import Pool, TwoStage
from avobench.diagnosis.rank import TIE, Ranked, cost, ranking, tied
from avobench.diagnosis.schema import (
    Candidate,
    Diagnosis,
    Gap,
    Gate,
    Identifiable,
    Region,
    Verdict,
)
from avobench.diagnosis.summary import Bins, Summary, bins_of, closed
from avobench.diagnosis.values import ambiguity, feature_names, found_effect, identified, named, theta_values
from avobench.methods import Estimate
from avobench.tasks import Task

LEAST_EVENTS = 50
HELD_OUT = 0.25
"""Share of the measured events kept aside: no fit, test or choice sees them, only the gap is measured on them."""
SHARES = {"summary": 0.8, "classifier": 0.2}
IMAGE_SHARES = {"summary": 0.6, "cells": 0.2, "classifier": 0.2}
"""Each gate's share of the false alarms. Most effects show in the summary."""
FEW_EVENTS = 1000
METHOD_EVENTS = 160_000
"""The budget of a registered method that looks for theta, as in the benchmark."""
VETO = 2.5
"""Of the scatter of the events kept aside, in standard errors: a gap that grows on them by more vetoes an effect."""
STILL = 0.2
"""Of alpha: the level at which a model with an effect is still rejected: no shape of the catalogue is exactly right."""
FAINT = 10.0
"""Chi-squared per degree of freedom below which, in the challenge, effects that were taken out of the catalogue were
often explained by others, and above which they seldom were (docs/challenge.md)."""
PAIR_LEAVES, PAIR_CLEAR, PAIR_ALONE, CHANCE = 0.3, 0.1, 0.2, 1.65
"""A second effect must leave less than the first share of what the first effect left; unless it leaves less than the
second, it must close more than the third of the whole gap by itself, or have no rival, or leave no more than chance: so
many standard deviations of chi-squared. A third must have no rival, nor a second where the first may be all."""
PARTNERS = 3
"""Effects to which a second one is added at once, where none alone closes enough."""
RIVALS = 3
"""Of the effects that may be the second, for which the first is tried in other shapes."""
SCANS = 2
"""From which theta is fitted again before a disagreement is believed."""
POOLED = 10
"""Generated events a measured one, where a slow generator is asked only once."""


class Counted:
    """The task's simulator, counting events."""

    def __init__(self, task: Task) -> None:
        self.task, self.used = task, 0

    def __call__(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        self.used += len(theta)
        return self.task.simulate(theta, rng)


@dataclass(frozen=True)
class Step:
    """A model of the loop, tested, and the candidates to come after it."""

    fit: Fit
    """In the metric of the loop's target."""
    own: Fit
    """In its own metric, with more events: what is reported."""
    gates: dict[str, Gate]
    ranks: list[Ranked] = field(default_factory=list)
    chosen: Ranked | None = None
    """The effect that comes after it, where that is not the first of the ranks."""
    rivals: tuple[Ranked, ...] = ()
    """Of that effect."""

    @property
    def added(self) -> Ranked:
        """The effect that comes after it."""
        return self.chosen or self.ranks[0]

    @property
    def ties(self) -> list[Ranked]:
        """Those that the effect which comes after it cannot be told from."""
        return list(self.rivals) if self.chosen else tied(self.ranks)

    @property
    def p_value(self) -> float:
        """Of both gates together: each has its share of the false alarms."""
        shares = IMAGE_SHARES if "cells" in self.gates else SHARES
        return min(1.0, *(gate.p_value / shares[name] for name, gate in self.gates.items()))


def summary_of(task: Task, x: NDArray, simulated: NDArray) -> Summary:
    """The summary that suits these measured and simulated events."""
    return pixels_of(x, simulated, task.event_shape) if task.event_shape else bins_of(x, simulated)


def fit_null(
    model: Model, x: NDArray, rng: np.random.Generator, effort: Effort, centre: NDArray[np.float64] | None
) -> tuple[Fit, Target]:
    """Fit theta to events x (N, d), first with bins of the measured events, then with bins that suit both.

    The search begins at `centre` (p,) in the unit cube, or everywhere.
    """
    target = target_of(x, summary_of(model.task, x, x), x)
    near = 0.03
    if centre is None:
        centre, near = scan(model, target, rng, size=effort.scan)
    per_round = max(effort.least, int(effort.rounds * len(x)))
    fit = refine(model, target, centre, max(near, 0.005), rng, num_events=per_round)
    simulated = model.simulate(np.tile(fit.params, (len(x), 1)), rng)
    target = target_of(x, summary_of(model.task, x, simulated), simulated)
    return refine(model, target, fit.unit, 0.005, rng, num_events=per_round), target


def inferred(
    task: Task, name: str, x: NDArray, num_events: int, rng: np.random.Generator
) -> tuple[Estimate, MeteredSimulator]:
    """What a registered method finds for theta, with the events that it may use."""
    method = registry.build("method", name, {})
    registry.require_packages("method", method)
    least = method.min_simulations(len(task.parameter_names))
    if num_events < least:
        raise UsageError(f"--fit {name} needs at least {least} simulated events, got {num_events}")
    simulate = MeteredSimulator(task, num_events, rng.spawn(1)[0])
    return method.infer(Problem.of(task, x, simulate), rng.spawn(1)[0]), simulate


def held_out_gap(fit: Fit, target: Target, mean: NDArray[np.float64], num_events: int) -> Gap:
    """Chi-squared per degree of freedom between a fitted model and the mean summary (K,) of events it never saw.

    1 is what is expected if the model is true: scatter of these events, and of the fit by measurement and simulation.
    """
    r = np.sqrt(num_events) * ((mean - fit.predicted) @ target.whitening)
    share = num_events / target.num_events
    ndf = target.rank * (1 + fit.noise * share) + fit.num_identified * share
    q = float(r @ r)
    spread = np.sqrt(2 * target.rank + 4 * max(q - target.rank, 0))
    return Gap(value=q / ndf, low=max(q - 1.96 * spread, 0) / ndf, high=(q + 1.96 * spread) / ndf)


def grew(new: Fit, old: Fit, target: Target, mean: NDArray[np.float64], num_events: int) -> bool:
    """Whether the gap to the mean summary (K,) of events kept aside grows from one fit to another beyond their scatter.

    If the new one is right, what it leaves of them is noise, also along the difference d of the two: normal, of
    variance 1 from these events, and their share of those that were fitted from the fit. The gap grows where it is
    below -|d| / 2, which chance alone brings about for a weak effect.
    """
    left, before = (np.sqrt(num_events) * ((mean - fit.predicted) @ target.whitening) for fit in (new, old))
    d = before - left
    error = np.sqrt(1 + (1 + new.noise + old.noise) * num_events / target.num_events)
    z = float(left @ d) / max(float(np.linalg.norm(d)) * error, 1e-12)
    return float(left @ left) > float(before @ before) and z < -VETO


def diagnose(
    task: Task,
    x: NDArray,
    *,
    seed: int = 0,
    alpha: float = 0.05,
    max_effects: int = 3,
    num_simulations: int | None = None,
    fit: str = "surrogate",
    effects: list[Effect] | None = None,
    jobs: int = 1,
) -> Diagnosis:
    """Compare measured events x (N, d) with a task, and say what it lacks.

    Raises UsageError for too few events or impossible settings.
    """
    started = time.perf_counter()
    if len(x) < LEAST_EVENTS:
        raise UsageError(f"a diagnosis needs at least {LEAST_EVENTS} events, got {len(x)}")
    if not 0 < alpha < 1:
        raise UsageError(f"alpha must lie between 0 and 1, got {alpha}")
    rng = np.random.default_rng(seed)
    effects = catalogue(task) if effects is None else effects
    order = rng.permutation(len(x))
    cut = len(x) - int(HELD_OUT * len(x))
    seen, aside = x[order[:cut]], x[order[cut:]]

    notes: list[str] = []
    effort = effort_for(task, domain(task), num_simulations)
    events: Counted | Pool = Counted(task)
    if isinstance(task, TwoStage):
        events = Pool(task, int(max(POOLED * len(seen), effort.least)), rng.spawn(1)[0])
    model, centre, estimate, spent = Model(task, events=events), None, None, 0
    if fit != "surrogate":
        estimate, simulate = inferred(task, fit, seen, num_simulations or METHOD_EVENTS, rng)
        centre, spent = model.to_unit(np.clip(estimate.theta, model.low, model.high)), simulate.used
    null, target = fit_null(model, seen, rng, effort, centre)
    aside_mean = target.summary.mean(aside)[0]

    def gap(of: Fit) -> Gap:
        return held_out_gap(of, target, aside_mean, len(aside))

    before = None if null.p_value < HOPELESS else _tested(null, target, seen, rng, effort)
    if before is None or before.p_value < alpha:  # a fit that went astray looks like a missing effect
        tried = [null] if before is None else [null, before.own]
        before = _tested(best_without(tried, target, rng, effort), target, seen, rng, effort)
    steps, disagree = [before], before.p_value < alpha
    if disagree:

        def search(fit: Fit, leaves: float, others: tuple[Fit, ...] = ()) -> tuple[list[Ranked], Base]:
            """Effects to add to a fit, best first; `others` are fits of its last effect in other shapes."""
            used, without = {e.key for e in fit.model.effects}, fit.gap
            free = [e for e in effects if e.key not in used]
            own = effort if not used else replace(effort, families=effort.families // 2)

            def hopeful(one: Fit) -> bool:
                return excess(one) - 2 * one.gap_error < leaves * excess(fit) or clears_feature(one, fit, target)

            options = {"hopeful": hopeful, "gap_without": without, "jobs": jobs}
            fits, known = candidates(fit, target, free, seen, rng, own, **options)
            ranks = ranking(fits, without)
            if ranks and others and excess(ranks[0].fit) > noise(ranks[0].fit):
                foremost = ranks[:1] + tied(ranks)[: RIVALS - 1]
                better = reshaped([entry.fit for entry in foremost], known, others, target, rng, effort)
                kept = [entry.fit for entry in ranks if all(entry is not one for one in foremost)]
                ranks = ranking([fit for fit, _ in better] + kept, without)
                known = next((base for fit, base in better if fit is ranks[0].fit), known)
            return ranks, known

        while len(steps) <= max_effects and steps[-1].p_value < alpha:
            rejected = len(steps) == 1 or steps[-1].p_value < STILL * alpha
            if not rejected and steps[-1].gates["summary"].p_value > alpha:
                break  # what only the classifier may see has no name
            if len(steps) == 1:
                ranks, known = search(steps[0].fit, 1 - CLOSES)
            else:
                ranks, known = search(steps[-1].fit, PAIR_LEAVES, steps[-2].added.others)
            steps[-1] = replace(steps[-1], ranks=ranks)
            worse = partial(grew, target=target, mean=aside_mean, num_events=len(aside))
            clears = partial(clears_feature, target=target)
            step = _accepted(steps, worse, clears, rejected)
            if rejected and len(steps) <= 2 <= max_effects and not _enough(steps, step, clears):
                pair = _pair(steps, search, worse)
                if pair and (step is None or cost(pair[0][-1].added.fit) < cost(step.added.fit)):
                    steps, known = pair
                    step = steps[-1]
            if step is None:
                break
            steps[-1], chosen = step, step.added.fit
            base = known if known.model.effects == chosen.model.effects[:-1] else None
            chosen, widened_note = widened(chosen, target, rng, effort)
            notes += widened_note
            refined = polish(chosen, target, rng, int(effort.again[-1] * len(seen)), rounds=8, base=base, exact=True)
            steps.append(_tested(min(refined, chosen, key=lambda f: f.gap), target, seen, rng, effort, base))

    final = steps[-1]
    named_any = len(steps) > 1
    if not disagree:
        verdict = Verdict.NOTHING
    elif not named_any:
        verdict = Verdict.UNEXPLAINED
    else:
        verdict = Verdict.NAMED if final.p_value >= STILL * alpha else Verdict.REDUCED

    # In its own metric a fit is efficient, but only where the model is right. Where it is wrong the two metrics want
    # different parameters, and the gap is measured in that of the loop.
    first = steps[0].fit if disagree else before.own
    last = first if not named_any else final.own
    if verdict == Verdict.REDUCED:
        last = settled(final.fit, target, rng, int(effort.polish * len(seen)), effort.settle)
    if verdict == Verdict.NAMED and gap(first).value < FAINT:
        notes.append(
            f"a gap of {gap(first).value:.2g} seldom excludes that an effect outside the catalogue did this: compare "
            "docs/challenge.md"
        )
    if estimate is not None:
        notes.append(_method_note(fit, task, estimate, first))
    if len(x) < FEW_EVENTS:
        notes.append(f"{len(x)} events make {target.rank} bins or less: the card says what so few cannot show")
    notes += _bound_notes(last)
    names = feature_names(task)
    many = int(effort.polish * len(seen))
    moves = [move for step in steps[:-1] for move in ambiguity(last, step.added, step.ties, target, rng, many)]
    diagnosis = Diagnosis(
        verdict=verdict,
        alpha=alpha,
        p_value_before=before.p_value,
        p_value_after=final.p_value if named_any else None,
        gates=before.gates,
        gap_before=gap(first),
        gap_after=gap(last) if named_any else None,
        theta_before=theta_values(first),
        theta_after=theta_values(last, moves) if named_any else None,
        identified_before=identified(first),
        identified_after=identified(last, moves) if named_any else None,
        effects=[found_effect(last, k, step.ties, names) for k, step in enumerate(steps[:-1])],
        regions=regions(steps[0].fit, target, seen, rng, alpha, names) if disagree else [],
        candidates=[
            Candidate(
                **named(entry.effect, names).model_dump(),
                score=entry.score,
                p_value=entry.fit.p_value,
                held_out_gap=gap(entry.fit).value,
            )
            for entry in steps[0].ranks
        ],
        identifiability=[
            Identifiable(
                **named(row.effect, names).model_dump(),
                retained=row.retained,
                minimum_detectable=row.minimum_detectable,
                theta_bias=dict(zip(task.parameter_names, map(float, row.theta_bias), strict=False)),
                rivals=[named(rival, names) for rival in row.rivals],
            )
            for row in card(final.fit, target, effects, alpha, rng, effort)
        ],
        notes=notes,
        num_events=len(x),
        num_simulations=events.used + spent,
        seconds=time.perf_counter() - started,
        seed=seed,
        versions={name: version(name) for name in ("avobench", "numpy", "scipy", "scikit-learn")},
    )
    diagnosis._model = last
    diagnosis._pictures = pictures(seen, target, first, last if named_any else None, names)
    if verdict in (Verdict.REDUCED, Verdict.UNEXPLAINED):
        diagnosis._correction = correction(last, target, seen, rng)
    return diagnosis


def best_without(tried: list[Fit], target: Target, rng: np.random.Generator, effort: Effort) -> Fit:
    """The task's own best fit where it does not describe the events, hence where the way to it may have been long.

    From where the fits that were tried ended, of which the first is in the target's metric, and from scans of the whole
    range.
    """
    first, *others = tried
    model, per_round = first.model, max(effort.least, int(effort.rounds * target.num_events))
    starts = [(fit.unit, 0.005) for fit in others] + [scan(model, target, rng, size=effort.scan) for _ in range(SCANS)]
    fits = [first] + [
        refine(model, target, start, max(near, 0.005), rng, num_events=per_round) for start, near in starts
    ]
    # The lowest of a few values is low by chance: it is simulated anew, and that counts.
    best = min(fits, key=lambda fit: fit.gap)
    return polish(best, target, rng, int(effort.polish * target.num_events))


def _tested(
    fit: Fit, target: Target, x: NDArray, rng: np.random.Generator, effort: Effort, base: Base | None = None
) -> Step:
    """A fitted model before all gates. `base` is the model without its last effect, if that is known well."""
    gate, own, own_target = summary_gate(fit, target, rng, effort, base)
    gates = {"summary": gate}
    if fit.model.task.event_shape:
        gates["cells"] = cell_gate(own, x, rng, effort)
    gates["classifier"] = classifier_gate(own, own_target, x, rng)
    return Step(fit, own, gates)


def _accepted(
    steps: list[Step], grew: Callable[[Fit, Fit], bool], clears: Callable[[Fit, Fit], bool], rejected: bool
) -> Step | None:
    """The last step with the effect that may be added to its model, the first of its ranks as a rule; None for none.

    Else the first that clears a feature which no effect acts on yet. `rejected`: whether the model without it must be
    wrong, not only may be.
    """
    last = steps[-1]
    if last.ranks and not grew(last.ranks[0].fit, last.fit) and _closes(steps, rejected):
        return last
    for entry in last.ranks:
        if clears(entry.fit, last.fit) and not grew(entry.fit, last.fit):
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
    left = excess(best.fit) / max(excess(last.fit), 1e-9)
    single = {entry.effect.key: entry.fit for entry in steps[0].ranks}.get(best.effect.key)
    alone = single is not None and whole - excess(single) > PAIR_ALONE * whole
    no_rival, no_more = not tied(last.ranks), excess(best.fit) < CHANCE * noise(best.fit)
    if (len(steps) > 2 or not rejected) and not no_rival:
        return False
    return left < PAIR_CLEAR or (left < PAIR_LEAVES and (alone or no_rival or no_more))


def _enough(steps: list[Step], step: Step | None, clears: Callable[[Fit, Fit], bool]) -> bool:
    """Whether no other pair need be looked for: there is an effect to add, and a second leaves no more than chance."""
    if step is None or len(steps) == 1:
        return step is not None
    fit = step.added.fit
    return clears(fit, step.fit) or excess(fit) < CHANCE * noise(fit)


def _pair(
    steps: list[Step], search: Callable[..., tuple[list[Ranked], Base]], grew: Callable[[Fit, Fit], bool]
) -> tuple[list[Step], Base] | None:
    """Two effects that together leave next to nothing, where none alone closes half of the gap.

    Or where one does, but a second beside it is not enough: the pair then begins with that second, or with another that
    the first was tied with. The steps up to the first of them, with the ranks that the second leads, and the model with
    the first alone.
    """
    null, whole = steps[0], excess(steps[0].fit)
    enough = PAIR_CLEAR * whole
    firsts = [entry for entry in null.ranks if 0 < excess(entry.fit) < (1 - PAIR_ALONE) * whole]
    if len(steps) > 1:
        enough = min(enough, PAIR_LEAVES * excess(steps[1].fit))
        second = [entry.effect.key for entry in steps[1].ranks[:1]]
        firsts = [e for e in firsts if e.effect.key in second or any(e is tie for tie in null.ties)]
    found = [(one, *search(one.fit, enough / excess(one.fit), one.others)) for one in firsts[:PARTNERS]]
    found = [(first, ranks, known) for first, ranks, known in found if ranks]
    if not found:
        return None
    found.sort(key=lambda each: cost(each[1][0].fit))
    first, ranks, known = found[0]
    best = ranks[0]
    if excess(best.fit) > enough or grew(best.fit, null.fit):
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
    if not (effect.parameters[0].soft and fit.at_bound[at]):
        return fit, []
    stretch = (*(fit.model.stretch or (1.0,) * len(fit.model.effects))[:-1], 2.0)
    model = replace(fit.model, stretch=stretch)
    again = refine(model, target, model.to_unit(fit.params), 0.1, rng, num_events=effort.least)
    return again, [f"the bound of {effect.name}: {effect.parameters[0].name} was doubled, since the fit ended there"]


def _method_note(name: str, task: Task, estimate: Estimate, fit: Fit) -> str:
    """What a method found beside the fit: a proposal much wider than the error warns that the model is wrong."""
    parts = [
        f"{p} = {theta:.4g} with a {estimate.spread_of} of width {width:.2g}, {width / error:.1f} errors of the fit"
        for p, theta, width, error in zip(task.parameter_names, estimate.theta, estimate.std, fit.std, strict=False)
    ]
    return f"{name} found {'; '.join(parts)}"


def _bound_notes(fit: Fit) -> list[str]:
    names = [*fit.model.task.parameter_names, *(f"{e.name}: {p.name}" for e in fit.model.effects for p in e.parameters)]
    return [f"the fit ended at the upper bound of {name}" for name, at in zip(names, fit.at_bound, strict=True) if at]


def regions(
    fit: Fit, target: Target, x: NDArray, rng: np.random.Generator, alpha: float, names: tuple[str, ...]
) -> list[Region]:
    """Intervals of the features in which measured and simulated events disagree.

    Of images intervals of rows, columns and the number of hits; rows and columns are counted from 0, ends included.
    """
    summary = target.summary
    spans: list[tuple[str | None, NDArray[np.float64]]] = []
    if isinstance(summary, Pixels):
        hits = (x > 0).sum(axis=1)
        spans = [(name, np.arange(length + 1) - 0.5) for name, length in summary.blocks[:2]]
        spans.append(("hits", closed(summary.fullness, hits)))
    elif isinstance(summary, Bins):
        for j, inner in enumerate(summary.edges):
            spans.append((names[j] if len(summary.edges) > 1 else None, closed(inner, x[:, j])))
    lengths = [len(ends) - 1 for _, ends in spans]
    starts = np.cumsum([0, *lengths[:-1]])
    scanned = intervals(fit, target, [(int(a), n) for a, n in zip(starts, lengths, strict=True)])
    return [
        Region(
            feature=spans[block][0],
            low=float(spans[block][1][first]),
            high=float(spans[block][1][last + 1]),
            kind="excess" if z > 0 else "deficit",
            z=z,
            p_global=p,
        )
        for block, first, last, z, p in significant(scanned, fit, rng, alpha)
    ]
