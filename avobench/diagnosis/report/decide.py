"""How many more events would tell the models of the 95 % set apart, by which feature, and under which condition.

What another model cannot imitate of the first, with its own parameters refitted, is a noncentrality that grows with the
number of events. The right model has the smaller chi-squared with probability Phi(sqrt(noncentrality) / 2): the
criterion of M. Hainy et al., Stat. Comput. 32 (2022) 20, in closed form.
"""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth
from scipy.optimize import brentq
from scipy.stats import norm

from avobench.diagnosis.fit.fit import Fit, fit_at
from avobench.diagnosis.fit.surrogate import Design, repeats, surrogate
from avobench.diagnosis.goodness_of_fit.regions import dependences, intervals, placed
from avobench.diagnosis.report.uncertainties import named
from avobench.diagnosis.schema import Decision
from avobench.diagnosis.search.posterior import Posterior
from avobench.diagnosis.settings import BUDGET, DECIDE, FIT, TEST
from avobench.diagnosis.summary.bins import Span
from avobench.diagnosis.summary.joint import StackedSummary
from avobench.diagnosis.summary.target import Target, summary_of, target_of, whitening
from avobench.effects.bank import Bank
from avobench.effects.model import Model
from avobench.effects.pool import Counted, Pool
from avobench.tasks.errors import BudgetExhausted

ENOUGH = float(2 * norm.ppf(DECIDE.confidence)) ** 2
"""The noncentrality from which two models are told apart: 10.8."""


@dataclass(frozen=True)
class Separation:
    """How two models differ under a condition, in standard errors of one event."""

    difference: NDArray[np.float64]
    """The true one less its rival, by each of several independent pieces of simulated events: (g, r)."""
    slopes: NDArray[np.float64]
    """How the true one moves with its parameters, by a standard error of each that the data determine: (r, k)."""
    rival: NDArray[np.float64]
    """How the rival moves with its parameters: (r, P)."""

    def beside(self, other: "Separation", n: float, m: float) -> "Separation":
        """n events of this condition and m of another, as one event of both, by as many pieces as both have."""
        a, b, g = np.sqrt(n), np.sqrt(m), min(len(self.difference), len(other.difference))
        return Separation(
            np.hstack([a * self.difference[:g], b * other.difference[:g]]),
            np.vstack([a * self.slopes, b * other.slopes]),
            np.vstack([a * self.rival, b * other.rival]),
        )

    def noncentrality(self) -> tuple[float, float]:
        """By how much chi-squared of the rival exceeds that of the true model, on average, and the error of that.

        The rival is refitted, linearly. Only products of different pieces count, to which simulation adds nothing on
        average. What errors of the true model's parameters add is subtracted.
        """
        reach = orth(self.rival) if self.rival.size else self.rival
        residual, slopes = (each - reach @ (reach.T @ each) for each in (self.difference.T, self.slopes))
        pieces = residual.shape[1]
        pairs = pieces * (pieces - 1)
        mean, products, moved = residual.mean(axis=1), residual.T @ residual, slopes.T @ slopes
        apart = residual.T - mean
        squares = ((apart @ apart.T) ** 2)[~np.eye(pieces, dtype=bool)].sum()
        simulated = 4 * ((apart @ mean) ** 2).sum() / pairs + 2 * squares / pairs**2
        measured = 4 * ((mean @ slopes) ** 2).sum() + 2 * (moved**2).sum()
        value = (products.sum() - np.trace(products)) / pairs - np.trace(moved)
        return float(value), float(np.sqrt(simulated + measured))


