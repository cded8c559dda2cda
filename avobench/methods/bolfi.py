"""Bayesian optimisation for likelihood-free inference with ELFI, within a hard budget.

This module is the adapter. ELFI's process and acquisition come from `bolfi_surrogate.py`, which says why.
"""

import gc
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import qmc

from avobench.methods.contract import LATER, Estimate, Method, TracePoint, WeightedSample, global_seed
from avobench.methods.elfi_model import import_elfi, own_client, prior_model
from avobench.methods.problem import Problem
from avobench.methods.regression import Evaluation, regressed
from avobench.tasks import Box
from avobench.tasks.errors import UsageError

if TYPE_CHECKING:
    from elfi import BOLFI, Distance

LINEAR_BELOW = 0.01
"""Distance below which its logarithm becomes linear: a tenth of what the noise of 128 events leaves."""
MARGIN = 0.99
"""Share of the budget that is planned where the number of events grows: each is rounded to a whole number."""
SHARE_NEAREST = 0.3
"""Share of the evaluations on which the regression is made, those of the smallest distances."""


@dataclass(frozen=True)
class Bolfi(Method):
    """BOLFI as ELFI runs it by default: a Gaussian process of the distance between summaries, as a function of theta.

    The first evaluations are drawn from the prior, each later one is where the lower confidence bound of the process
    (LCBSC) is least. The posterior is ELFI's, prior times P(distance < h) under the process, h the minimum of its mean,
    hence largest where the mean is least. Its mean and standard deviation are taken by importance sampling.
    The number of evaluations is fixed before the start: the budget left, divided by `events_per_theta`.
    """

    name: ClassVar[str] = "bolfi"
    packages: ClassVar = ("elfi", "GPy")
    extra: ClassVar = "bolfi"
    source: ClassVar[str] = (
        "Gutmann and Corander, Journal of Machine Learning Research 17 (2016) 125; "
        "Lintusaari et al., Journal of Machine Learning Research 19 (2018) 16"
    )

    events_per_theta: int = 128
    """Events simulated for each evaluated theta."""
    initial_evidence: int | None = None
    """Evaluations at draws from the prior; None is ELFI's default, max(10, 2^p + 1) for p parameters."""
    update_interval: int = 10
    """Evaluations between two fits of the process's hyper-parameters."""
    surrogate: Literal["fast", "gpy"] = "fast"
    """The process and its acquisitions: ELFI's own, in GPy, or those of `bolfi_surrogate.py`, which do the same."""
    exploration_rate: float = 10.0
    """1 / delta of the lower confidence bound."""
    acq_noise_var: float = 0.0
    """Variance of the noise added to each acquired theta."""
    unit_box: bool = True
    """Let ELFI see theta in the unit box of the prior rather than in raw units. Its kernel has one length scale for all
    parameters, of prior mean a third of the span of all bounds together: 16 for weinberg, with ranges of 4 and 2."""
    num_trace_points: int = 20
    """Number of trace points, evenly spaced from the first fit of the process to the end."""
    num_posterior_points: int = 4096
    """Points of a scrambled Sobol sequence in the prior box: where the search for the maximum starts, and the sample
    that is weighted by the posterior for its mean and standard deviation. A power of two."""

    log_distance: bool = field(default=False, metadata=LATER)
    """Model the logarithm of the distance, which tells more near the answer, where the distance is small."""
    growth: float = field(default=1.0, metadata=LATER)
    """Ratio of the events simulated for the last theta to those for the first; between them it grows geometrically."""
    regression: bool = field(default=False, metadata=LATER)
    """Take as estimate the posterior mean after a regression adjustment on the evaluations of smallest distance."""

    def __post_init__(self) -> None:
        if self.growth < 1:
            raise UsageError(f"bolfi needs growth >= 1, got {self.growth}")
        if min(self.events_per_theta, self.update_interval, self.num_trace_points) < 1:
            raise UsageError("bolfi needs events_per_theta, update_interval and num_trace_points of at least 1")
        if self.initial_evidence is not None and self.initial_evidence < 1:
            raise UsageError(f"bolfi needs initial_evidence >= 1, got {self.initial_evidence}")
        if self.surrogate not in ("fast", "gpy"):
            raise UsageError(f"bolfi needs surrogate fast or gpy, got {self.surrogate!r}")
        if self.exploration_rate <= 0 or self.acq_noise_var < 0:
            raise UsageError("bolfi needs exploration_rate > 0 and acq_noise_var >= 0")
        if self.num_posterior_points < 2 or self.num_posterior_points & (self.num_posterior_points - 1):
            raise UsageError(f"bolfi needs a power of two as num_posterior_points, got {self.num_posterior_points}")

    def min_simulations(self, num_parameters: int) -> int:
        """The initial evidence, after which ELFI fits the process for the first time, and one acquisition."""
        return (self._num_initial(num_parameters) + 1) * self.events_per_theta

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """Infer as `Method.infer` describes. Raises BudgetExhausted when the budget ends before `min_simulations`."""
        elfi = import_elfi()
        prior, observed = problem.prior, problem.summary(problem.x_observed)
        num_initial = self._num_initial(prior.dim)
        # With too little left the metered simulator refuses, rather than ELFI answering without a fitted process.
        num_evidence = max(self._num_evidence(problem.simulate.remaining), num_initial + 1)
        events = np.round(self.events_per_theta * np.geomspace(1, self.growth, num_evidence)).astype(int)
        traced = set(np.linspace(num_evidence, num_initial, self.num_trace_points).astype(int).tolist())
        seed = int(rng.integers(2**32, dtype=np.uint32))
        box = Box((0,) * prior.dim, (1,) * prior.dim) if self.unit_box else prior
        points = qmc.scale(qmc.Sobol(prior.dim, rng=rng).random(self.num_posterior_points), box.low, box.high)
        tried: list[Evaluation] = []

        def raw(theta: NDArray) -> NDArray:
            return (1 - theta) * prior.low + theta * prior.high if self.unit_box else theta  # exact at the bounds

        def summaries(*theta: NDArray, batch_size: int, random_state: np.random.RandomState) -> NDArray:
            for one in raw(np.column_stack(theta)):
                x = problem.simulate.repeat(one, int(events[len(tried)]))[0]
                tried.append(Evaluation(one, problem.summary(x), problem.simulate.used))
            return np.stack([one.summary for one in tried[-batch_size:]])

        trace = []
        with global_seed(rng), own_client(elfi):
            bolfi = self._bolfi(elfi, *_distance(elfi, box, summaries, observed, self.log_distance), num_initial, seed)
            bolfi.set_objective(num_evidence)
            while not bolfi.finished:
                bolfi.iterate()
                if self.surrogate == "gpy" and bolfi.n_evidence % 10 == 0:
                    # ELFI builds a new GPy process for each evaluation; reference cycles keep the old ones, gigabytes
                    # after some hundred evaluations, because Python counts objects and not their size.
                    gc.collect()
                if bolfi.n_evidence in traced:
                    best, weights = _posterior(bolfi, points)
                    mean = weights @ raw(points)
                    std = np.sqrt(weights @ (raw(points) - mean) ** 2)
                    trace.append(TracePoint(problem.simulate.used, raw(best), std))
        how = "maximum of ELFI's posterior, where the mean of the Gaussian process of the distance is least"
        if self.regression:
            mean = _adjusted(tried, observed, prior)
            how = "mean of the nearest evaluations after a regression adjustment"
            trace[-1] = trace[-1]._replace(theta=mean)
        sample = WeightedSample(raw(points), weights)
        return Estimate(trace[-1].theta, how, "posterior", mean, std, trace, sample=sample)

    def _num_evidence(self, budget: int) -> int:
        most = budget // self.events_per_theta
        if self.growth == 1:
            return most
        mean = self.events_per_theta * (self.growth - 1) / np.log(self.growth)  # of the events for a theta
        return min(most, int(budget / mean * MARGIN))

    def _num_initial(self, num_parameters: int) -> int:
        return self.initial_evidence or max(10, 2**num_parameters + 1)

    def _bolfi(
        self, elfi, distance: "Distance", bounds: dict[str, tuple[float, float]], num_initial: int, seed: int
    ) -> "BOLFI":
        settings = {"exploration_rate": self.exploration_rate, "seed": seed}
        parts = {}
        if self.surrogate == "fast":
            from avobench.methods.bolfi_surrogate import fast

            parts = fast(distance.model, bounds, noise_var=float(self.acq_noise_var), **settings)
        return elfi.BOLFI(
            distance,
            bounds=bounds,
            initial_evidence=num_initial,
            update_interval=self.update_interval,
            acq_noise_var=float(self.acq_noise_var),
            **settings,
            **parts,
        )


