"""Counts from a Poisson distribution whose logarithmic rate is unknown."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Box, Discriminator, Task


@dataclass(frozen=True)
class Poisson(Task):
    """x ~ Poisson(exp theta), one count an event: x (n, 1) int64.

    Parameter: `log_rate` = theta, dimensionless. Prior: U(0, 4). Support: [-10, 10], rates from 4.5e-5 to 22 026.
    Source: paper, Sections 4.1 and 4.3.

    Floor: the Fisher information of one event on theta is its rate exp theta, so N observed events leave a variance of
    1 / (N exp theta). For a method that knows the model only through n simulated events, the error of their comparison
    adds 1 / (n exp theta), as if theta had been measured with them too. Raises ValueError for `num_bins` below 1.
    """

    num_bins: int = 100
    """Bins of the summary: one an integer from 0 to num_bins - 1, and one more for everything above."""

    name: ClassVar = "poisson"
    parameter_names: ClassVar = ("log_rate",)
    parameter_units: ClassVar = ("1",)
    source: ClassVar = "Louppe, Hermans, Cranmer 2019, Sections 4.1 and 4.3"
    prior: ClassVar = Box((0,), (4,))
    support: ClassVar = Box((-10,), (10,))
    num_features: ClassVar = 1
    feature_names: ClassVar = ("count",)
    floor_shares: ClassVar = (1.0,)
    dtype: ClassVar = np.int64
    discriminator: ClassVar = Discriminator(hidden=(600,) * 3)

    def __post_init__(self) -> None:
        if not (isinstance(self.num_bins, int) and self.num_bins >= 1):
            raise ValueError(f"num_bins must be a whole number of at least 1, got {self.num_bins}")

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.int64]:
        """One count per row: theta (n, 1) -> x (n, 1). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.poisson(np.exp(theta))

    def summary(self, x: NDArray[np.int64]) -> NDArray[np.float64]:
        """Share of the events at each count and above the last one: (n, 1) -> (num_bins + 1,), summing to 1.

        Raises ValueError for a negative count.
        """
        return np.bincount(np.minimum(x[:, 0], self.num_bins), minlength=self.num_bins + 1) / len(x)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """1 / (N exp theta), plus 1 / (n exp theta) when the model is known only through n simulated events."""
        per_event = float(np.exp(-theta[0]))
        return per_event / num_observations + (0 if num_simulations is None else per_event / num_simulations)