@dataclass(frozen=True)
class Pair:
    """A model that is taken as true, and another one that describes the same events."""

    true: Fit
    rival: Fit
    target: Target
    now: Separation
    """By what was measured."""

    @classmethod
    def of(cls, true: Fit, rival: Fit, target: Target) -> "Pair":
        """By events that the bank has. Raises BudgetExhausted where these are too few."""
        size = int(np.clip(target.num_events // DECIDE.in_piece, DECIDE.least, BUDGET.most_events // DECIDE.pieces))
        difference = differences((true.model, rival.model), (true.params, rival.params), target, size, free=True)
        root = np.sqrt(target.num_events)
        slopes = true.jacobian @ errors(true) / root
        return cls(true, rival, target, Separation(difference @ target.whitening, slopes, rival.jacobian / root))

    def sets(self) -> dict[str, Separation]:
        """The same by each of several data sets alone; none of a single one."""
        stacked, by_set = self.target.summary, {}
        if isinstance(stacked, StackedSummary):
            back = self.target.whitening.T @ self.target.cov  # from whitened means to means
            for name, part, weight in zip(stacked.names, stacked.parts, stacked.weights, strict=True):
                transform = back[:, part] @ whitening(self.target.cov[part, part] / weight)
                by_set[name] = Separation(
                    self.now.difference @ transform, transform.T @ self.now.slopes, transform.T @ self.now.rival
                )
        return by_set

    def under(self, events: Bank | Counted, chosen: Mapping[str, float], size: int) -> Separation:
        """By the simulator of another condition, in pieces of so many events, which come from its bank.

        `chosen` are parameters of the task that are set to these values, and then known. Raises BudgetExhausted.
        """
        fits, task, rng = (self.true, self.rival), events.task, np.random.default_rng(0)
        at = [task.parameter_names.index(name) for name in chosen]
        if isinstance(events, Bank):
            per_theta = np.linalg.norm(self.true.jacobian[:, : self.true.model.num_theta], axis=0)
            events.resolve(FIT.cell / np.maximum(per_theta, 1))
        models = [replace(fit.model, task=task, events=events) for fit in fits]
        params = [fit.params for fit in fits]
        for each in params:
            each[at] = list(chosen.values())
        made = [
            model.simulate(np.tile(each, (DECIDE.pieces * size, 1)), rng)
            for model, each in zip(models, params, strict=True)
        ]
        target = target_of(made[0], summary_of(task, *made), made[0])
        difference, slopes = differences(models, params, target, size), []
        for fit, model, each in zip(fits, models, params, strict=True):
            scale = (fit.model.high - fit.model.low) / (model.high - model.low)
            centre, axes = model.to_cube(each), scale[:, None] * fit.next_design().axes
            s = surrogate(model, target, Design(centre, axes), target.num_events, rng)
            slope = fit_at(model, s, target, centre).jacobian * scale / np.sqrt(target.num_events)
            slope[:, at] = 0
            slopes.append(slope)
        return Separation(difference @ target.whitening, slopes[0] @ errors(self.true), slopes[1])

    def decision(self, rivals: "Rivals", adds: Separation | None = None, condition: str = "") -> Decision:
        """How many more measured events would do, of the same kind or of what a condition `adds`."""
        n, labels = self.target.num_events, self.true.model.task.labels
        now = self.now.noncentrality()

        def lacking(more: float, sigmas: float) -> float:
            if adds is None:
                value, error = ((n + more) * each for each in now)
            else:
                value, error = self.now.beside(adds, n, more).noncentrality()
            return ENOUGH - value - sigmas * error

        def events(sigmas: float) -> int | None:
            """The number at which the noncentrality, with so many errors of it, is enough; None if none is."""
            if lacking(0, sigmas) <= 0:
                return 0
            if lacking(DECIDE.most, sigmas) > 0:
                return None
            root = np.expm1(brentq(lambda log: lacking(np.expm1(log), sigmas), 0, np.log1p(DECIDE.most)))
            return int(np.ceil(root / (1 - TEST.held_out_share)))

        low, middle, high = (events(sigmas) for sigmas in (1, 0, -1))
        names = [[named(effect.key, labels) for effect in fit.model.effects] for fit in (self.true, self.rival)]
        return Decision(
            true=names[0],
            rival=names[1],
            condition=condition,
            chi_squared=self.rival.noiseless_q - self.true.noiseless_q,
            events=None if high is None else middle,
            low=low,
            high=high,
            **(self._where(rivals) if adds is None and high is not None else {}),
        )

    def _where(self, rivals: "Rivals") -> dict[str, Any]:
        """The interval of a feature, or the dependence, that has most of the noncentrality, and its share."""
        residual = np.sqrt(self.target.num_events) * self.now.difference.mean(axis=0)
        fit = replace(self.rival, residual=residual, noise=0.0)
        scan = intervals(fit, self.target, rivals.spans) + dependences(fit, self.target)
        if not scan.regions:
            return {}
        z = scan.z(fit)
        most = int(np.abs(z).argmax())
        share = z[most] ** 2 / ((residual @ fit.projector()) ** 2).sum()
        return {"where": placed(scan.regions[most], z[most], rivals.names), "share": min(share, 1.0)}


@dataclass(frozen=True)
class Rivals:
    """The most probable model beside the others of the 95 % set, each in a few shapes."""

    pairs: list[list[Pair]]
    """By model, the most probable first."""
    spans: list[Span]
    names: tuple[str, ...]
    """Of the features (d,); none where there is nothing to choose from."""

    @classmethod
    def of(
        cls, chosen: Fit, posterior: Posterior, target: Target, spans: list[Span], names: tuple[str, ...]
    ) -> "Rivals":
        """Of the model that was `chosen`, and those of the set for which the bank has enough events.

        A model that has all effects of the other one is the true one: else the larger never differs.
        """
        groups = []
        for each in posterior.credible:
            pairs, larger = [], each > posterior.best.effects
            for other in posterior.shapes[each][: DECIDE.shapes] if each != posterior.best.effects else []:
                with suppress(BudgetExhausted):
                    pairs.append(Pair.of(*((other.fit, chosen) if larger else (chosen, other.fit)), target))
            groups += [pairs] if pairs else []
        return cls(groups, spans, names)

    def decisions(self) -> list[Decision]:
        """What would decide on each rival: more events of the same kind, and of each of several data sets alone."""
        decisions = []
        for pairs in self.pairs:
            pair, decision = self._nearest(pairs)
            decisions += [decision, *(pair.decision(self, adds, name) for name, adds in pair.sets().items())]
        return decisions

    def under(self, name: str, bank: Bank | Counted, chosen: Mapping[str, float], simulations: int) -> list[Decision]:
        """The same by events of another condition, of which about so many are simulated; see `Pair.under`.

        Where a model takes more, as one that loses nearly all events there, pieces are made smaller. Raises
        BudgetExhausted where that leaves next to nothing.
        """
        decisions, size = [], simulations // (DECIDE.asked * DECIDE.pieces)
        for pair in [self._nearest(pairs)[0] for pairs in self.pairs]:
            adds = None
            while adds is None:
                if size < DECIDE.fewest:
                    raise BudgetExhausted(f"{size} events are too few for a piece")
                with suppress(BudgetExhausted):
                    adds = pair.under(bank, chosen, size)
                size = size if adds else size // 2
            decisions.append(pair.decision(self, adds, name))
        return decisions

    def _nearest(self, pairs: list[Pair]) -> tuple[Pair, Decision]:
        """The shape that is hardest to tell from the other model."""
        both = [(pair, pair.decision(self)) for pair in pairs]
        return max(both, key=lambda each: (each[1].events is None, each[1].events or 0, each[1].low or 0))


def errors(fit: Fit) -> NDArray[np.float64]:
    """Independent directions of the parameters that the data determine, a standard error long: (P, k)."""
    _, vectors = np.linalg.eigh(fit.information[0])
    determined = vectors[:, fit.model.dim - fit.num_identified :]
    return np.sqrt(1 + fit.noise) * determined @ np.linalg.inv(np.linalg.qr(fit.jacobian @ determined)[1])


def differences(
    models: Sequence[Model], params: Sequence[NDArray[np.float64]], target: Target, size: int, free: bool = False
) -> NDArray[np.float64]:
    """What the summary of one model has more than that of another, by pieces of so many events each: (g, K).

    In each piece both models change the same simulated events, and no event is in two pieces. Where this is to be
    `free`, there are as many pieces as the bank has events for. Raises BudgetExhausted where these are too few.
    """
    bank, summary, pieces = models[0].events, target.summary, []
    if isinstance(bank, Pool):  # a second request may begin anywhere
        size = min(size, bank.size // DECIDE.pieces)
    if not isinstance(bank, Bank):
        means = []
        for model, each in zip(models, params, strict=True):
            x = model.simulate(np.tile(each, (DECIDE.pieces * size, 1)), np.random.default_rng(0))
            means.append(summary.mean(x, DECIDE.pieces))
        pieces = list(np.stack(means, axis=1))
    else:
        session = bank.session()
        with bank.meter.closed() if free else nullcontext(), suppress(BudgetExhausted):
            while len(pieces) < DECIDE.pieces:
                sources, means = [copy(session), copy(session)], []
                for model, each, source in zip(models, params, sources, strict=True):
                    x = model.simulate(np.tile(each, (size, 1)), np.random.default_rng(len(pieces)), source)
                    means.append(summary.mean(x)[0])
                session = sources[0].after(sources[1])
                if repeats(session) > 1:
                    break
                pieces.append(np.stack(means))
    if len(pieces) < DECIDE.fewest:
        raise BudgetExhausted(f"{len(pieces)} pieces of {size} events are too few")
    # Of some tables a function of the mean is compared.
    return np.array([summary.linear(a[None])[0] - summary.linear(b[None])[0] for a, b in pieces])
