"""Sequential Monte Carlo approximate Bayesian computation with pyABC, within a hard budget."""

import logging
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import gaussian_kde

from avobench.methods.contract import LATER, Estimate, Method, TracePoint, WeightedSample, global_seed
from avobench.methods.problem import Problem
from avobench.methods.regression import Evaluation, regressed
from avobench.tasks import Box
from avobench.tasks.errors import BudgetExhausted, UsageError

HOW = {
    "mode": "maximum of a weighted kernel density estimate of the last complete generation",
    "mean": "weighted mean of the last complete generation",
    "regression": "weighted mean of the last complete generation, after a regression adjustment",
}


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
    """Events simulated for each evaluated theta, in the calibration and the first generation."""
    growth: float = field(default=1.0, metadata=LATER)
    """Factor by which the events for each evaluated theta grow from generation to generation."""
    estimate: Literal["mode", "mean", "regression"] = field(default="mode", metadata=LATER)
    """The estimate from the last generation: the maximum of its density, its mean, or its mean after a regression
    adjustment."""

    def __post_init__(self) -> None:
        if self.population_size < 2 or self.events_per_theta < 1 or self.growth < 1:
            raise UsageError(
                f"{self.name} needs population_size >= 2, events_per_theta >= 1 and growth >= 1, "
                f"got {self.population_size}, {self.events_per_theta} and {self.growth}"
            )
        if self.estimate not in HOW:
            raise UsageError(f"{self.name} needs estimate {', '.join(HOW)}, got {self.estimate!r}")

    def min_simulations(self, num_parameters: int) -> int:
        """Four populations: one calibrates, and the first generation, accepting about half, takes about two more.

        The fourth is a margin for chance. It is used up in 1 of 700 runs with a population of 100, 1 of 60 with 50,
        1 of 7 with 10; such a run raises BudgetExhausted. A population must have more particles than parameters, so
        that its covariance has full rank; raises UsageError otherwise.
        """
        if self.population_size <= num_parameters:
            raise UsageError(f"{self.name} needs population_size > {num_parameters}, the number of parameters")
        return 4 * self.population_size * self.events_per_theta

    def infer(self, problem: Problem, rng: np.random.Generator) -> Estimate:
        """Infer as `Method.infer` describes. Raises BudgetExhausted when the budget ends within the first generation.

        Raises ArithmeticError where pyABC's weights are no numbers, as those of few particles of many parameters.
        """
        import pyabc

        names, prior = problem.parameter_names, problem.prior
        observed = problem.summary(problem.x_observed)
        tried: list[Evaluation] = []

        def model(parameter: pyabc.Parameter) -> dict[str, NDArray]:
            theta = np.array([[parameter[name] for name in names]])
            events = round(self.events_per_theta * self.growth**history.n_populations)
            summary = problem.summary(problem.simulate.repeat(theta, events)[0])
            tried.append(Evaluation(theta[0], summary, problem.simulate.used))
            return {"summary": summary}

        message = ""
        with global_seed(rng), _quiet("ABC"), self._weighed(len(names)):
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
            history = abc.new("sqlite://", {"summary": observed})  # in memory, no file
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
                ends = populations["samples"].cumsum().to_numpy()  # evaluations until then, in the order of `tried`
                generations = [history.get_distribution(t=t) for t in range(history.n_populations)]

        trace = []
        for begin, end, (particles, weights) in zip(ends, ends[1:], generations, strict=False):
            theta = particles[list(names)].to_numpy()
            mean = weights @ theta
            std = np.sqrt(weights @ (theta - mean) ** 2)
            if self.estimate == "regression":
                mean = regressed(theta, weights, tried[begin:end], observed, prior)
            best = _density_mode(theta, weights, prior) if self.estimate == "mode" else mean
            trace.append(TracePoint(int(tried[end - 1].simulations), best, std))
        return Estimate(
            theta=trace[-1].theta,
            how=HOW[self.estimate],
            spread_of="posterior",
            mean=mean,
            std=trace[-1].std,
            trace=trace,
            discarded=problem.simulate.used - trace[-1].simulations,
            sample=WeightedSample(theta, weights),
            message=message,
        )

    @contextmanager
    def _weighed(self, num_parameters: int) -> Iterator[None]:
        """Raise ArithmeticError, in one line, where pyABC's weights are no numbers."""
        try:
            yield
        except (AssertionError, ValueError) as error:
            if "nan" not in str(error).lower():
                raise
            raise ArithmeticError(
                f"pyABC cannot weigh {self.population_size} particles of {num_parameters} parameters ({error}); "
                "take a larger population_size"
            ) from error


@dataclass(frozen=True)
class AbcSmcTuned(AbcSmc):
    """ABC-SMC at its best: settings that were chosen on targets other than the benchmark's, in a study of the paper."""

    name: ClassVar[str] = "abc-smc-tuned"

    population_size: int = 20
    events_per_theta: int = 512
    estimate: Literal["mode", "mean", "regression"] = "regression"


def _density_mode(theta: NDArray[np.float64], weights: NDArray[np.float64], box: Box) -> NDArray[np.float64]:
    """The maximum in the box of a Gaussian kernel density of weighted particles: (n, p), (n,) -> (p,).

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
