"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.bench.errors import UsageError
from avobench.diagnosis.classifier import classifier_gate, correction
from avobench.diagnosis.detect import summary_gate, target_of
from avobench.diagnosis.effects import Effect
from avobench.diagnosis.effects.catalogue import catalogue
from avobench.diagnosis.fit import Fit, Target, refine, scan
from avobench.diagnosis.identifiability import card
from avobench.diagnosis.localise import intervals, significant
from avobench.diagnosis.model import Model
from avobench.diagnosis.name import candidates
from avobench.diagnosis.pictures import spectra
from avobench.diagnosis.rank import Ranked, ranking, tied
from avobench.diagnosis.schema import (
    Candidate,
    Diagnosis,
    EffectValue,
    FoundEffect,
    Gap,
    Gate,
    Identifiable,
    Named,
    Region,
    Value,
    Verdict,
)
from avobench.diagnosis.summary import Bins, bins_of
from avobench.tasks import Task

LEAST_EVENTS = 50
HELD_OUT = 0.25
"""Share of the measured events kept aside: no fit, test or choice sees them, only the gap is measured on them."""
GATES = {"summary": 0.8, "classifier": 0.2}
"""Each gate's share of the false alarms. Most effects show in the summary."""
POLISH = 12
"""Simulated events a measured one, where a p-value is at stake: simulation then adds a tenth to the variance."""
ROUND = 3
"""The same in each round of the first fit."""
CLOSES = 0.5
"""Share of the gap that an effect must close to be named."""
PAIR_LEAVES, PAIR_ALONE = 0.3, 0.2
"""A second effect must leave less of what the first left, and close more of the whole gap by itself."""
ENOUGH = 0.9
"""With so much closed by the first, what is left is put down to its shape, not to a second effect."""


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

    @property
    def p_value(self) -> float:
        """Of both gates together: each has its share of the false alarms."""
        return min(1.0, *(self.gates[name].p_value / share for name, share in GATES.items()))


