"""Bayesian synthetic likelihood with ELFI, within a hard budget."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.methods.contract import Estimate, Method, TracePoint, WeightedSample, global_seed
from avobench.methods.elfi_model import import_elfi, own_client, prior_model
from avobench.methods.problem import Problem
from avobench.methods.regression import Evaluation
from avobench.tasks.errors import UsageError

FEWEST = 8
"""Least number of steps of a chain, and of thetas from which slopes are taken."""
PARTS = 2048
"""Parts of the observation from whose summaries the covariance is taken, more than a summary has components."""
RIDGE = 1e-3
"""Share of their mean that is added to the variances of a summary: the shares of a histogram sum to 1."""


@dataclass(frozen=True)
class Bsl(Method):
    """ELFI's BSL: a Metropolis-Hastings chain over theta, the likelihood at each step from events simulated there.

    At every theta `sets` sets of events are simulated, and a Gaussian with the mean and the covariance of their
    summaries stands for the likelihood. The covariance is that of a set; for the observation, of N events, against a
    mean known from n simulated ones it is scaled to 1/N + 1/n, as the summary is taken to be an average over events.
    ELFI's BSL takes simulated sets to be as large as the observed one, which the budget holds once. With fewer events
    the mean is noise to the chain, and its posterior is as wide as 1/N + 2/n allows; where it is knows more than that.

    The covariance of a histogram is singular, so the task's summary enters as one number per parameter: theta by
    generalised least squares, from how the summary moves with theta among the simulated and how it varies among parts
    of the observation. The first thetas are drawn from the prior, and chains follow, each with a new such statistic and
    steps that suit it. The last has half of the budget and alone is the posterior.
    """

    name: ClassVar[str] = "bsl"
    packages: ClassVar = ("elfi",)
    extra: ClassVar = "bolfi"
    source: ClassVar[str] = (
        "Price, Drovandi, Lee, Nott, Journal of Computational and Graphical Statistics 27 (2018) 1; "
        "Lintusaari et al., Journal of Machine Learning Research 19 (2018) 16"
    )

    sets: int = 16
    """Number of sets simulated at each theta."""
    events_per_set: int = 8
    """Events of a set at the thetas from the prior."""
    chains: int = 3
    """Number of chains, each with a new statistic."""
    growth: float = 2.0
    """Factor by which the events of a set grow from chain to chain: the posterior narrows, and steps with it."""
    nearest: float = 0.3
    """Share of the thetas so far, those of the summaries nearest to the observed one, from which slopes are taken."""

    def __post_init__(self) -> None:
        if min(self.sets, self.events_per_set, self.chains, self.growth) < 1 or not 0 < self.nearest <= 1:
            raise UsageError("bsl needs sets, events_per_set, chains, growth of at least 1 and 0 < nearest <= 1")

    def min_simulations(self, num_parameters: int) -> int:
        """The budget that gives enough thetas for slopes. Raises UsageError with fewer sets than a covariance needs."""
        if self.sets < num_parameters + 2:
            raise UsageError(
                f"bsl.sets = {self.sets} is too few for the covariance of {num_parameters} parameters: "
                f"set it to at least {num_parameters + 2}"
            )
        most = max(self.chains * self._events(self.chains - 1), self._events(self.chains))
        return 2 * max(FEWEST, 2 * num_parameters) * most

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """Infer as `Method.infer` describes. Raises BudgetExhausted when the budget is below `min_simulations`."""
        elfi = import_elfi()
        prior, observed = problem.prior, problem.summary(problem.x_observed)
        # With too little left the metered simulator refuses, rather than a chain being made of next to nothing.
        budget = max(problem.simulate.remaining, self.min_simulations(prior.dim))
        tried: list[Evaluation] = []

        def simulated(theta: NDArray[np.float64], events: int) -> NDArray[np.float64]:
            """Summaries of the sets at theta (p,): (sets, k)."""
            sets = problem.simulate.repeat(theta, events)[0].reshape(self.sets, events // self.sets, -1)
            summaries = np.stack([problem.summary(one) for one in sets])
            tried.append(Evaluation(theta, summaries.mean(axis=0), problem.simulate.used))
            return summaries

        def chain(near: _Near, start: NDArray[np.float64], events: int, length: int) -> NDArray[np.float64]:
            """`length` draws: (length, p). A step out of the prior is refused without simulation."""
            model, bounds = prior_model(elfi, prior)
            scale = np.sqrt(events / self.sets / len(problem.x_observed) + 1 / self.sets)

            def likelihood(estimates: NDArray[np.float64], wanted: NDArray[np.float64]) -> float:
                """ELFI's, of what theta is by each set (sets, p) and by the observation (1, p)."""
                mean = estimates.mean(axis=0)
                return gaussian_syn_likelihood(mean + scale * (estimates - mean), wanted)

            def statistics(*theta: NDArray, batch_size: int, random_state: np.random.RandomState) -> NDArray:
                return near.statistic(simulated(np.array([one.item(0) for one in theta]), events))

            wanted = near.statistic(observed[None])
            elfi.Simulator(statistics, *map(model.__getitem__, bounds), observed=wanted, model=model, name="statistics")
            seed = int(rng.integers(2**32, dtype=np.uint32))
            bsl = elfi.BSL(model, self.sets, feature_names="statistics", likelihood=likelihood, seed=seed)
            precision = near.information / (1 / len(problem.x_observed) + 2 / events) + np.diag(12 / prior.width**2)
            step = 2.38**2 / prior.dim * np.linalg.inv(precision)
            return bsl.sample(length, step, params0=start, bar=False).samples_array

        trace, draws = [], None
        with global_seed(rng), own_client(elfi):
            from elfi.methods.bsl.pdf_methods import gaussian_syn_likelihood

            events = self._events(0)
            for theta in prior.sample(budget // (2 * self.chains) // events, rng):
                simulated(theta, events)
            inverse = _inverse_covariance(problem)
            for number in range(1, self.chains + 1):
                near = _near(tried, observed, self.nearest, inverse)
                start = near.nearest if draws is None else draws.mean(axis=0)
                events, share = self._events(number), self.chains if number == self.chains else 1
                draws = chain(near, start, events, share * budget // (2 * self.chains) // events)
                trace.append(_point(problem, draws))
            while steps := problem.simulate.remaining // events:  # steps out of the prior have cost nothing
                draws = np.concatenate([draws, chain(near, draws[-1], events, steps)])
                trace[-1] = _point(problem, draws)
        moved = (np.diff(draws, axis=0) != 0).any(axis=1).mean()
        return Estimate(
            theta=trace[-1].theta,
            how="mean of the posterior of the synthetic likelihood",
            spread_of="posterior",
            mean=trace[-1].theta,
            std=trace[-1].std,
            trace=trace,
            message=f"{len(draws)} draws in the last chain, {moved:.0%} of its steps were taken",
            error=trace[-1].std,
            sample=WeightedSample.equal(draws),
        )

    def _events(self, number: int) -> int:
        """Events simulated at a theta of a chain; number 0 are the draws from the prior before the first chain."""
        return self.sets * round(self.events_per_set * self.growth**number)


class _Near(NamedTuple):
    """The way in which the summary moves with theta near the observation."""

    nearest: NDArray[np.float64]
    """The theta (p,) of the nearest summary."""
    theta: NDArray[np.float64]
    """The mean (p,) of the thetas near the observation."""
    summary: NDArray[np.float64]
    """The mean (k,) of their summaries."""
    weights: NDArray[np.float64]
    """Slope of theta in the summary by generalised least squares (k, p)."""
    information: NDArray[np.float64]

    def statistic(self, summaries: NDArray[np.float64]) -> NDArray[np.float64]:
        """The estimate of theta from each summary: (m, k) -> (m, p)."""
        return self.theta + (summaries - self.summary) @ self.weights


def _near(tried: list[Evaluation], observed: NDArray[np.float64], share: float, inverse: NDArray[np.float64]) -> _Near:
    """The slopes from the evaluations whose summaries are nearest to the observed one (k,)."""
    distances = [np.linalg.norm(one.summary - observed) for one in tried]
    fewest = max(FEWEST, 2 * len(tried[0].theta))
    order = np.argsort(distances, kind="stable")[: max(fewest, round(share * len(tried)))]
    theta, summaries = (np.array([getattr(tried[i], name) for i in order]) for name in ("theta", "summary"))
    middle, at = theta.mean(axis=0), summaries.mean(axis=0)
    slope = np.linalg.lstsq(theta - middle, summaries - at)[0]
    information = slope @ inverse @ slope.T
    return _Near(theta[0], middle, at, inverse @ slope.T @ np.linalg.inv(information), information)


def _inverse_covariance(problem: Problem) -> NDArray[np.float64]:
    """The inverse covariance of the summary of one event (k, k), from parts of the observation."""
    parts = np.array_split(problem.x_observed, min(PARTS, len(problem.x_observed) // 2))
    covariance = np.atleast_2d(np.cov([problem.summary(part) for part in parts], rowvar=False))
    covariance *= len(problem.x_observed) / len(parts)
    return np.linalg.inv(covariance + RIDGE * covariance.diagonal().mean() * np.eye(len(covariance)))


def _point(problem: Problem, draws: NDArray[np.float64]) -> TracePoint:
    return TracePoint(problem.simulate.used, draws.mean(axis=0), draws.std(axis=0))
