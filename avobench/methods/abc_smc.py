"""Sequential Monte Carlo approximate Bayesian computation with pyABC, within a hard budget."""

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import gaussian_kde

from avobench.methods.contract import Estimate, Method, TracePoint, global_seed
from avobench.methods.problem import Problem
from avobench.tasks import Box
from avobench.tasks.errors import BudgetExhausted, UsageError


@dataclass(frozen=True)
class AbcSmc(Method):
    """ABC-SMC as pyABC runs it by default, with a Euclidean distance between summaries.

    MedianEpsilon: a calibration sample of `population_size` prior draws sets the first threshold at the median of its
    distances, and each later generation is accepted under the weighted median distance of the one before.
    MultivariateNormalTransition: proposals are drawn from a weighted Gaussian kernel density of that generation;
    those outside the prior are redrawn before anything is simulated.

    pyABC is given no limit of its own: it runs until the metered simulator refuses, and the last complete generation is
    the posterior. `Estimate.discarded` counts the events of the generation that was cut short. Those of the
    calibration sample and of complete generations, accepted or not, are not counted: they shaped the estimate.
    """

    name: ClassVar[str] = "abc-smc"
    packages: ClassVar = ("pyabc",)
    extra: ClassVar = "abc-smc"
    source: ClassVar[str] = (
        "Toni and Stumpf, Bioinformatics 26 (2010) 104; Schaelte et al., Journal of Open Source Software 7 (2022) 4304"
    )

    population_size: int = 100
    """Particles accepted in each generation; pyABC's default."""
    events_per_theta: int = 128
    """Events simulated for each evaluated theta."""

    def __post_init__(self) -> None:
        if self.population_size < 2 or self.events_per_theta < 1:
            raise UsageError(
                "abc-smc needs population_size >= 2 and events_per_theta >= 1, "
                f"got {self.population_size} and {self.events_per_theta}"
            )

    def min_simulations(self, num_parameters: int) -> int:
        """Four populations: one calibrates, and the first generation, accepting about half, takes about two more.

        The fourth is a margin for chance. It is used up in 1 of 700 runs with a population of 100, 1 of 60 with 50,
        1 of 7 with 10; such a run raises BudgetExhausted. A population must have more particles than parameters, so
        that its covariance has full rank; raises UsageError otherwise.
        """
        if self.population_size <= num_parameters:
            raise UsageError(f"abc-smc needs population_size > {num_parameters}, the number of parameters")
        return 4 * self.population_size * self.events_per_theta

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """As `Method.infer`. Raises BudgetExhausted when the budget ends within the first generation."""
        import pyabc

        names, prior = problem.parameter_names, problem.prior

        def model(parameter: pyabc.Parameter) -> dict[str, NDArray]:
            theta = [[parameter[name] for name in names]]
            return {"summary": problem.summary(problem.simulate.repeat(theta, self.events_per_theta)[0])}

        used_before = problem.simulate.used
        message = ""
        with global_seed(rng), _quiet("ABC"):
            abc = pyabc.ABCSMC(
                model,
                pyabc.Distribution(
                    {
                        name: pyabc.RV("uniform", low, width)
                        for name, low, width in zip(names, prior.low, prior.width, strict=True)
                    }
                ),
                pyabc.PNormDistance(p=2),
                population_size=self.population_size,
                sampler=pyabc.SingleCoreSampler(),
            )
            history = abc.new("sqlite://", {"summary": problem.summary(problem.x_observed)})  # in memory, no file
            # pyABC never closes the session of a database in memory, and its engine then stays for a while or for good.
            # What SQLAlchemy's mappers compiled stays too, but of the last 50 to 75 runs only: some 20 MiB.
            with closing(history._session):
                try:
                    abc.run()
                    message = (
                        f"pyABC stopped by itself with {problem.simulate.remaining} events left: "
                        "the acceptance threshold is 0, all particles reproduce the observed summary exactly"
                    )
                except BudgetExhausted:
                    if history.n_populations == 0:
                        raise
                populations = history.get_all_populations().sort_values("t")  # t = -1 is the calibration sample
                evaluations = populations["samples"]
                used = used_before + self.events_per_theta * evaluations.cumsum().to_numpy()
                generations = [history.get_distribution(t=t) for t in range(history.n_populations)]

        trace = []
        for simulations, (particles, weights) in zip(used[1:], generations, strict=True):
            theta = particles[list(names)].to_numpy()
            mean = weights @ theta
            std = np.sqrt(weights @ (theta - mean) ** 2)
            trace.append(TracePoint(int(simulations), _density_mode(theta, weights, prior), std))
        return Estimate(
            theta=trace[-1].theta,
            how="maximum of a weighted kernel density estimate of the last complete generation",
            spread_of="posterior",
            mean=mean,
            std=std,
            trace=trace,
            discarded=problem.simulate.used - trace[-1].simulations,
            message=message,
        )


def _density_mode(theta: NDArray[np.float64], weights: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    """Where a Gaussian kernel density of weighted particles is largest in the box: (n, p), (n,) -> (p,).

    Bandwidth: Scott's rule, SciPy's default. Raises numpy's LinAlgError when the particles span no volume.
    """
    density = gaussian_kde(theta.T, weights=weights)
    start = theta[density.logpdf(theta.T).argmax()]
    bounds = list(zip(box.low, box.high, strict=True))
    return minimize(lambda point: -density.logpdf(point)[0], start, method="L-BFGS-B", bounds=bounds).x


@contextmanager
def _quiet(logger_name: str) -> Iterator[None]:
    """Let the package's logger pass warnings and errors only: pyABC logs each generation to stderr."""
    logger = logging.getLogger(logger_name)
    level = logger.level
    logger.setLevel(max(level, logging.WARNING))
    try:
        yield
    finally:
        logger.setLevel(level)
