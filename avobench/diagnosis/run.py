"""The diagnosis on one page: fit and test the simulator, search what it lacks, add that and refit, and report."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.checks import bank_of
from avobench.diagnosis.effort import Effort, Phases, Progress, effort_for, first_fit_events, later_events, usual_events
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.null import Inferred, best_null, fit_null
from avobench.diagnosis.goodness_of_fit.gates import ExtendedModel, correction
from avobench.diagnosis.goodness_of_fit.held_out import HeldOut
from avobench.diagnosis.goodness_of_fit.order import exchangeability
from avobench.diagnosis.goodness_of_fit.regions import disagreeing, regions
from avobench.diagnosis.report.decide import Rivals
from avobench.diagnosis.report.identifiability import card
from avobench.diagnosis.report.outcome import Outcome, notes_of, to_choose_from
from avobench.diagnosis.report.result import Result, assemble, pictures
from avobench.diagnosis.report.tables import table_gaps
from avobench.diagnosis.report.uncertainties import QuotedFit, ambiguity
from avobench.diagnosis.schema import Verdict
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.search.search import Search, refined
from avobench.diagnosis.settings import BUDGET, FIT, SCORE, TEST
from avobench.diagnosis.summary.part import Measured, Part, split
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect
from avobench.effects.bank import Bank
from avobench.effects.catalogue import catalogue, domain
from avobench.effects.model import Model
from avobench.effects.pool import Counted, Pool
from avobench.tasks import Task
from avobench.tasks.errors import BudgetExhausted, UsageError
from avobench.tasks.meter import Meter
from avobench.tasks.missing import filled

OF_TABLES = (
    "Of tables, and of several data sets, what needs single events is left out: the classifier, what events look like, "
    "and the correction. A quarter of what was measured, drawn at random, is kept aside for the gap."
)
"""What is said of each diagnosis of tables, or of several data sets."""


def diagnose(
    task: Task,
    x: Measured,
    *,
    seed: int = 0,
    alpha: float = 0.05,
    max_effects: int = 3,
    num_simulations: int | None = None,
    fit: str = "surrogate",
    effects: list[Effect] | None = None,
    experience: bool = True,
    jobs: int = 1,
    ordered: bool = False,
    time: NDArray[np.float64] | None = None,
    progress: Progress | None = None,
    bank: Bank | Counted | None = None,
) -> Result:
    """Compare measured events x (N, d), or published tables, with a task, and say what it lacks.

    If a `bank` is given, events come from it, and its limit holds. Otherwise a new bank simulates at most
    `num_simulations` events, in `jobs` processes. Without `experience` the networks are not asked what the events look
    like. `ordered` asks whether the order of the events, or that of their `time` (N,), matters. `progress` is called
    with how far the diagnosis is. Raises UsageError for too few events, for a lower limit than the first fit takes, and
    for impossible settings.
    """
    started = perf_counter()
    if not 0 < alpha < 1:
        raise UsageError(f"alpha must lie between 0 and 1, got {alpha}")
    rng = np.random.default_rng(seed)
    effects = catalogue(task) if effects is None else effects
    order, notes, num_events = None, [], None
    if isinstance(x, Part):
        notes.append(OF_TABLES)
    else:
        if len(x) < BUDGET.least_events:
            raise UsageError(f"a diagnosis needs at least {BUDGET.least_events} events, got {len(x)}")
        x, position, notes = sampled(x, time, seed)
        num_events = len(x)
        if ordered or time is not None:
            order = exchangeability(task, filled(x), position, "index" if time is None else "time", alpha, seed)
    fitted, aside = split(x, TEST.held_out_share, rng)
    bank = bank or bank_of(task, Meter(num_simulations), seed, jobs)
    effort = effort_for(task, domain(task), bank.meter.limit, len(fitted), bank.meter.used)
    phases = Phases(progress, first_fit_events(effort, task, len(fitted)) // 2)
    bank.meter.progress = phases
    run = Run(task, fitted, num_events, effects, alpha, effort, rng, bank, phases, notes, jobs)

    null, inferred = run.null_model(fit)
    extended, posterior = None, None
    if null.p_value < alpha:
        extended, posterior = run.extended_model(null, max_effects, experience)
    phases.begin("checks")
    held_out = HeldOut.of(run.target, aside)
    outcome = Outcome.of(null, extended, posterior, alpha, held_out, rng, effort, run.affordable)
    result = run.report(outcome, inferred)
    details = {"order": order, "seed": seed, "seconds": perf_counter() - started}
    return replace(result, diagnosis=result.diagnosis.model_copy(update=details))


@dataclass
class Run:
    """A diagnosis under way: the measured events, and what all of its steps share."""

    task: Task
    events: Measured
    """The measured events that are fitted (n, d), or what is fitted of tables."""
    num_events: int | None
    """Number of measured events, held-out ones included; None if tables were measured."""
    effects: list[Effect]
    """The effects that may be missing."""
    alpha: float
    effort: Effort
    rng: np.random.Generator
    bank: Bank | Counted
    """What stands for the simulator."""
    phases: Phases
    notes: list[str]
    jobs: int = 1
    """Processes that simulate."""
    left_out: list[str] = field(default_factory=list)
    """What the simulated events did not suffice for."""
    target: Target = field(init=False)
    """What is fitted of the events; it is set when the null model is fitted."""

    @contextmanager
    def affordable(self, what: str, required: bool = False) -> Iterator[None]:
        """Where the simulated events end, note that `what` is left out; raise UsageError if it is required."""
        try:
            yield
        except BudgetExhausted as error:
            if required:
                raise UsageError(
                    f"{self.meter.limit} simulated events did not suffice for {what}; allow {2 * self.meter.limit}"
                ) from error
            self.left_out.append(what)

    @property
    def later(self) -> int:
        """Simulated events that are kept for what follows the tests and the search."""
        return later_events(self.effort, len(self.events))

    @property
    def of_tables(self) -> bool:
        """Whether tables were measured, so that what needs single events is left out."""
        return isinstance(self.events, Part)

    def shortage(self) -> list[str]:
        """What the simulated events did not suffice for, and how many would, as a note; none if nothing is left out."""
        if not self.left_out:
            return []
        usual = usual_events(domain(self.task), len(self.events))
        return [
            f"{self.meter.limit} simulated events did not suffice for {'; '.join(self.left_out)}. About "
            f"{max(usual, 2 * self.meter.limit)} are mostly enough."
        ]

    @property
    def meter(self) -> Meter:
        """What counts simulated events."""
        return self.bank.meter

    def source(self) -> Bank | Pool:
        """The bank, or a pool of generated things for a task whose slow generator is asked only once."""
        if isinstance(self.bank, Bank):
            return self.bank
        size = int(max(self.effort.generated * len(self.events), self.effort.least))
        return Pool(self.task, size, self.rng.spawn(1)[0], self.meter)

    def null_model(self, method: str) -> tuple[ExtendedModel, Inferred | None]:
        """Fit theta, and test whether the fit describes the events.

        Unless `method` is "surrogate", the fit starts at the estimate of that registered method.

        If the model is rejected, theta is fitted again: a fit that went astray looks like a missing effect.
        """
        task, x, rng, effort, inferred = self.task, self.events, self.rng, self.effort, None
        with self.affordable("the first fit and the tests", required=True):
            if method != "surrogate":
                inferred = Inferred.by(method, task, x, self.meter.limit and self.meter.limit // FIT.method_share, rng)
                self.meter.charge(inferred.num_simulations)
            model = Model(task, events=self.source())
            with self.meter.keeping(self.later):
                fit, self.target = fit_null(model, x, rng, effort, inferred and inferred.centre(model))
                self.phases.begin("gates")
                null = None if fit.p_value < TEST.hopeless else self.with_tests(fit, replace(effort, metrics=1))
                if null is None or null.p_value < self.alpha:
                    tried = [fit] if null is None else [fit, null.efficient]
                    # A theta that is missed looks like a missing effect, so that no limit leaves this search out.
                    with self.affordable("a second search for theta", required=self.meter.limit is not None):
                        fit = best_null(tried, self.target, rng, effort.sure)
                        null = self.with_tests(fit)
                    null = null or self.with_tests(fit)
        return null, inferred

    def with_tests(self, fit: Fit, effort: Effort | None = None) -> ExtendedModel:
        """A fitted model with all tests of it."""
        measured = None if self.of_tables else self.events
        return ExtendedModel.of(fit, self.target, measured, self.rng, effort or self.effort, self.affordable)

    def extended_model(
        self, null: ExtendedModel, max_effects: int, experience: bool
    ) -> tuple[ExtendedModel | None, Posterior | None]:
        """Weigh all sets of effects that may be missing, and add the most probable one; None where none is."""
        meter, target, n = self.meter, self.target, len(self.events)
        self.phases.begin("search", usual_events(domain(self.task), n) if meter.limit is None else 0)
        rng, effort, x = self.rng, self.effort, self.events
        if isinstance(x, Part):
            with self.affordable("the search for what is missing"):
                made = null.fit.model.simulate(np.tile(null.fit.params, (effort.sample, 1)), rng)
                x, experience = x.as_events(self.task, made, rng), False
        if isinstance(x, Part):  # the simulated events have ended
            return None, None
        features = disagreeing(null.fit, target, x)
        if len(features) < x.shape[1]:
            names = ", ".join(self.task.labels[j] for j in features)
            self.notes.append(f"Effects on single features were looked for where most disagrees, on {names}.")
        if self.task.missing:
            x, experience = filled(x), False
        search = Search(target, x, self.effects, max_effects, rng, effort, self.jobs, self.phases, experience, features)
        extended = None
        with meter.keeping(self.later):
            refused = meter.refused
            most = BUDGET.added * n
            for_tests = most if meter.limit is None else min(most, max(meter.remaining, 0) // 2)
            with meter.keeping(for_tests):
                posterior = search.posterior(null.fit)
            if meter.refused > refused:
                self.left_out.append("the whole search for what is missing")
            if posterior:
                with self.affordable("the tests of the effects that were found, which are left out"):
                    extended, posterior = self.added(posterior, for_tests)
        return extended, posterior

    def added(self, posterior: Posterior, for_tests: int) -> tuple[ExtendedModel | None, Posterior]:
        """The most probable model whose effects all count, with its tests, and the posterior without rejected effects.

        `for_tests` simulated events are kept for the tests. Where no others remain, the fit is that of the search.
        """
        for _ in range(SCORE.tried):
            if posterior.best is None:
                break
            fit, notes = posterior.best.fit, []
            with self.meter.keeping(for_tests), self.affordable("a sharper fit"):
                fit, notes = refined(fit, self.target, self.rng, self.effort)
            key = posterior.unsupported(fit, partial(self.refitted, for_tests))
            if key is None:
                self.notes += notes
                return self.with_tests(fit), posterior
            self.notes.append(
                f"{key[0]} was fitted and left out: its size is compatible with none, "
                "and it explains no more than chance does."
            )
            posterior = posterior.without(key)
        return None, posterior

    def refitted(self, for_tests: int, fit: Fit) -> Fit:
        """A fit made again as precisely as for the answer, or the same if too few events are left."""
        if fit.model.effects:
            with self.meter.keeping(for_tests), suppress(BudgetExhausted):
                return refined(fit, self.target, self.rng, self.effort)[0]
        return fit

    def report(self, outcome: Outcome, inferred: Inferred | None) -> Result:
        """The final fit, its uncertainties, where the events disagree, what they could not show, and figures."""
        target, rng, effort, final, rows = self.target, self.rng, self.effort, outcome.final, []
        fit, moves, weights = final.fit, [], None
        with self.affordable("the last step of the fit"):
            fit = outcome.final_fit(target, rng, effort)
        with self.affordable("theta with other effects: its error may be too small"):
            if outcome.posterior and outcome.effects and self.task.parameter_names:
                events = int(effort.repeated * target.num_events)
                moves = ambiguity(fit, final.fit, outcome.posterior.allowed, target, rng, events)
        view = target.summary.view(self.events)
        names = to_choose_from(self.task)
        where = regions(outcome.null.fit, target, view.spans, rng, self.alpha, names) if outcome.disagree else []
        with self.affordable("the identifiability card"):
            shown = self.effects
            if not self.of_tables and len(some := disagreeing(fit, target, self.events)) < self.events.shape[1]:
                shown = [each for each in shown if not isinstance(each.feature, int) or each.feature in some]
            share = final.gates["summary"].share
            rows = card(final.efficient, final.metric, shown, self.alpha * share, rng, effort)
        drawn = pictures(view, target, outcome.first, fit if outcome.effects else None, self.task.labels)
        if outcome.verdict in (Verdict.FAMILY, Verdict.UNEXPLAINED) and not self.of_tables:
            with self.affordable("the correction"):
                weights = correction(fit, target, self.events, rng)
        rivals = None
        if outcome.effects and len(outcome.posterior.credible) > 1:
            rivals = Rivals.of(final.fit, outcome.posterior, target, view.spans, names)
        diagnosis = assemble(
            self.task,
            outcome,
            QuotedFit(fit, moves),
            where,
            rows,
            rivals.decisions() if rivals else [],
            notes=self.notes + self.shortage() + notes_of(outcome, fit, target, inferred, self.num_events),
            num_events=self.num_events,
            num_simulations=self.meter.used,
            tables=table_gaps(target, outcome.first, fit if outcome.effects else None),
        )
        return Result(self.task, diagnosis, fit, drawn, weights, rivals, outcome.posterior)


def sampled(x: NDArray, time: NDArray[np.float64] | None, seed: int) -> tuple[NDArray, NDArray[np.float64], list[str]]:
    """Events x (N, d), or a random sample of too many in their order; the place or time of each (n,); and notes."""
    position, most = np.arange(len(x), dtype=float) if time is None else time, BUDGET.most_events
    if len(x) <= most:
        return x, position, []
    rows = np.random.default_rng([seed, len(x)]).choice(len(x), most, replace=False, shuffle=False)
    rows.sort()
    return x[rows], position[rows], [f"A random {most} of the {len(x)} events were compared: see docs/diagnosis.md."]
