"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

import time

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.answer.assemble import Result, Run, assemble
from avobench.diagnosis.answer.correction import correction
from avobench.diagnosis.answer.found import Found
from avobench.diagnosis.answer.identifiability import card
from avobench.diagnosis.answer.notes import notes_of
from avobench.diagnosis.answer.pictures import pictures
from avobench.diagnosis.effort import Effort, effort_for
from avobench.diagnosis.fit.method import Inferred
from avobench.diagnosis.fit.null import best_null, fit_null
from avobench.diagnosis.gates.held_out import SHARE, HeldOut
from avobench.diagnosis.gates.summary import HOPELESS
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search.search import Search, refined
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted, Pool
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

LEAST_EVENTS = 50
"""Measured events below which there are no bins to speak of."""


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
) -> Result:
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
    cut = len(x) - int(SHARE * len(x))
    seen, aside = x[order[:cut]], x[order[cut:]]
    effort = effort_for(task, domain(task), num_simulations)
    events: Counted | Pool = Counted(task)
    if task.generates:
        events = Pool(task, int(max(effort.generated * len(seen), effort.least)), rng.spawn(1)[0])
    model = Model(task, events=events)

    # Detect: theta is fitted, and all gates see whether it describes the events.
    inferred = None if fit == "surrogate" else Inferred.by(fit, task, seen, num_simulations, rng)
    before, target = detect(model, seen, inferred and inferred.centre(model), alpha, rng, effort)
    held_out = HeldOut.of(target, aside)

    # Name, add and refit: all sets of effects that may be missing are weighed, and the most probable one is added.
    steps, notes, posterior = [before], [], None
    if before.p_value < alpha:
        posterior = Search(target, seen, effects, max_effects, rng, effort, jobs).posterior(before.fit)
        if posterior.named:
            fit, notes = refined(posterior.named.fit, target, rng, effort)
            steps.append(Step.of(fit, target, seen, rng, effort))

    # Localise, and show: the values with their errors, where the disagreement is, what could not have been seen.
    found = Found.of(task, target, seen, held_out, steps, posterior, alpha, rng, effort)
    last = found.last(rng, effort)
    spent = inferred.num_simulations if inferred else 0
    notes += notes_of(found, last, inferred, Run(len(x), events.used + spent, num_simulations))
    moves = found.moves(last, rng, effort)
    where = found.regions(rng)
    model = found.steps[-1]
    could = card(model.fit, target, effects, alpha * model.shares["summary"], rng, effort)
    run = Run(len(x), events.used + spent, num_simulations, time.perf_counter() - started, seed)
    diagnosis = assemble(found, last, moves, where, could, notes, run)
    drawn = pictures(seen, target, found.first, last if found.effects else None, task.labels)
    unexplained = found.verdict in (Verdict.REDUCED, Verdict.UNEXPLAINED)
    return Result(task, diagnosis, last, drawn, correction(last, target, seen, rng) if unexplained else None)


def detect(
    model: Model, x: NDArray, centre: NDArray[np.float64] | None, alpha: float, rng: np.random.Generator, effort: Effort
) -> tuple[Step, Target]:
    """The model before the gates, theta fitted to events x (N, d) from `centre` (p,) or wherever; and what was fitted.

    Where it is rejected theta is fitted again: a fit that went astray looks like a missing effect.
    """
    null, target = fit_null(model, x, rng, effort, centre)
    before = None if null.p_value < HOPELESS else Step.of(null, target, x, rng, effort)
    if before is None or before.p_value < alpha:
        tried = [null] if before is None else [null, before.own]
        before = Step.of(best_null(tried, target, rng, effort), target, x, rng, effort)
    return before, target
