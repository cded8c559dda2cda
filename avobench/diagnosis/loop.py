"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

import time
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.budget import MeteredSimulator, pose
from avobench.diagnosis.answer.identifiability import card
from avobench.diagnosis.answer.pictures import pictures
from avobench.diagnosis.answer.quoted import ambiguity, found_effect, identified, named, theta_values
from avobench.diagnosis.effort import Effort, effort_for
from avobench.diagnosis.fit.fit import Fit, polish, refine, scan, settled
from avobench.diagnosis.gates.classifier import correction
from avobench.diagnosis.gates.regions import regions
from avobench.diagnosis.gates.summary import HOPELESS, target_of
from avobench.diagnosis.schema import Candidate, Diagnosis, Gap, Identifiable, Verdict
from avobench.diagnosis.search.search import STILL, Search
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.bins import Summary, bins_of
from avobench.diagnosis.summary.pixels import pixels_of
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted, Pool
from avobench.methods import Estimate
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

LEAST_EVENTS = 50
HELD_OUT = 0.25
"""Share of the measured events kept aside: no fit or test sees them; the gap is measured on them, and they may veto."""
FEW_EVENTS = 1000
METHOD_EVENTS = 160_000
"""The budget of a registered method that looks for theta, as in the benchmark."""
FAINT = 10.0
"""Chi-squared per degree of freedom below which, in the challenge, effects that were taken out of the catalogue were
often explained by others, and above which they seldom were (docs/challenge.md)."""
SCANS = 2
"""From which theta is fitted again before a disagreement is believed."""


def summary_of(task: Task, x: NDArray, simulated: NDArray) -> Summary:
    """The summary that suits these measured and simulated events."""
    return pixels_of(x, simulated, task.event_shape) if task.event_shape else bins_of(x, simulated)


def fit_null(
    model: Model, x: NDArray, rng: np.random.Generator, effort: Effort, centre: NDArray[np.float64] | None
) -> tuple[Fit, Target]:
    """Fit theta to events x (N, d), first with bins of the measured events, then with bins that suit both.

    The search begins at `centre` (p,) in the unit cube, or everywhere.
    """
    target, others = target_of(x, summary_of(model.task, x, x), x), x[:0]
    if target.rank == 0:  # measured events are all in one bin: bins beside it take simulated ones
        others = model.simulate(model.from_unit(rng.random((len(x), model.dim))), rng)
        target = target_of(x, summary_of(model.task, x, others), others)
    near = 0.03
    if centre is None:
        centre, near = scan(model, target, rng, size=effort.scan)
    per_round = max(effort.least, int(effort.rounds * len(x)))
    fit = refine(model, target, centre, np.maximum(near, 0.005), rng, num_events=per_round)
    simulated = np.concatenate([model.simulate(np.tile(fit.params, (len(x), 1)), rng), others])
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
    return method.infer(pose(task, x, simulate), rng.spawn(1)[0]), simulate


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
    order = rng.permutation(len(x))
    cut = len(x) - int(HELD_OUT * len(x))
    seen, aside = x[order[:cut]], x[order[cut:]]

    effort = effort_for(task, domain(task), num_simulations)
    events: Counted | Pool = Counted(task)
    if task.generates:
        events = Pool(task, int(max(effort.generated * len(seen), effort.least)), rng.spawn(1)[0])
    model, centre, estimate, spent = Model(task, events=events), None, None, 0
    if fit != "surrogate":
        estimate, simulate = inferred(task, fit, seen, num_simulations or METHOD_EVENTS, rng)
        centre, spent = model.to_unit(np.clip(estimate.theta, model.low, model.high)), simulate.used
    null, target = fit_null(model, seen, rng, effort, centre)
    aside_mean = target.summary.mean(aside)[0]

    def gap(of: Fit) -> Gap:
        return held_out_gap(of, target, aside_mean, len(aside))

    before = None if null.p_value < HOPELESS else Step.of(null, target, seen, rng, effort)
    if before is None or before.p_value < alpha:  # a fit that went astray looks like a missing effect
        tried = [null] if before is None else [null, before.own]
        before = Step.of(best_without(tried, target, rng, effort), target, seen, rng, effort)
    steps, notes, disagree = [before], [], before.p_value < alpha
    if disagree:
        search = Search(target, seen, aside_mean, len(aside), effects, alpha, max_effects, rng, effort, jobs)
        steps, notes = search.steps_from(before)

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
    if num_simulations is not None and events.used + spent > 2 * num_simulations:
        notes.append(
            f"no diagnosis of {len(x)} events takes much fewer simulated events than these {events.used + spent}"
        )
    if estimate is not None:
        notes.append(_method_note(fit, task, estimate, first))
    if len(x) < FEW_EVENTS:
        notes.append(f"{len(x)} events make {target.rank} bins or less: the card says what so few cannot show")
    notes += _bound_notes(last)
    names = task.labels
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
        regions=regions(steps[0].fit, target, seen, rng, alpha, () if domain(task) == "counts" else names)
        if disagree
        else [],
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
            for row in card(final.fit, target, effects, alpha * final.shares["summary"], rng, effort)
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
        refine(model, target, start, np.maximum(near, 0.005), rng, num_events=per_round) for start, near in starts
    ]
    # The lowest of a few values is low by chance: it is simulated anew, and that counts.
    best = min(fits, key=lambda fit: fit.gap)
    return polish(best, target, rng, int(effort.polish * target.num_events))


def _method_note(name: str, task: Task, estimate: Estimate, fit: Fit) -> str:
    """What a method found beside the fit: a proposal much wider than the error warns that the model is wrong."""
    parts = [
        f"{p} = {theta:.4g} with a {estimate.spread_of} of width {width:.2g}, {width / error:.1f} errors of the fit"
        for p, theta, width, error in zip(task.parameter_names, estimate.theta, estimate.std, fit.std, strict=False)
    ]
    return f"{name} found {'; '.join(parts)}"


def _bound_notes(fit: Fit) -> list[str]:
    names = [*fit.model.task.parameter_names, *(f"{e.name}: {p.name}" for e in fit.model.effects for p in e.parameters)]
    ends = {1: "upper", -1: "lower"}
    return [
        f"the fit ended at the {ends[at]} bound of {n}"
        for n, at in zip(names, fit.at_bound.tolist(), strict=True)
        if at
    ]
