"""Random functions of a place in the range of a feature, or of the time: from [0, 1] to [0, 1]."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GRID = np.linspace(0, 1, 1001)
"""Where a function is known; it is interpolated between."""
CLASSES = ("constant", "linear", "monotone", "smooth", "stepped", "local", "periodic")


@dataclass(frozen=True)
class Function:
    """A function whose least value is 0 and whose largest is 1, unless it is constant, which is 1."""

    kind: str
    """One of CLASSES."""
    values: NDArray[np.float64]
    """On GRID, (1001,)."""

    def __call__(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values at places u, of any shape; beyond [0, 1] those of its ends."""
        return np.interp(u, GRID, self.values)

    @property
    def turns(self) -> int:
        """How often it changes from rising to falling or back."""
        slopes = np.sign(np.diff(self.values))
        slopes = slopes[slopes != 0]
        return int((slopes[1:] != slopes[:-1]).sum())

    @property
    def half(self) -> float:
        """Where a function that rises, or falls, is at a half: in [0, 1]."""
        above = self.values >= 0.5
        return float(GRID[np.argmax(above != above[0])])

    def sample(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Random places of which it is the density: (n,)."""
        below = np.r_[0, np.cumsum(self.values[1:] + self.values[:-1])]
        return np.interp(rng.random(n), below / below[-1], GRID)


def gaussian_process(length: float, rng: np.random.Generator, features: int = 60) -> NDArray[np.float64]:
    """A sample of a Gaussian process of variance 1 with a squared exponential covariance, on GRID: (1001,).

    By random Fourier features: A. Rahimi, B. Recht, NIPS 20 (2007).
    """
    frequency, phase = rng.normal(0, 1 / length, features), rng.uniform(0, 2 * np.pi, features)
    waves = np.cos(np.outer(GRID, frequency) + phase)
    return np.sqrt(2 / features) * waves @ rng.standard_normal(features)


def log_uniform(low: float, high: float, rng: np.random.Generator) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw(kind: str, rng: np.random.Generator) -> Function:
    """A random function of a class."""
    values = _MADE[kind](rng)
    low, high = values.min(), values.max()
    return Function(kind, (values - low) / (high - low) if high > low else np.ones_like(GRID))


def _monotone(rng: np.random.Generator) -> NDArray[np.float64]:
    """The integral of the exponential of a Gaussian process: it rises, or falls, however unevenly."""
    slope = np.exp(rng.uniform(1, 5) * gaussian_process(log_uniform(0.2, 1.5, rng), rng))
    rising = np.r_[0, np.cumsum(slope[1:] + slope[:-1])]
    return rising if rng.random() < 0.5 else -rising


def _stepped(rng: np.random.Generator) -> NDArray[np.float64]:
    """One to three steps of random heights at random places."""
    places = rng.uniform(0.05, 0.95, rng.integers(1, 4))
    return (rng.standard_normal(len(places)) * (GRID[:, None] > places)).sum(axis=1)


def _local(rng: np.random.Generator) -> NDArray[np.float64]:
    """A bump: Gaussian, a box, or with wide tails."""
    distance = np.abs(GRID - rng.uniform(0.03, 0.97)) / log_uniform(0.008, 0.12, rng)
    return (np.exp(-(distance**2) / 2), 1.0 * (distance < np.sqrt(3)), 1 / (1 + distance**2))[rng.integers(3)]


def _periodic(rng: np.random.Generator) -> NDArray[np.float64]:
    """Two to ten periods of a sine, or of a square wave."""
    wave = np.cos(2 * np.pi * (log_uniform(2, 10, rng) * GRID + rng.random()))
    return wave if rng.random() < 0.7 else np.sign(wave)


_MADE = {
    "constant": lambda rng: np.ones_like(GRID),
    "linear": lambda rng: GRID * rng.choice([-1, 1]),
    "monotone": _monotone,
    "smooth": lambda rng: gaussian_process(log_uniform(0.08, 0.4, rng), rng),
    "stepped": _stepped,
    "local": _local,
    "periodic": _periodic,
}
