"""The loop: detect, localise, name, add and refit, show; again until nothing significant is left or nothing helps."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import GAP, Effort, effort_for, first, usual
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.method import Inferred
from avobench.diagnosis.fit.null import best_null, fit_null
from avobench.diagnosis.goodness_of_fit.held_out import SHARE, HeldOut
from avobench.diagnosis.goodness_of_fit.order import order, projections
from avobench.diagnosis.goodness_of_fit.summary import HOPELESS
from avobench.diagnosis.progress import Progress, Telling
from avobench.diagnosis.report.assemble import Result, Run, assemble
from avobench.diagnosis.report.correction import correction
from avobench.diagnosis.report.found import Found, gap_events
from avobench.diagnosis.report.identifiability import Row, card, card_events
from avobench.diagnosis.report.notes import notes_of
from avobench.diagnosis.report.pictures import pictures
from avobench.diagnosis.report.quoted import Move
from avobench.diagnosis.schema import Disorder, Region, Verdict
from avobench.diagnosis.search.posterior import Posterior
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
    before, target, inferred = begun(task, seen, fit, alpha, rng, effort, telling, meter)
    held_out = HeldOut.of(target, aside)
    sparing, later = Sparing(meter, notes), card_events(effects, effort) + 2 * cut

    steps, posterior = [before], None
    if before.p_value < alpha:
        telling.begin("search", usual(domain(task), cut) if num_simulations is None else 0)
        search = Search(target, seen, effects, max_effects, rng, effort, jobs, telling)
        with meter.keeping(later + gap_events(effort)):
            steps, posterior = searched(search, before, sparing)

    telling.begin("checks")
    found = Found.of(task, target, seen, held_out, steps, posterior, alpha, rng, effort)
    last, moves, where, could = shown(found, effects, sparing, later, rng, effort)
    drawn = pictures(seen, target, found.first, last if found.effects else None, task.labels)
    weights = None
    if found.verdict in (Verdict.REDUCED, Verdict.UNEXPLAINED):
        weights = sparing.made(lambda: correction(last, target, seen, rng), None, "the correction")
    notes += notes_of(found, last, inferred, Run(len(x), meter.used, num_simulations))
    run = Run(len(x), meter.used, num_simulations, perf_counter() - started, seed)
    return Result(task, assemble(found, last, moves, where, could, notes, run, disorder), last, drawn, weights)


@dataclass(frozen=True)
class Sparing:
    """Makes what the simulated events that are left suffice for, and notes what they do not."""

    meter: Meter
    notes: list[str]

    def made(self, make: Callable[[], T], else_: T, what: str) -> T:
        """What `make` makes of simulated events, if enough are left; else a note says so."""
        try:
            return make()
        except BudgetExhausted:
            self.notes.append(f"{self.meter.limit} simulated events did not suffice for {what}")
            return else_


def begun(
    task: Task,
    x: NDArray,
    fit: str,
    alpha: float,
    rng: np.random.Generator,
    effort: Effort,
    telling: Telling,
    meter: Meter,
) -> tuple[Step, Target, Inferred | None]:
    """Detect: theta is fitted to events x (N, d), and all gates see whether it describes them.

    Returns the model before the gates, what was fitted, and theta by the method `fit`, if it is one. Raises UsageError
    where the meter does not allow enough simulated events.
    """
    try:
        inferred = None
        if fit != "surrogate":
            inferred = Inferred.by(fit, task, x, meter.limit and meter.limit // METHOD_SHARE, rng)
            meter.charge(inferred.num_simulations)
        events: Counted | Pool = Counted(task, meter)
        if task.generates:
            events = Pool(task, int(max(effort.generated * len(x), effort.least)), rng.spawn(1)[0], meter)
        model = Model(task, events=events)
        with meter.keeping(GAP * effort.covariance):
            before, target = detect(model, x, inferred and inferred.centre(model), alpha, rng, effort, telling)
    except BudgetExhausted as error:
        raise UsageError(
            f"{meter.limit} simulated events did not suffice for the first fit and the gates; allow {2 * meter.limit}"
        ) from error
    return before, target, inferred


def searched(search: Search, before: Step, sparing: Sparing) -> tuple[list[Step], Posterior | None]:
    """Name, add and refit: all sets of effects that may be missing are weighed, and the most probable one is added.

    Returns the steps, of which the first is that `before`, and how probable which effects are, if any was weighed.
    """
    meter, notes = sparing.meter, sparing.notes
    posterior = search.posterior(before.fit)
    if meter.refused:
        notes.append(f"the search ended early: {meter.limit} simulated events did not suffice")
    if not posterior or not (named := posterior.named):
        return [before], posterior
    what = "the fit of what was found, which is left out"
    refit = sparing.made(lambda: added(named.fit, search.target, search.x, search.rng, search.effort, notes), [], what)
    return [before, *refit], posterior


def shown(
    found: Found, effects: list[Effect], sparing: Sparing, later: int, rng: np.random.Generator, effort: Effort
) -> tuple[Fit, list[Move], list[Region], list[Row]]:
    """Localise, and show: the final fit, how far theta may be from it, where the disagreement is, and the card.

    So many events as are to come `later` are kept from what theta may be.
    """
    last = sparing.made(lambda: found.last(rng, effort), found.steps[-1].fit, "the last step of the fit")
    with sparing.meter.keeping(later):
        what = "theta with other effects or shapes: its error may be too small"
        moves = sparing.made(lambda: found.moves(last, rng, effort), [], what)
    where = found.regions(rng)
    model = found.steps[-1]
    level = found.alpha * model.shares["summary"]
    could = sparing.made(lambda: card(model.fit, found.target, effects, level, rng, effort), [], "the card")
    return last, moves, where, could


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
