"""Laws that simulators of many fields have in common: theta (n, p) and a generator, to values (n,)."""

import numpy as np
from numpy.typing import NDArray

Rng = np.random.Generator


def poisson(theta: NDArray, rng: Rng) -> NDArray:
    """Return counts of events that come by chance, at one rate."""
    return rng.poisson(theta[:, 0])


def negative_binomial(theta: NDArray, rng: Rng) -> NDArray:
    """Return counts whose rate varies by a gamma distribution, of this mean and evenness."""
    return rng.poisson(rng.gamma(theta[:, 1], theta[:, 0] / theta[:, 1]))


def one_and_more(theta: NDArray, rng: Rng) -> NDArray:
    """Return one and a negative binomial number of further ones."""
    return 1 + negative_binomial(theta, rng)


def normal(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values."""
    return rng.normal(theta[:, 0], theta[:, 1])


def whole_normal(theta: NDArray, rng: Rng) -> NDArray:
    """Return normal values, rounded to whole units."""
    return np.round(normal(theta, rng))


def lognormal(theta: NDArray, rng: Rng) -> NDArray:
    """Return lognormal values."""
    return theta[:, 0] * np.exp(theta[:, 1] * rng.standard_normal(len(theta)))