def fit_null(model: Model, x: NDArray, rng: np.random.Generator) -> tuple[Fit, Target]:
    """Fit theta to events x (N, d), first with bins of the measured events, then with bins that suit both."""
    target = target_of(x, bins_of(x, x), x)
    centre, near = scan(model, target, rng)
    per_round = max(30_000, ROUND * len(x))
    fit = refine(model, target, centre, max(near, 0.005), rng, num_events=per_round)
    simulated = model.simulate(np.tile(fit.params, (len(x), 1)), rng)
    target = target_of(x, bins_of(x, simulated), simulated)
    return refine(model, target, fit.unit, 0.005, rng, num_events=per_round), target


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
    events = Counted(task)
    order = rng.permutation(len(x))
    cut = len(x) - int(HELD_OUT * len(x))
    seen, aside = x[order[:cut]], x[order[cut:]]

    notes: list[str] = []
    null, target = fit_null(Model(task, events=events), seen, rng)
    aside_mean = target.summary.mean(aside)[0]

    def gap(of: Fit) -> Gap:
        return held_out_gap(of, target, aside_mean, len(aside))

    steps = [_tested(null, target, seen, rng)]
    before = steps[0]
    disagree = before.p_value < alpha
    if disagree:
        base = refine(null.model, target, before.own.unit, 0.005, rng, num_events=4 * len(seen))
        steps[0] = replace(before, fit=base)
        while len(steps) <= max_effects and steps[-1].p_value < alpha:
            last = steps[-1]
            used = {e.key for e in last.fit.model.effects}
            fits = candidates(last.fit, target, [e for e in effects if e.key not in used], seen, rng, jobs=jobs)
            steps[-1] = replace(last, ranks=ranking(fits, base.gap))
            chosen = _accepted(steps, gap)
            if chosen is None:
                break
            steps.append(_tested(chosen, target, seen, rng))

    final = steps[-1]
    named_any = len(steps) > 1
    if not disagree:
        verdict = Verdict.NOTHING
    elif not named_any:
        verdict = Verdict.UNEXPLAINED
    else:
        verdict = Verdict.NAMED if final.p_value >= alpha else Verdict.REDUCED

    names = feature_names(task)
    diagnosis = Diagnosis(
        verdict=verdict,
        alpha=alpha,
        p_value_before=before.p_value,
        p_value_after=final.p_value if named_any else None,
        gates=before.gates,
        gap_before=gap(before.own),
        gap_after=gap(final.own) if named_any else None,
        theta_before=theta_values(before.own),
        theta_after=theta_values(final.own) if named_any else None,
        effects=[found_effect(final.own, k, tied(step.ranks), names) for k, step in enumerate(steps[:-1])],
        regions=regions(steps[0].fit, target, seen, rng, alpha, names) if disagree else [],
        candidates=[
            Candidate(
                **named(entry.effect, names).model_dump(),
                score=entry.score,
                p_value=float(chi2.sf(entry.fit.q, entry.fit.dof)),
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
            for row in card(final.fit, target, effects, alpha, rng)
        ],
        notes=notes,
        num_events=len(x),
        num_simulations=events.used,
        seconds=time.perf_counter() - started,
        seed=seed,
        versions={name: version(name) for name in ("avobench", "numpy", "scipy", "scikit-learn")},
    )
    diagnosis._model = final.own
    diagnosis._pictures = spectra(seen, target, before.own, final.own if named_any else None, names)
    if verdict in (Verdict.REDUCED, Verdict.UNEXPLAINED):
        diagnosis._correction = correction(final.own, seen, rng)
    return diagnosis


def _tested(fit: Fit, target: Target, x: NDArray, rng: np.random.Generator) -> Step:
    """A fitted model before both gates."""
    gate, own, own_target = summary_gate(fit, target, rng, POLISH * len(x))
    return Step(fit, own, {"summary": gate, "classifier": classifier_gate(own, own_target, x, rng)})


def _accepted(steps: list[Step], gap: Callable[[Fit], Gap]) -> Fit | None:
    """The first of the last step's ranks, if it may be added to the model."""
    last = steps[-1]
    if not last.ranks:
        return None
    best = last.ranks[0]
    if gap(best.fit).value >= gap(last.fit).value:
        return None

    def excess(fit: Fit) -> float:
        return max(fit.gap - fit.dof, 0.0)

    whole = excess(steps[0].fit)
    if len(steps) == 1:
        return best.fit if excess(best.fit) < (1 - CLOSES) * whole else None
    if excess(last.fit) < (1 - ENOUGH) * whole or excess(best.fit) > PAIR_LEAVES * excess(last.fit):
        return None
    alone = {entry.effect.key: entry.fit for entry in steps[0].ranks}
    single = alone.get(best.effect.key)
    return best.fit if single and whole - excess(single) > PAIR_ALONE * whole else None


def feature_names(task: Task) -> tuple[str, ...]:
    """(d,)"""
    return task.feature_names or tuple(f"x{j + 1}" for j in range(task.num_features))


def named(effect: Effect, names: tuple[str, ...]) -> Named:
    feature = effect.feature
    return Named(name=effect.name, feature=names[feature] if isinstance(feature, int) else feature)


def scaled_std(fit: Fit) -> NDArray[np.float64]:
    """Standard errors (P,), larger where the model does not describe the events."""
    return fit.std * np.sqrt(max(1.0, fit.q / fit.dof))


def theta_values(fit: Fit) -> dict[str, Value]:
    std = scaled_std(fit)
    return {
        name: Value(value=float(fit.params[i]), std=float(std[i]))
        for i, name in enumerate(fit.model.task.parameter_names)
    }


def found_effect(fit: Fit, k: int, ties: list[Ranked], names: tuple[str, ...]) -> FoundEffect:
    """The k-th effect of a fitted model."""
    effect = fit.model.effects[k]
    start = fit.model.num_theta + sum(len(e.parameters) for e in fit.model.effects[:k])
    std = scaled_std(fit)
    parameters = {
        p.name: EffectValue(value=float(fit.params[start + i]), std=float(std[start + i]), null=p.null, unit=p.unit)
        for i, p in enumerate(effect.parameters)
    }
    return FoundEffect(
        **named(effect, names).model_dump(), parameters=parameters, tied_with=[named(t.effect, names) for t in ties]
    )


def regions(
    fit: Fit, target: Target, x: NDArray, rng: np.random.Generator, alpha: float, names: tuple[str, ...]
) -> list[Region]:
    """Intervals of the features in which measured and simulated events disagree."""
    summary = target.summary
    assert isinstance(summary, Bins)
    starts = np.cumsum([0, *(bins for _, bins in summary.blocks)])
    single = [(int(starts[j]), len(e) + 1) for j, e in enumerate(summary.edges)]
    found = significant(intervals(fit, target, single), fit, rng, alpha)
    result = []
    for feature, first, last, z, p in found:
        column = x[:, feature]
        ends = np.concatenate([[column.min()], summary.edges[feature], [column.max()]])
        kind = "excess" if z > 0 else "deficit"
        name = names[feature] if len(summary.edges) > 1 else None
        result.append(
            Region(feature=name, low=float(ends[first]), high=float(ends[last + 1]), kind=kind, z=z, p_global=p)
        )
    return result
