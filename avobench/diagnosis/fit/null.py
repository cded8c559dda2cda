"""The null model is the task alone, with theta fitted, to which effects may be added."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.prior_shares import in_shares, raw
from avobench.bench.plugins import registry
from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.descent import refine, scan, settled, sharpen
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.settings import FIT
from avobench.diagnosis.summary.part import Measured, Part, target_for
from avobench.diagnosis.summary.target import Target
from avobench.effects.bank import Bank
from avobench.effects.model import Model
from avobench.methods import Estimate
from avobench.tasks import Task
from avobench.tasks.errors import BudgetExhausted, UsageError


@dataclass(frozen=True)
class Inferred:
    """Theta as a registered method infers it, from which the fit of a diagnosis may begin."""

    method: str
    task: Task
    estimate: Estimate
    num_simulations: int

    @classmethod
    def by(cls, name: str, task: Task, x: NDArray, num_events: int | None, rng: np.random.Generator) -> "Inferred":
        """Fit events x (N, d) by a registered method, with at most so many simulated ones, and its usual budget.

        Raises UsageError for an unknown method and for too few events.
        """
        num_events = FIT.method_events if num_events is None else min(num_events, FIT.method_events)
        method = registry.build("method", name, {})
        registry.require_packages("method", method)
        least = method.min_simulations(len(task.parameter_names))
        if num_events < least:
            raise UsageError(f"--fit {name} needs at least {least} simulated events, got {num_events}")
        posed = in_shares(task, method)
        simulate = MeteredSimulator(posed, num_events, rng.spawn(1)[0])
        estimate = method.infer(pose(posed, x, simulate), rng.spawn(1)[0])
        return cls(name, task, raw(estimate, posed), simulate.used - simulate.failed)

    def centre(self, model: Model) -> NDArray[np.float64]:
        """The estimate in the unit cube of the task's own model (p,)."""
        return model.to_cube(np.clip(self.estimate.theta, model.low, model.high))

    def note(self, fit: Fit) -> str:
        """A note that compares it with a fit: a proposal much wider than the error warns that the model is wrong."""
        estimate = self.estimate
        each = zip(self.task.parameter_names, estimate.theta, estimate.std, fit.std, strict=False)
        parts = [
            f"{p} = {theta:.4g} with a {estimate.spread_of} of width {width:.2g}, {width / error:.1f} errors of the fit"
            for p, theta, width, error in each
        ]
        return f"{self.method} found {'; '.join(parts)}"


def fit_null(
    model: Model, x: Measured, rng: np.random.Generator, effort: Effort, centre: NDArray[np.float64] | None
) -> tuple[Fit, Target]:
    """Fit theta to events x (N, d), first with bins of the measured events, then with bins that suit both.

    The search begins at `centre` (p,) in the unit cube, or where the prior is.
    """
    if isinstance(x, Part):
        target, others = x.first, np.empty((0, model.task.num_features), model.task.dtype)
        if target.rank <= model.dim:
            what = f"{target.rank} degrees of freedom tell no more than the {model.dim} parameters"
            raise UsageError(f"{what}: give more bins")
    else:
        target, others = target_for(model.task, x, x), x[:0]
    if target.rank == 0:  # measured events are all in one bin: bins beside it take simulated ones
        others = model.simulate(model.from_cube(rng.random((len(x), model.dim))), rng)
        target = target_for(model.task, x, others)
    near = 0.03
    if centre is None:
        centre, near = scan(model, target, rng, **where_prior_is(model), size=effort.scan)
    coarse, per_round = (max(effort.least, int(share * effort.rounds * len(x))) for share in (FIT.coarse_share, 1))
    fit = refine(model, target, centre, np.maximum(near, 0.005), rng, num_events=coarse)
    resolve(fit)
    simulated = np.concatenate([model.simulate(np.tile(fit.params, (len(x), 1)), rng), others])
    target = target_for(model.task, x, simulated)
    return refine(model, target, fit.point, 0.005, rng, num_events=per_round), target


def where_prior_is(model: Model) -> dict[str, NDArray[np.float64]]:
    """The part of the unit cube to begin in, as `scan` takes it: all, but for a prior that is far narrower than that.

    Of a fitted model, say, the prior knows where a narrow peak is, which a search everywhere may miss.
    """
    prior = model.task.prior
    low, high = (model.to_cube(np.array(end))[: prior.dim] for end in (prior.low, prior.high))
    if ((high - low) > FIT.narrow_prior).all():
        return {}
    return {"around": (low + high) / 2, "half": (high - low) / 2}


def resolve(fit: Fit) -> None:
    """Make the bank's lattice so fine that between its nodes the mean of events is linear, as far as a fit knows."""
    if isinstance(fit.model.events, Bank):
        fit.model.events.resolve(FIT.cell / np.maximum(np.linalg.norm(fit.jacobian, axis=0), 1))


def best_null(tried: list[Fit], target: Target, rng: np.random.Generator, effort: Effort) -> Fit:
    """The task's own best fit where it does not describe the events, hence where the way to it may have been long.

    From where the fits that were tried ended, of which the first is in the target's metric, and from scans of the whole
    range.
    """
    first, *others = tried
    model, per_round = first.model, max(effort.least, int(effort.rounds * target.num_events))
    starts = [(fit.point, 0.005) for fit in others] + [
        scan(model, target, rng, size=effort.scan) for _ in range(FIT.scans)
    ]
    fits = [first] + [
        refine(model, target, start, np.maximum(near, 0.005), rng, num_events=per_round) for start, near in starts
    ]
    # The lowest of a few values is low by chance, and ways may be long and bent. So it is simulated anew until it
    # stands still: once, or twice where the noise may hide a slope.
    best, still = min(fits, key=lambda fit: fit.noiseless_q), 0
    num_events = max(effort.least, int(effort.repeated * target.num_events))
    for _ in range(FIT.repeats):
        resolve(best)
        last, best = best, sharpen(best, target, rng, num_events)
        still += not best.clearly_below(last)
        if still > best.undecided or best.far:
            break
        num_events *= 2 if best.undecided else 1
    if best.undecided:  # only its error is wanted, and no limit fails for that
        with suppress(BudgetExhausted):
            sharper = settled(best, target, rng, num_events, (1, 2))
            return best if sharper.undecided else best.with_slopes_of(sharper)
    return best
