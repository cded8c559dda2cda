"""The diagnosis on one page: fit and test the simulator, search what it lacks, add that and refit, and report."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from avobench.bench.store.bank import KeptBank
from avobench.diagnosis.effort import (
    Effort,
    Phases,
    Progress,
    addition_events,
    effort_for,
    first_fit_events,
    usual_events,
)
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.null import Inferred, best_null, fit_null
from avobench.diagnosis.goodness_of_fit.gates import ExtendedModel, correction
from avobench.diagnosis.goodness_of_fit.held_out import HeldOut
from avobench.diagnosis.goodness_of_fit.order import exchangeability
from avobench.diagnosis.report.identifiability import card, card_events
from avobench.diagnosis.report.outcome import Outcome, notes_of
from avobench.diagnosis.report.result import Result, assemble, pictures
from avobench.diagnosis.report.uncertainties import QuotedFit, ambiguity
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.search.search import Search, refined
from avobench.diagnosis.settings import BUDGET, FIT, SCORE, TEST
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.bank import Bank, Given
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.tasks import Task
from avobench.tasks.errors import BudgetExhausted, UsageError
from avobench.tasks.meter import Meter
from avobench.tasks.sample import SampleTask


def diagnose(
    task: Task,
    x: NDArray,
    *,
    seed: int = 0,
    alpha: float = 0.05,
    max_effects: int = 3,
    num_simulations: int | None = None,
    num_spent: int = 0,
    fit: str = "surrogate",
    effects: list[Effect] | None = None,
    experience: bool = True,
    jobs: int = 1,
    ordered: bool = False,
    time: NDArray[np.float64] | None = None,
    progress: Progress | None = None,
    bank: Path | None = None,
) -> Result:
    """Compare measured events x (N, d) with a task, and say what it lacks.

    Of the `num_simulations` that are allowed, `num_spent` were spent before, on checks. Without `experience` the
    networks are not asked what the events look like. `ordered` asks whether the order of the events, or that of their
    `time` (N,), matters. `progress` is told how far it is. Simulated events are kept in the folder `bank`, and taken
    from there. Raises UsageError for too few events, for fewer `num_simulations` than the first fit takes, and for
    impossible settings.
    """
    started = perf_counter()
    if len(x) < BUDGET.least_events:
        raise UsageError(f"a diagnosis needs at least {BUDGET.least_events} events, got {len(x)}")
    if not 0 < alpha < 1:
        raise UsageError(f"alpha must lie between 0 and 1, got {alpha}")
    rng = np.random.default_rng(seed)
    effects = catalogue(task) if effects is None else effects
    x, position, notes = sampled(x, time, seed)
    order = None
    if ordered or time is not None:
        order = exchangeability(task, x, position, "index" if time is None else "time", alpha, seed)
    shuffled = rng.permutation(len(x))
    cut = len(x) - int(TEST.held_out_share * len(x))
    effort = effort_for(task, domain(task), num_simulations, cut, num_spent)
    phases = Phases(progress, first_fit_events(effort, task, cut) // 2)
    meter = Meter(num_simulations, phases)
    meter.add(num_spent)
    run = Run(task, x[shuffled[:cut]], len(x), effects, alpha, effort, rng, meter, phases, notes, jobs, bank)

    null, inferred = run.null_model(fit)
    extended, posterior = None, None
    if null.p_value < alpha:
        extended, posterior = run.extended_model(null, max_effects, experience)
    phases.begin("checks")
    held_out = HeldOut(run.target, run.target.summary.mean(x[shuffled[cut:]])[0], len(x) - cut)
    outcome = Outcome.of(null, extended, posterior, alpha, held_out, rng, effort)
    result = run.report(outcome, inferred)
    said = {"order": order, "seed": seed, "seconds": perf_counter() - started}
    return replace(result, diagnosis=result.diagnosis.model_copy(update=said))


@dataclass
class Run:
    """A diagnosis under way: the measured events, and what all of its steps share."""

    task: Task
    events: NDArray
    """The measured events that are fitted (n, d)."""
    num_events: int
    """Measured events, with those that are held out."""
    effects: list[Effect]
    """The effects that may be missing."""
    alpha: float
    effort: Effort
    rng: np.random.Generator
    meter: Meter
    phases: Phases
    notes: list[str]
    jobs: int = 1
    """Processes that simulate."""
    bank: Path | None = None
    """The folder in which simulated events are kept, and from which they are taken."""
    target: Target = field(init=False)
    """What is fitted of the events, once the null model was."""

    @contextmanager
    def affordable(self, what: str, required: bool = False) -> Iterator[None]:
        """Where the simulated events end, note that `what` is left out; raise UsageError if it is required."""
        try:
            yield
        except BudgetExhausted as error:
            note = f"{self.meter.limit} simulated events did not suffice for {what}"
            if required:
                raise UsageError(f"{note}; allow {2 * self.meter.limit}") from error
            self.notes.append(f"{note}.")

    @property
    def later(self) -> int:
        """Simulated events that are kept for the identifiability card and the correction."""
        return card_events(self.effects, self.effort) + 2 * len(self.events)

    def source(self, seed: int) -> Bank | Pool:
        """What stands for the simulator: whatever it makes is used again."""
        if isinstance(self.task, SampleTask):
            return Given(self.task, self.meter)
        if self.task.generates:
            size = int(max(self.effort.generated * len(self.events), self.effort.least))
            return Pool(self.task, size, np.random.default_rng(seed), self.meter)
        if self.bank is not None:
            return KeptBank(self.task, self.meter, seed, self.jobs, self.bank)
        return Bank(self.task, self.meter, seed, self.jobs)

    def null_model(self, method: str) -> tuple[ExtendedModel, Inferred | None]:
        """Fit theta, from where a registered `method` has it if it is one, and test whether that describes the events.

        Where it is rejected theta is fitted again: a fit that went astray looks like a missing effect.
        """
        task, x, rng, effort, inferred = self.task, self.events, self.rng, self.effort, None
        with self.affordable("the first fit and the tests", required=True):
            if method != "surrogate":
                inferred = Inferred.by(method, task, x, self.meter.limit and self.meter.limit // FIT.method_share, rng)
                self.meter.charge(inferred.num_simulations)
            model = Model(task, events=self.source(int(rng.integers(2**63))))
            with self.meter.keeping(BUDGET.gap * effort.covariance):
                fit, self.target = fit_null(model, x, rng, effort, inferred and inferred.centre(model))
                self.phases.begin("gates")
                null = None if fit.p_value < TEST.hopeless else self.tested(fit)
                if null is None or null.p_value < self.alpha:
                    tried = [fit] if null is None else [fit, null.efficient]
                    null = self.tested(best_null(tried, self.target, rng, effort))
        return null, inferred

    def tested(self, fit: Fit) -> ExtendedModel:
        """A fitted model with all tests of it."""
        return ExtendedModel.of(fit, self.target, self.events, self.rng, self.effort)

    def extended_model(
        self, null: ExtendedModel, max_effects: int, experience: bool
    ) -> tuple[ExtendedModel | None, Posterior | None]:
        """Weigh all sets of effects that may be missing, and add the most probable one; None where none is."""
        meter, target, n = self.meter, self.target, len(self.events)
        self.phases.begin("search", usual_events(domain(self.task), n) if meter.limit is None else 0)
        rng, effort = self.rng, self.effort
        search = Search(target, self.events, self.effects, max_effects, rng, effort, self.jobs, self.phases, experience)
        extended = None
        with meter.keeping(self.later + self.effort.gaps):
            tests = min(addition_events(self.effort, n), max(meter.remaining or 0, 0) // 2)
            with meter.keeping(tests):
                posterior = search.posterior(null.fit)
            if meter.refused:
                self.notes.append(f"The search ended early: {meter.limit} simulated events did not suffice.")
            if posterior:
                with self.affordable("the tests of the effects that were found, which are left out"):
                    extended, posterior = self.added(posterior, tests)
        return extended, posterior

    def added(self, posterior: Posterior, tests: int) -> tuple[ExtendedModel | None, Posterior]:
        """The most probable model of which each effect counts, with its tests, and what is probable without others.

        So many simulated events as `tests` are for these. Where no others remain, the fit is that of the search.
        """
        for _ in range(SCORE.tried):
            if posterior.best is None:
                break
            fit, notes = posterior.best.fit, []
            with self.meter.keeping(tests), self.affordable("a sharper fit"):
                fit, notes = refined(fit, self.target, self.rng, self.effort)
            key = posterior.unsupported(fit, self.refitted(tests))
            if key is None:
                self.notes += notes
                return self.tested(fit), posterior
            self.notes.append(f"{key[0]} was fitted and left out: what it adds is compatible with nothing.")
            posterior = posterior.without(key)
        return None, posterior

    def refitted(self, tests: int) -> Callable[[Fit], Fit]:
        """Makes a fit of the search as good as that of an answer, if simulated events suffice beside those of tests."""

        def refit(fit: Fit) -> Fit:
            if fit.model.effects:
                with self.meter.keeping(tests), suppress(BudgetExhausted):
                    return refined(fit, self.target, self.rng, self.effort)[0]
            return fit

        return refit

    def report(self, outcome: Outcome, inferred: Inferred | None) -> Result:
        """The final fit, its uncertainties, where the events disagree, what they could not show, and figures."""
        target, rng, effort, final, rows = self.target, self.rng, self.effort, outcome.final, []
        fit, moves, weights = final.fit, [], None
        with self.affordable("the last step of the fit"):
            fit = outcome.final_fit(target, rng, effort)
        with self.meter.keeping(self.later), self.affordable("theta with other effects: its error may be too small"):
            if outcome.posterior and outcome.effects and self.task.parameter_names:
                events = int(effort.sharpen * target.num_events)
                moves = ambiguity(fit, final.fit, outcome.posterior.allowed, target, rng, events)
        view = target.summary.view(self.events)
        regions = outcome.regions(self.task, target, view, rng)
        with self.affordable("the identifiability card"):
            rows = card(final.fit, target, self.effects, self.alpha * final.gates["summary"].share, rng, effort)
        drawn = pictures(view, target, outcome.first, fit if outcome.effects else None, self.task.labels)
        if outcome.verdict in (Verdict.FAMILY, Verdict.UNEXPLAINED):
            with self.affordable("the correction"):
                weights = correction(fit, target, self.events, rng)
        diagnosis = assemble(
            self.task,
            outcome,
            QuotedFit(fit, moves),
            regions,
            rows,
            notes=self.notes + notes_of(outcome, fit, target, inferred, self.num_events),
            num_events=self.num_events,
            num_simulations=self.meter.used,
        )
        return Result(self.task, diagnosis, fit, drawn, weights)


def sampled(x: NDArray, time: NDArray[np.float64] | None, seed: int) -> tuple[NDArray, NDArray[np.float64], list[str]]:
    """Events x (N, d), or a random sample of too many in their order; the place or time of each (n,); and notes."""
    position, most = np.arange(len(x), dtype=float) if time is None else time, BUDGET.most_events
    if len(x) <= most:
        return x, position, []
    rows = np.random.default_rng([seed, len(x)]).choice(len(x), most, replace=False, shuffle=False)
    rows.sort()
    return x[rows], position[rows], [f"A random {most} of the {len(x)} events were compared: see docs/diagnosis.md."]
