"""Small simulators beside the tasks, so that what effects look like is not learnt from those alone."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Box, Task

Draw = Callable[[NDArray[np.float64], np.random.Generator], Any]
"""Parameters, one a row (p, n), rng -> features (n,), one or several."""


def simulator(name: str, prior: Box, support: Box, draw: Draw, *, features: int = 1, counts: bool = False) -> Task:
    """A task of which only the events matter: parameters p0, p1, ... within these boxes."""

    class Small(Task):
        def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
            drawn = draw(theta.T, rng)
            return np.stack(drawn, axis=1) if features > 1 else np.asarray(drawn)[:, None]

        def summary(self, x: NDArray) -> NDArray[np.float64]:
            return x.mean(axis=0)

        def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
            return 1.0

    Small.name, Small.prior, Small.support, Small.num_features = name, prior, support, features
    Small.dtype = np.int64 if counts else np.float64
    Small.parameter_names = tuple(f"p{k}" for k in range(prior.dim))
    Small.parameter_units = ("1",) * prior.dim
    Small.source = "a textbook distribution"
    Small.__abstractmethods__ = frozenset()
    return Small()


def peak(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """A share of events in a peak, at a mean, above a falling background from 80 to 110."""
    share, mean = theta
    inside, n = rng.random(len(share)) < share, len(share)
    return np.where(inside, rng.normal(mean, 1.0), rng.exponential(15, n) % 30 + 80)


def window(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """A resonance at a mean, of a width, of which only what lies between 80 and 100 is kept."""
    mean, width = theta
    low, high = (np.arctan((edge - mean) / width) for edge in (80, 100))
    return mean + width * np.tan(rng.uniform(low, high))


def populations(theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Two normal populations: the share, mean and width of the first, and the mean of the second."""
    share, mean, std, other = theta
    first = rng.random(len(share)) < share
    return np.where(first, rng.normal(mean, std), rng.normal(other, 0.5))


def correlated(theta: NDArray[np.float64], rng: np.random.Generator) -> tuple[NDArray[np.float64], ...]:
    """Two normal features with a correlation."""
    mean, rho = theta
    a, b = rng.normal(size=(2, len(mean)))
    return mean + a, rho * a + np.sqrt(1 - rho**2) * b


def mixed(theta: NDArray[np.float64], rng: np.random.Generator) -> tuple[NDArray[np.float64], ...]:
    """Three independent features of different form."""
    scale, mean = theta
    return rng.exponential(scale), rng.normal(mean, 1), rng.gamma(2, scale)


def chain(theta: NDArray[np.float64], rng: np.random.Generator) -> tuple[NDArray[np.float64], ...]:
    """Four features, of which later ones depend on earlier ones."""
    mean, slope = theta
    n = len(mean)
    a, b = rng.normal(mean, 1), rng.uniform(-1, 1, n)
    return a, b, a * slope + rng.normal(0, 0.5, n), rng.exponential(1 + b**2)


SIMULATORS: dict[str, Task] = {
    task.name: task
    for task in (
        simulator("poissons", Box((0.3,), (60,)), Box((0.1,), (80,)), lambda t, rng: rng.poisson(t[0]), counts=True),
        simulator("rare", Box((-2,), (2,)), Box((-3.5,), (3,)), lambda t, rng: rng.poisson(np.exp(t[0])), counts=True),
        simulator(
            "negative-binomial",
            Box((1, 1), (12, 8)),
            Box((0.5, 0.5), (15, 12)),
            lambda t, rng: rng.poisson(rng.gamma(t[1], t[0] / t[1])),
            counts=True,
        ),
        simulator(
            "binomial", Box((0.1,), (0.9,)), Box((0.02,), (0.98,)), lambda t, rng: rng.binomial(20, t[0]), counts=True
        ),
        simulator(
            "geometric", Box((0.1,), (0.7,)), Box((0.03,), (0.9,)), lambda t, rng: rng.geometric(t[0]) - 1, counts=True
        ),
        simulator("exponential", Box((0.5,), (5,)), Box((0.2,), (9,)), lambda t, rng: rng.exponential(t[0])),
        simulator("gamma", Box((1.5, 0.5), (6, 2)), Box((1, 0.2), (9, 4)), lambda t, rng: rng.gamma(t[0], t[1])),
        simulator("normal", Box((-2, 0.5), (2, 2)), Box((-4, 0.2), (4, 4)), lambda t, rng: rng.normal(t[0], t[1])),
        simulator(
            "lognormal", Box((0, 0.2), (2, 1)), Box((-1, 0.05), (3, 2)), lambda t, rng: rng.lognormal(t[0], t[1])
        ),
        simulator("peak", Box((0.05, 86), (0.9, 96)), Box((0, 83), (1, 100)), peak),
        simulator("window", Box((88, 0.5), (94, 3)), Box((84, 0.2), (97, 6)), window),
        simulator(
            "populations",
            Box((0.1, 0, 0.2, 2.5), (0.9, 1.5, 0.8, 5)),
            Box((0, -1, 0.1, 1.5), (1, 3, 1.5, 7)),
            populations,
        ),
        simulator("beta", Box((1, 1), (4, 4)), Box((0.5, 0.5), (7, 7)), lambda t, rng: rng.beta(t[0], t[1])),
        simulator("correlated", Box((-1, -0.6), (1, 0.6)), Box((-2, -0.9), (2, 0.9)), correlated, features=2),
        simulator("mixed", Box((0.5, -1), (3, 1)), Box((0.2, -2), (5, 2)), mixed, features=3),
        simulator("chain", Box((-1, -1), (1, 1)), Box((-2, -2), (2, 2)), chain, features=4),
    )
}
"""The small simulators by name."""
