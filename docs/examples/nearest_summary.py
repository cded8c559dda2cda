"""Rejection ABC: keep the parameters whose simulated events look most like the observed ones."""

from dataclasses import dataclass

import numpy as np

from avobench.methods import Estimate, Method, TracePoint
from avobench.methods.problem import Problem
from avobench.tasks.errors import UsageError


@dataclass(frozen=True)
class NearestSummary(Method):
    """Draw theta from the prior, simulate events for each, and average those with the nearest summaries.

    The distance is Euclidean. The kept parameters are draws from the posterior given that the distance is at most the
    largest one kept; their mean is the estimate.
    """

    name = "nearest-summary"
    source = "Pritchard et al., Molecular Biology and Evolution 16 (1999) 1791"

    events_per_theta: int = 128
    """Events simulated for each theta."""
    share_kept: float = 0.05
    """Of the parameters tried; at least two are kept."""
    num_trace_points: int = 10

    def __post_init__(self) -> None:
        if min(self.events_per_theta, self.num_trace_points) < 1:
            raise UsageError("nearest-summary needs events_per_theta and num_trace_points of at least 1")
        if not 0 < self.share_kept <= 1:
            raise UsageError(f"nearest-summary needs 0 < share_kept <= 1, got {self.share_kept}")

    def min_simulations(self, num_parameters: int) -> int:
        """Two parameters, so that there is a standard deviation."""
        return 2 * self.events_per_theta

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """As `Method.infer`. Raises BudgetExhausted when the budget is below `min_simulations`."""
        # With too little left the metered simulator refuses, rather than an estimate being made from too few.
        num_theta = max(problem.simulate.remaining // self.events_per_theta, 2)
        theta = problem.prior.sample(num_theta, rng)
        observed = problem.summary(problem.x_observed)
        traced = set(np.linspace(num_theta, 2, self.num_trace_points, dtype=int).tolist())
        distances = np.empty(num_theta)
        trace = []
        for i in range(num_theta):
            x = problem.simulate.repeat(theta[i], self.events_per_theta)[0]
            distances[i] = np.linalg.norm(problem.summary(x) - observed)
            if i + 1 in traced:
                nearest = distances[: i + 1].argsort(kind="stable")[: max(2, round(self.share_kept * (i + 1)))]
                kept = theta[nearest]
                trace.append(TracePoint(problem.simulate.used, kept.mean(axis=0), kept.std(axis=0)))
        return Estimate(
            theta=kept.mean(axis=0),
            how=f"mean of the {len(kept)} parameters with the nearest summaries, of {num_theta}",
            spread_of="posterior",
            mean=kept.mean(axis=0),
            std=kept.std(axis=0),
            trace=trace,
        )
