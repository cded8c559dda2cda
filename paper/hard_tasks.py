"""Tasks of one feature whose parameters its mean hardly tells: a narrow peak, heavy tails, skewness.

Each floor is (1 / N + 1 / n) times the trace of the inverse Fisher information of an event, by quadrature. The records
of these tasks carry a hash of the source below: a class that changes makes them those of another task.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import levy_stable, norm
from scipy.stats import t as student

from avobench.tasks.contract import Box, Task, histogram

STEP = 1e-4
"""Step of the central differences of a density, in widths of the prior."""


def information(
    density: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    weights: NDArray[np.float64],
    theta: NDArray[np.float64],
    steps: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Fisher information of an event (p, p): the sum of slopes of the density in theta, squared, over the density.

    `density` takes theta (p,) to its values at points (m,), whose `weights` make a sum of them an integral.
    """
    slopes = [(density(theta + step) - density(theta - step)) / (2 * step.sum()) for step in np.diag(steps)]
    return (slopes * (weights / density(theta))) @ np.transpose(slopes)


class Informed(Task):
    """A task with a Fisher information that is known."""

    by_default = False

    @abstractmethod
    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Fisher information of one event on what it determines of theta (p,): (k, k)."""

    def floors(
        self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None
    ) -> NDArray[np.float64]:
        """The least variance of each number that events determine, see `floor`: (k,)."""
        share = 1 / num_observations + (0 if num_simulations is None else 1 / num_simulations)
        return share * np.linalg.inv(self.information(theta)).diagonal()

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        return float(self.floors(theta, num_observations, num_simulations).sum())


class Hard(Informed):
    """A task of one feature with a Fisher information that is known."""

    num_features = 1
    feature_names = ("x",)

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the events in each of 60 bins of arcsinh x, and below and above them: (n, 1) -> (62,)."""
        return histogram(np.arcsinh(x), np.linspace(-10, 10, 61), overflow=True)


class Bump(Hard):
    """A peak of 2 % of the events and width 0.01 on a flat background over [0, 1]. Prior of its centre: U(0.1, 0.9)."""

    name: ClassVar = "bump"
    parameter_names: ClassVar = ("centre",)
    parameter_units: ClassVar = ("1",)
    source: ClassVar = "this project"
    prior: ClassVar = Box((0.1,), (0.9,))
    support: ClassVar = Box((0.05,), (0.95,))
    floor_shares: ClassVar = (1.0,)
    share: ClassVar = 0.02
    width: ClassVar = 0.01

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 1) -> x (n, 1). Raises ValueError outside the support."""
        self.require_support(theta)
        return np.where(rng.random(theta.shape) < self.share, rng.normal(theta, self.width), rng.random(theta.shape))

    def summary(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the events in each of 100 bins: (n, 1) -> (100,)."""
        return histogram(x, np.linspace(0, 1, 101))

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        x = np.linspace(0, 1, 20_001)

        def density(theta: NDArray[np.float64]) -> NDArray[np.float64]:
            return 1 - self.share + self.share * norm.pdf(x, theta[0], self.width)

        return information(density, np.full(len(x), x[1]), theta, STEP * self.prior.width)


class StudentTails(Hard):
    """Student's t. Prior of its degrees of freedom: U(1, 10); at 1 it has no mean, and up to 2 no variance."""

    name: ClassVar = "student"
    parameter_names: ClassVar = ("freedom",)
    parameter_units: ClassVar = ("1",)
    source: ClassVar = "Student, Biometrika 6 (1908) 1"
    prior: ClassVar = Box((1.0,), (10.0,))
    support: ClassVar = Box((0.5,), (20.0,))
    floor_shares: ClassVar = (1.0,)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 1) -> x (n, 1). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.standard_t(theta)

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        u = np.linspace(-30, 30, 6001)  # of which x is the hyperbolic sine: tails go with a power
        return information(
            lambda theta: student.pdf(np.sinh(u), theta[0]), (u[1] - u[0]) * np.cosh(u), theta, STEP * self.prior.width
        )


