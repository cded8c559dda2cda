"""Decay times of an unstable particle, measured by a clock of finite resolution."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import exponnorm

from avobench.tasks import Box, Discriminator, Task
from avobench.tasks.contract import histogram


@dataclass(frozen=True)
class DecayTime(Task):
    """x = t + e, with t ~ Exp(mean tau) the true decay time and e ~ N(0, resolution): x (n, 1) float64, in us.

    Parameter: `lifetime` = tau in us. Prior: U(1, 4), around the muon's 2.197 us. Support: [0.1, 20].

    Floor: 1 / (N I), with I the Fisher information of one measured time on tau, by numerical integration of the density
    of x, an exponentially modified Gaussian. Without resolution I is 1 / tau^2. For a method that knows the model only
    through n simulated events, the error of their comparison adds 1 / (n I).
    """

    resolution: float = 0.5
    """Standard deviation of the clock, in us."""

    name: ClassVar = "decay-time"
    parameter_names: ClassVar = ("lifetime",)
    parameter_units: ClassVar = ("us",)
    source: ClassVar = "Grushka, Analytical Chemistry 44 (1972) 1733, for the exponentially modified Gaussian"
    prior: ClassVar = Box((1,), (4,))
    support: ClassVar = Box((0.1,), (20,))
    num_features: ClassVar = 1
    discriminator: ClassVar = Discriminator(hidden=(100,) * 3)

    def __post_init__(self) -> None:
        if not 0 < self.resolution < np.inf:
            raise ValueError(f"resolution must be positive and finite, got {self.resolution}")

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One measured time per row: theta (n, 1) -> x (n, 1). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.exponential(theta) + rng.normal(0, self.resolution, theta.shape)

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the times in bins of 0.5 us from -2 to 20 us, below and above: (n, 1) -> (46,), summing to 1."""
        return histogram(x, np.linspace(-2, 20, 45), overflow=True)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """1 / (N I), plus 1 / (n I) when the model is known only through n simulated events. In us^2."""
        per_event = 1 / self.information(theta[0])
        return per_event / num_observations + (0 if num_simulations is None else per_event / num_simulations)

    def information(self, lifetime: float) -> float:
        """E[(d log p / d tau)^2] of one event at tau = lifetime, in 1/us^2; the derivative is a central difference."""
        step = 1e-4 * lifetime

        def log_density(x: float, tau: float) -> float:
            return exponnorm.logpdf(x, tau / self.resolution, scale=self.resolution)

        def integrand(x: float) -> float:
            score = (log_density(x, lifetime + step) - log_density(x, lifetime - step)) / (2 * step)
            return score**2 * np.exp(log_density(x, lifetime))

        # Beyond these ends lies less than 1e-15 of the density; it bends within a few resolutions of zero.
        ends = -8 * self.resolution, 8 * self.resolution + 40 * lifetime
        return quad(integrand, *ends, points=[0, 8 * self.resolution], limit=200)[0]
