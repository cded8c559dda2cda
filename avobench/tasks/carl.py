"""Two unknown means among five independent variables, mixed linearly."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.contract import Box, Discriminator, Task, histogram

# As printed in carl's example: symmetric, and invertible (eigenvalues from 0.18 to 2.9).
MIXING = np.array(
    [
        [1.31229955, 0.10499961, 0.48310515, -0.3249938, -0.26387927],
        [0.10499961, 1.15833058, -0.55865473, 0.25275522, -0.39790775],
        [0.48310515, -0.55865473, 2.25874579, -0.52087938, -0.39271231],
        [-0.3249938, 0.25275522, -0.52087938, 1.4034925, -0.63521059],
        [-0.26387927, -0.39790775, -0.39271231, -0.63521059, 1.0],
    ]
)
MIXING.setflags(write=False)


@dataclass(frozen=True)
class Carl(Task):
    """x = R z, with R = MIXING (5, 5) and five independent components of z: x (n, 5) float64.

    z0 ~ N(alpha, 1), z1 ~ N(beta, 3), z2 ~ N(-2, 1) or N(2, 1/2) with equal chance, z3 ~ Exp(3), z4 ~ Exp(1/2), where
    N is given by mean and standard deviation and Exp by its rate.

    Parameters: `alpha`, `beta`, dimensionless. Prior: U(-2, 2) each. Support: [-20, 20] each.
    Source: Cranmer, Pavez, Louppe 2015 (arXiv:1506.02169), Section 4.2, with the numbers of the package carl's example
    "Parameterized inference from multidimensional data"; paper, Section 4.3.

    Floor: R is invertible, so x says as much as z, where alpha is the mean of a Gaussian of variance 1 and beta that of
    one of variance 9. N observed events leave 10 / N summed over both; a method that knows the model only through n
    simulated events adds 10 / n. Raises ValueError for `num_bins` below 1 or `bin_limit` not positive and finite.
    """

    num_bins: int = 30
    """Equal bins of the summary between -bin_limit and bin_limit, for each feature."""
    bin_limit: float = 15.0

    name: ClassVar = "carl"
    parameter_names: ClassVar = ("alpha", "beta")
    parameter_units: ClassVar = ("1", "1")
    source: ClassVar = "Cranmer, Pavez, Louppe 2015 (arXiv:1506.02169), Section 4.2"
    prior: ClassVar = Box((-2, -2), (2, 2))
    support: ClassVar = Box((-20, -20), (20, 20))
    num_features: ClassVar = 5
    floor_shares: ClassVar = (0.1, 0.9)
    discriminator: ClassVar = Discriminator(hidden=(100,) * 4)

    def __post_init__(self) -> None:
        if not (isinstance(self.num_bins, int) and self.num_bins >= 1):
            raise ValueError(f"num_bins must be a whole number of at least 1, got {self.num_bins}")
        if not 0 < self.bin_limit < np.inf:
            raise ValueError(f"bin_limit must be positive and finite, got {self.bin_limit}")

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 2) -> x (n, 5). Raises ValueError outside the support."""
        self.require_support(theta)
        n = len(theta)
        normal, exponential = rng.standard_normal((3, n)), rng.standard_exponential((2, n))
        z = np.stack(
            [
                theta[:, 0] + normal[0],
                theta[:, 1] + 3 * normal[1],
                np.where(rng.random(n) < 1 / 2, -2 + normal[2], 2 + normal[2] / 2),
                exponential[0] / 3,  # a rate of 3 is a mean of 1/3
                exponential[1] * 2,
            ],
            axis=1,
        )
        return z @ MIXING.T

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the events in each bin of each feature, under- and overflow included: (n, 5) -> (5 (num_bins + 2),).

        The shares of one feature sum to 1.
        """
        return histogram(x, np.linspace(-self.bin_limit, self.bin_limit, self.num_bins + 1), overflow=True)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """10 / N at any theta, plus 10 / n when the model is known only through n simulated events."""
        return 10 / num_observations + (0 if num_simulations is None else 10 / num_simulations)