class Stable(Hard):
    """Symmetric stable events: the characteristic function is exp(-|scale t|^alpha).

    Priors: U(1.1, 1.9) for alpha, U(-1, 1) for the logarithm of the scale. There is no variance.
    """

    name: ClassVar = "stable"
    parameter_names: ClassVar = ("alpha", "log_scale")
    parameter_units: ClassVar = ("1", "1")
    source: ClassVar = "J. M. Chambers, C. L. Mallows, B. W. Stuck, J. Am. Stat. Assoc. 71 (1976) 340"
    prior: ClassVar = Box((1.1, -1.0), (1.9, 1.0))
    support: ClassVar = Box((1.05, -2.0), (1.95, 2.0))

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 2) -> x (n, 1), by the formula of the source. Raises ValueError outside."""
        self.require_support(theta)
        alpha, angle = theta[:, 0], rng.uniform(-np.pi / 2, np.pi / 2, len(theta))
        x = np.sin(alpha * angle) / np.cos(angle) ** (1 / alpha)
        x *= (np.cos((1 - alpha) * angle) / rng.standard_exponential(len(theta))) ** ((1 - alpha) / alpha)
        return (np.exp(theta[:, 1]) * x)[:, None]

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        u = np.linspace(0, 15, 151)  # a half of the line, on which the derivative of the integrand in u ends at zero
        weights = (u[1] - u[0]) * np.where(u > 0, 2, 1) * np.cosh(u)

        def density(theta: NDArray[np.float64]) -> NDArray[np.float64]:
            return levy_stable.pdf(np.sinh(u), theta[0], 0, scale=np.exp(theta[1]))

        # the density is known to ten digits, so a wider step than of the others loses less
        return information(density, weights, theta, 10 * STEP * self.prior.width)


class GAndK(Hard):
    """The g-and-k distribution: x = a + b (1 + 0.8 tanh(g z / 2)) (1 + z^2)^k z with a standard Gaussian z.

    Priors: U(2, 4) for a, U(0.5, 1.5) for b, U(1, 3) for g and U(0, 1) for k.
    """

    name: ClassVar = "g-and-k"
    parameter_names: ClassVar = ("a", "b", "g", "k")
    parameter_units: ClassVar = ("1", "1", "1", "1")
    source: ClassVar = "G. D. Rayner, H. L. MacGillivray, Statistics and Computing 12 (2002) 57"
    prior: ClassVar = Box((2.0, 0.5, 1.0, 0.0), (4.0, 1.5, 3.0, 1.0))
    support: ClassVar = Box((0.0, 0.2, 0.0, 0.0), (6.0, 3.0, 6.0, 2.0))

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 4) -> x (n, 1). Raises ValueError outside the support."""
        self.require_support(theta)
        (a, b, g, k), z = theta.T, rng.standard_normal(len(theta))
        return (a + b * (1 + 0.8 * np.tanh(g * z / 2)) * (1 + z**2) ** k * z)[:, None]

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """By transport: with phi the density of z, the score at x(z) is -(phi v / x')' / phi, where v = dx / dtheta."""
        (a, b, g, k), z = theta, np.linspace(-8, 8, 16_001)
        skewed, phi = 1 + 0.8 * np.tanh(g * z / 2), norm.pdf(z)
        stretched = (1 + z**2) ** k * z
        of_g = b * 0.4 * z / np.cosh(g * z / 2) ** 2 * stretched
        moved = np.stack([np.ones_like(z), skewed * stretched, of_g, b * skewed * stretched * np.log1p(z**2)])
        slope = np.gradient(a + b * skewed * stretched, z)
        flow = np.gradient(phi * moved / slope, z, axis=1)
        return (flow / phi) @ flow.T * (z[1] - z[0])


class GAndKWide(GAndK):
    """The same with a prior of U(0, 10) for each parameter."""

    name: ClassVar = "g-and-k-wide"
    source: ClassVar = "D. Allingham, R. A. R. King, K. L. Mengersen, Statistics and Computing 19 (2009) 189"
    prior: ClassVar = Box((0.0,) * 4, (10.0,) * 4)
    support: ClassVar = Box((-5.0, 0.0, -5.0, 0.0), (15.0, 15.0, 15.0, 12.0))


HARD = (Bump, StudentTails, Stable, GAndK, GAndKWide)
