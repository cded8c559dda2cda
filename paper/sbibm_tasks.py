"""Six simulators of others, those of the benchmark sbibm of which the Fisher information of an event is known.

The source is J.-M. Lueckmann, J. Boelts, D. Greenberg, P. Goncalves, J. Macke, "Benchmarking simulation-based
inference", AISTATS 2021 (arXiv:2101.04653), appendix T, and its package sbibm 1.1.0. There an observation is one event
or a few. Here it is a sample of events. Priors are uniform here, where the source has Gaussian ones for `glm` and
log-normal ones for `sir`; the stimulus of `glm` is another draw. The records of these tasks carry a hash of the source
below: a class that changes makes them those of another task.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit
from scipy.stats import norm

from avobench.tasks.contract import Box
from paper.hard_tasks import Informed


class OfOthers(Informed):
    """A task of sbibm, with means and standard deviations of the features as a summary."""

    source: ClassVar[str] = "sbibm 1.1.0, arXiv:2101.04653"

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """Mean and standard deviation of each feature: (n, d) -> (2 d,)."""
        return np.concatenate([x.mean(axis=0), x.std(axis=0)])


class GaussianLinear(OfOthers):
    """Ten independent Gaussians of variance 0.1, whose means are the parameters, with a prior of U(-1, 1) each."""

    name: ClassVar = "gaussian-linear"
    parameter_names: ClassVar = tuple(f"mean_{k}" for k in range(10))
    parameter_units: ClassVar = ("1",) * 10
    prior: ClassVar = Box((-1.0,) * 10, (1.0,) * 10)
    support: ClassVar = Box((-1.5,) * 10, (1.5,) * 10)
    num_features: ClassVar = 10

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 10) -> x (n, 10). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.normal(theta, np.sqrt(0.1))

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.eye(10) / 0.1


class GaussianMixture(OfOthers):
    """Two Gaussians in two dimensions with a mean in common and equal shares: one is ten times as wide as the other."""

    name: ClassVar = "gaussian-mixture"
    parameter_names: ClassVar = ("mean_1", "mean_2")
    parameter_units: ClassVar = ("1", "1")
    prior: ClassVar = Box((-10.0,) * 2, (10.0,) * 2)
    support: ClassVar = Box((-12.0,) * 2, (12.0,) * 2)
    num_features: ClassVar = 2

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 2) -> x (n, 2). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.normal(theta, rng.choice([1.0, 0.1], (len(theta), 1)))

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        r, step = np.linspace(0, 8, 80_001, retstep=True)
        each = np.stack([np.exp(-((r / width) ** 2) / 2) / (2 * np.pi * width**2) for width in (1.0, 0.1)]) / 2
        slope = r * (each[0] + each[1] / 0.1**2)  # along the direction from the centre, of which a half is along each
        return np.eye(2) * (np.pi * r * slope**2 / each.sum(axis=0)).sum() * step


class TwoMoons(OfOthers):
    """A crescent that theta shifts. The sign of the sum of both parameters is open.

    Its ends are sharp, which an estimator may use beyond the information of the smooth part that is told here.
    """

    name: ClassVar = "two-moons"
    parameter_names: ClassVar = ("theta_1", "theta_2")
    parameter_units: ClassVar = ("1", "1")
    prior: ClassVar = Box((-1.0,) * 2, (1.0,) * 2)
    support: ClassVar = Box((-1.2,) * 2, (1.2,) * 2)
    num_features: ClassVar = 2

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 2) -> x (n, 2). Raises ValueError outside the support."""
        self.require_support(theta)
        angle, radius = rng.uniform(-np.pi / 2, np.pi / 2, len(theta)), rng.normal(0.1, 0.01, len(theta))
        known = self.identifiable(theta) * [-1, 1]
        return known + np.stack([0.25 + radius * np.cos(angle), radius * np.sin(angle)], axis=1)

    def identifiable(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far the crescent is shifted to the left and up: theta (n, 2) -> (n, 2)."""
        return np.stack([np.abs(theta.sum(axis=1)), theta[:, 1] - theta[:, 0]], axis=1) / np.sqrt(2)

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        r, step = np.linspace(0.05, 0.15, 10_001, retstep=True)
        outwards = (r - 0.1) / 0.01**2 + 1 / r
        return np.eye(2) / 2 * (norm.pdf(r, 0.1, 0.01) * outwards**2).sum() * step


class Slcp(OfOthers):
    """Four draws of a Gaussian in two dimensions: its means, two roots of its standard deviations, and a correlation.

    The signs of the roots are open.
    """

    name: ClassVar = "slcp"
    parameter_names: ClassVar = ("mean_1", "mean_2", "root_1", "root_2", "atanh_rho")
    parameter_units: ClassVar = ("1",) * 5
    prior: ClassVar = Box((-3.0,) * 5, (3.0,) * 5)
    support: ClassVar = Box((-3.5,) * 5, (3.5,) * 5)
    num_features: ClassVar = 8

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 5) -> x (n, 8), of four draws. Raises ValueError outside the support."""
        self.require_support(theta)
        z = rng.standard_normal((4, 2, len(theta)))
        widths, rho = theta[:, 2:4].T ** 2, np.tanh(theta[:, 4])
        z[:, 1] = rho * z[:, 0] + np.sqrt(1 - rho**2) * z[:, 1]
        return (theta[:, :2].T + widths * z).reshape(8, -1).T

    def identifiable(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Theta without the signs of the roots: (n, 5) -> (n, 5)."""
        return np.concatenate([theta[:, :2], np.abs(theta[:, 2:4]), theta[:, 4:]], axis=1)

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        (a, b), rho = np.abs(theta[2:4]), np.tanh(theta[4])
        inverse = np.linalg.inv([[a**4, rho * a**2 * b**2], [rho * a**2 * b**2, b**4]])
        slopes = np.array(
            [
                [[4 * a**3, 2 * rho * a * b**2], [2 * rho * a * b**2, 0]],
                [[0, 2 * rho * a**2 * b], [2 * rho * a**2 * b, 4 * b**3]],
                [[0, (1 - rho**2) * a**2 * b**2], [(1 - rho**2) * a**2 * b**2, 0]],
            ]
        )
        found = np.zeros((5, 5))
        found[:2, :2] = inverse
        found[2:, 2:] = np.einsum("aij,bji->ab", inverse @ slopes, inverse @ slopes) / 2
        return 4 * found


class Glm(OfOthers):
    """A neuron that fires or not in each of a hundred bins of time, by a logistic regression on a known stimulus.

    An event is the sufficient statistic: the number of spikes, and sums over them of the nine latest stimuli.
    """

    name: ClassVar = "glm"
    parameter_names: ClassVar = ("offset", *(f"filter_{k}" for k in range(9)))
    parameter_units: ClassVar = ("1",) * 10
    prior: ClassVar = Box((-1.5,) * 10, (1.5,) * 10)
    support: ClassVar = Box((-2.0,) * 10, (2.0,) * 10)
    num_features: ClassVar = 10

    @property
    def design(self) -> NDArray[np.float64]:
        """What each bin is regressed on: (100, 10)."""
        stimulus = np.random.default_rng(42).standard_normal(100)
        return np.stack([np.ones(100), *(np.append(np.zeros(k), stimulus[: 100 - k]) for k in range(9))], axis=1)

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """One event per row: theta (n, 10) -> x (n, 10). Raises ValueError outside the support."""
        self.require_support(theta)
        design = self.design
        return (rng.random((len(theta), len(design))) < expit(theta @ design.T)) @ design

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        design = self.design
        chance = expit(design @ theta)
        return (design.T * chance * (1 - chance)) @ design


class Sir(OfOthers):
    """An epidemic in a million people, one of them infected at first: of 1 000 tested, those infected, on ten days."""

    name: ClassVar = "sir"
    parameter_names: ClassVar = ("contact_rate", "recovery_rate")
    parameter_units: ClassVar = ("1/day", "1/day")
    prior: ClassVar = Box((0.2, 0.08), (1.0, 0.18))
    support: ClassVar = Box((0.15, 0.06), (1.1, 0.2))
    num_features: ClassVar = 10
    dtype: ClassVar = np.int64

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.int64]:
        """One event per row: theta (n, 2) -> x (n, 10). Raises ValueError outside the support."""
        self.require_support(theta)
        return rng.binomial(1000, self.infected(theta))

    @staticmethod
    def infected(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of the people who are infected on days 0, 17, ... 153, by Runge-Kutta: theta (n, 2) -> (n, 10)."""
        contact, recovery = theta.T

        def change(state: NDArray[np.float64]) -> NDArray[np.float64]:
            new = contact * state[0] * state[1]
            return np.stack([-new, new - recovery * state[1]])

        state, found, step = np.tile([[1 - 1e-6], [1e-6]], len(theta)), [], 0.5
        for k in range(153 * 2 + 1):
            if k % 34 == 0:
                found.append(state[1])
            first = change(state)
            second = change(state + step / 2 * first)
            third = change(state + step / 2 * second)
            state = state + step / 6 * (first + 2 * second + 2 * third + change(state + step * third))
        return np.stack(found, axis=1)

    def information(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        chance, steps = self.infected(theta[None])[0], 1e-5 * np.eye(2)
        slopes = (self.infected(theta + steps) - self.infected(theta - steps)) / 2e-5
        return (slopes * 1000 / (chance * (1 - chance))) @ slopes.T


SBIBM = (GaussianLinear, GaussianMixture, TwoMoons, Slcp, Glm, Sir)
"""The tasks, by increasing difficulty."""
