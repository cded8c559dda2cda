"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

from collections.abc import Callable
from time import perf_counter
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.answer.assemble import Result, Run, assemble
from avobench.diagnosis.answer.correction import correction
from avobench.diagnosis.answer.found import Found, gap_events
from avobench.diagnosis.answer.identifiability import card, card_events
from avobench.diagnosis.answer.notes import notes_of
from avobench.diagnosis.answer.pictures import pictures
from avobench.diagnosis.effort import GAP, USUAL, USUAL_EVENTS, Effort, effort_for, first
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.method import Inferred
from avobench.diagnosis.fit.null import best_null, fit_null
from avobench.diagnosis.gates.held_out import SHARE, HeldOut
from avobench.diagnosis.gates.order import order, projections
from avobench.diagnosis.gates.summary import HOPELESS
from avobench.diagnosis.progress import Progress, Telling
from avobench.diagnosis.schema import Disorder, Verdict
from avobench.diagnosis.search.search import Search, refined
from avobench.diagnosis.search.tested import Step
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted, Pool
from avobench.tasks import Task
from avobench.tasks.errors import BudgetExhausted, UsageError
from avobench.tasks.meter import Meter

LEAST_EVENTS = 50
"""Measured events below which there are no bins to speak of."""
MOST_EVENTS = 2_000_000
"""Measured events that are compared, a random sample of more: its errors are far below what a simulator is trusted to,
and it bounds memory and time."""
METHOD_SHARE = 4
"""One in so many of the simulated events is for a method that looks for theta first, at most."""
T = TypeVar("T")


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
    ordered: bool = False,
    time: NDArray[np.float64] | None = None,
    progress: Progress | None = None,
) -> Result:
    """Compare measured events x (N, d) with a task, and say what it lacks.

    `ordered` asks whether their order, or that of their `time` (N,), matters. `progress` is told how far it is. Raises
    UsageError for too few events, for fewer `num_simulations` than the first fit takes, and for impossible settings.
    """
    started = perf_counter()
    if len(x) < LEAST_EVENTS:
        raise UsageError(f"a diagnosis needs at least {LEAST_EVENTS} events, got {len(x)}")
    if not 0 < alpha < 1:
        raise UsageError(f"alpha must lie between 0 and 1, got {alpha}")
    rng = np.random.default_rng(seed)
    effects = catalogue(task) if effects is None else effects
    x, position, notes = sampled(x, time, seed)
    along: Literal["index", "time"] = "index" if time is None else "time"
    disorder = None
    if ordered or time is not None:
        disorder = in_order(task, x, position, along, alpha, seed)
    shuffled = rng.permutation(len(x))
    cut = len(x) - int(SHARE * len(x))
    seen, aside = x[shuffled[:cut]], x[shuffled[cut:]]
    effort = effort_for(task, domain(task), num_simulations, cut)
    telling = Telling(progress, first(effort, task, cut) // 2)
    meter = Meter(num_simulations, telling)
    try:
        inferred = None
        if fit != "surrogate":
            inferred = Inferred.by(fit, task, seen, num_simulations and num_simulations // METHOD_SHARE, rng)
            meter.charge(inferred.num_simulations)
        events: Counted | Pool = Counted(task, meter)
        if task.generates:
            events = Pool(task, int(max(effort.generated * cut, effort.least)), rng.spawn(1)[0], meter)
        model = Model(task, events=events)

        # Detect: theta is fitted, and all gates see whether it describes the events.
        with meter.keeping(GAP * effort.covariance):
            before, target = detect(model, seen, inferred and inferred.centre(model), alpha, rng, effort, telling)
    except BudgetExhausted as error:
        raise UsageError(
            f"{num_simulations} simulated events did not suffice for the first fit and the gates; allow "
            f"{2 * num_simulations}"
        ) from error
    held_out = HeldOut.of(target, aside)

    def unless_exhausted(made: Callable[[], T], else_: T, what: str) -> T:
        """What is made of simulated events, if enough are left; else a note says so."""
        try:
            return made()
        except BudgetExhausted:
            notes.append(f"{num_simulations} simulated events did not suffice for {what}")
            return else_

    # Name, add and refit: all sets of effects that may be missing are weighed, and the most probable one is added.
    steps, posterior, later = [before], None, card_events(effects, effort) + 2 * cut
    if before.p_value < alpha:
        telling.begin("search", USUAL[domain(task)] * max(cut // USUAL_EVENTS, 1) if num_simulations is None else 0)
        with meter.keeping(later + gap_events(effort)):
            posterior = Search(target, seen, effects, max_effects, rng, effort, jobs, telling).posterior(before.fit)
            if meter.refused:
                notes.append(f"the search ended early: {num_simulations} simulated events did not suffice")
            if named := posterior.named:
                what = "the fit of what was found, which is left out"
                steps += unless_exhausted(lambda: added(named.fit, target, seen, rng, effort, notes), [], what)

    # Localise, and show: the values with their errors, where the disagreement is, what could not have been seen.
    telling.begin("checks")
    found = Found.of(task, target, seen, held_out, steps, posterior, alpha, rng, effort)
    last = unless_exhausted(lambda: found.last(rng, effort), found.steps[-1].fit, "the last step of the fit")
    with meter.keeping(later):
        what = "theta with other effects or shapes: its error may be too small"
        moves = unless_exhausted(lambda: found.moves(last, rng, effort), [], what)
    where = found.regions(rng)
    model = found.steps[-1]
    level = alpha * model.shares["summary"]
    could = unless_exhausted(lambda: card(model.fit, target, effects, level, rng, effort), [], "the card")
    drawn = pictures(seen, target, found.first, last if found.effects else None, task.labels)
    unexplained = found.verdict in (Verdict.REDUCED, Verdict.UNEXPLAINED)
    weights = None
    if unexplained:
        weights = unless_exhausted(lambda: correction(last, target, seen, rng), None, "the correction")
    notes += notes_of(found, last, inferred, Run(len(x), meter.used, num_simulations))
    run = Run(len(x), meter.used, num_simulations, perf_counter() - started, seed)
    return Result(task, assemble(found, last, moves, where, could, notes, run, disorder), last, drawn, weights)


def added(
    fit: Fit, target: Target, x: NDArray, rng: np.random.Generator, effort: Effort, notes: list[str]
) -> list[Step]:
    """The model that was found, fitted with more events and before the gates; adds to the `notes`."""
    fit, more = refined(fit, target, rng, effort)
    notes += more
    return [Step.of(fit, target, x, rng, effort)]


def sampled(x: NDArray, time: NDArray[np.float64] | None, seed: int) -> tuple[NDArray, NDArray[np.float64], list[str]]:
    """Events x (N, d), or MOST_EVENTS of them in their order; the place or time of each (n,); and notes."""
    position = np.arange(len(x), dtype=float) if time is None else time
    if len(x) <= MOST_EVENTS:
        return x, position, []
    rows = np.random.default_rng([seed, len(x)]).choice(len(x), MOST_EVENTS, replace=False, shuffle=False)
    rows.sort()
    return (
        x[rows],
        position[rows],
        [f"a random {MOST_EVENTS} of the {len(x)} events were compared: see docs/diagnosis.md"],
    )


def in_order(
    task: Task, x: NDArray, position: NDArray[np.float64], along: Literal["index", "time"], alpha: float, seed: int
) -> list[Disorder]:
    """What contradicts that events x (N, d) at these positions (N,) are exchangeable, with random numbers of its own:
    all else is as without it."""
    features = projections(x, () if x.shape[1] == 1 and domain(task) == "counts" else task.labels, task.event_shape)
    return order(features, position, along, alpha, np.random.default_rng([seed, 1]))


def detect(
    model: Model,
    x: NDArray,
    centre: NDArray[np.float64] | None,
    alpha: float,
    rng: np.random.Generator,
    effort: Effort,
    telling: Telling | None = None,
) -> tuple[Step, Target]:
    """The model before the gates, theta fitted to events x (N, d) from `centre` (p,) or wherever; and what was fitted.

    Where it is rejected theta is fitted again: a fit that went astray looks like a missing effect.
    """
    null, target = fit_null(model, x, rng, effort, centre)
    if telling is not None:
        telling.begin("gates")
    before = None if null.p_value < HOPELESS else Step.of(null, target, x, rng, effort)
    if before is None or before.p_value < alpha:
        tried = [null] if before is None else [null, before.own]
        before = Step.of(best_null(tried, target, rng, effort), target, x, rng, effort)
    return before, target