@dataclass(frozen=True)
class BolfiTuned(Bolfi):
    """BOLFI at its best: settings that were chosen on targets other than the benchmark's, in a study of the paper."""

    name: ClassVar[str] = "bolfi-tuned"

    events_per_theta: int = 512
    initial_evidence: int | None = 50
    log_distance: bool = True


def _distance(
    elfi, box: Box, summaries: Callable[..., NDArray], observed: NDArray[np.float64], log: bool
) -> tuple["Distance", dict[str, tuple[float, float]]]:
    """ELFI's node of the distance between summaries at theta and the observed one (k,), and theta's bounds."""
    model, bounds = prior_model(elfi, box)
    theta = [model[name] for name in bounds]
    simulator = elfi.Simulator(summaries, *theta, observed=observed[None], model=model, name="summaries")
    distance = elfi.Distance("euclidean", simulator, model=model, name="distance")
    return elfi.Operation(_logarithm, distance, model=model, name="log_distance") if log else distance, bounds


def _logarithm(distance: NDArray[np.float64]) -> NDArray[np.float64]:
    """The logarithm of distances, shifted to be positive, as ELFI's process needs them."""
    return np.log1p(distance / LINEAR_BELOW)


def _adjusted(tried: list[Evaluation], observed: NDArray[np.float64], prior: Box) -> NDArray[np.float64]:
    """The regression-adjusted mean (p,) of the evaluations of the smallest distances, each of the same weight."""
    distances = [np.linalg.norm(one.summary - observed) for one in tried]
    nearest = np.argsort(distances, kind="stable")[: max(2, round(SHARE_NEAREST * len(tried)))]
    near = [tried[i] for i in nearest]
    theta = np.array([one.theta for one in near])
    return regressed(theta, np.full(len(near), 1 / len(near)), near, observed, prior)


def _posterior(bolfi: "BOLFI", points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Maximum (p,) of the posterior so far, searched from the best of the points (m, p), and their weights (m,)."""
    posterior = bolfi.extract_posterior()
    log_density = posterior.logpdf(points)
    best = minimize(
        lambda theta: -posterior.logpdf(theta[None])[0],
        points[log_density.argmax()],
        method="L-BFGS-B",
        bounds=bolfi.target_model.bounds,
    )
    weights = np.exp(log_density - log_density.max())
    return best.x, weights / weights.sum()
