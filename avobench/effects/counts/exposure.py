"""Counts of an observation longer or shorter than the simulator's: what changes the rate, not the recording."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Effect, Family, Parameter, Simulate, skewed_noise

LONGEST = 30.0
"""Times the simulator's own exposure; the tails of a distribution of rates are cut there."""

LOWEST, HIGHEST = 0.3, 1.8
"""Of two rates. Below, it is a channel that is off now and then, above, two events in one: other effects."""


def exposed(
    simulate: Simulate, theta: NDArray[np.float64], g: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Counts over g times the exposure: whole exposures are added, a part of one is thinned: g (n,) -> (n, 1).

    For a Poisson count this is exactly the count at g times the rate, and it asks nothing about theta's meaning.
    """
    g = np.minimum(g, LONGEST)
    x = simulate(theta, rng)
    x[:, 0] = np.where(g < 1, rng.binomial(x[:, 0], np.minimum(g, 1)), x[:, 0])
    rows, left = np.flatnonzero(g > 1), g[g > 1] - 1
    while len(rows):
        x[rows, 0] += rng.binomial(simulate(theta[rows], rng)[:, 0], np.minimum(left, 1))
        rows, left = rows[left > 1], left[left > 1] - 1
    return x


@dataclass(frozen=True)
class Overdispersion(Family):
    """The rate differs from event to event, with mean 1 and relative variance `variance`."""

    shape: str = "gamma"

    stage = 1
    name = "overdispersion"
    sentence: ClassVar = "The rate is not the same in every event, so the counts scatter more than they should."
    source: ClassVar = "M. Greenwood, G. U. Yule, J. R. Stat. Soc. 83 (1920) 255"
    SHAPES: ClassVar = {
        "gamma": (),
        "lognormal": (),
        "skewed": (Parameter("skewness", -2, 2, None, "1"),),
        "drift": (),
        "uniform": (),
        "two_rates": (Parameter("share", 0.1, 0.9, None, "1"),),
    }

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        high = {"gamma": 4.0, "lognormal": 4.0, "skewed": 0.5, "drift": 0.5, "uniform": 0.33, "two_rates": 1.0}[
            self.shape
        ]
        return (Parameter("variance", 0, high, 0, "1"), *self.SHAPES[self.shape])

    def apply(self, simulate, theta, phi, rng):
        variance = np.maximum(phi[:, 0], 1e-12)  # at the null a scatter of 1e-6 of the rate
        if self.shape == "gamma":
            g = rng.gamma(1 / variance) * variance
        elif self.shape == "lognormal":
            s = np.sqrt(np.log1p(variance))
            g = np.exp(s * rng.standard_normal(len(theta)) - s**2 / 2)
        elif self.shape == "skewed":
            g = np.maximum(1 + np.sqrt(variance) * skewed_noise(phi[:, 1], rng), 0)
        elif self.shape == "drift":  # one period of a sine
            g = 1 + np.sqrt(2 * variance) * np.sin(2 * np.pi * rng.random(len(theta)))
        elif self.shape == "uniform":
            g = 1 + np.sqrt(3 * variance) * rng.uniform(-1, 1, len(theta))
        else:  # a share w of the events at the higher of two rates, of which neither is a channel that is off
            w, s = phi[:, 1], np.sqrt(variance)
            high = rng.random(len(theta)) < w
            g = np.clip(np.where(high, 1 + s * np.sqrt((1 - w) / w), 1 - s * np.sqrt(w / (1 - w))), LOWEST, HIGHEST)
        return exposed(simulate, theta, g, rng)


@dataclass(frozen=True)
class PileUp(Effect):
    """A part of another event's counts falls into the window of each event."""

    stage = 1
    name = "pile_up"
    parameters = (Parameter("overlap", 0, 1, 0, "1"),)
    sentence: ClassVar = "Counts that belong to neighbouring events fall into every event."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.VII"

    def apply(self, simulate, theta, phi, rng):
        return exposed(simulate, theta, 1 + phi[:, 0], rng)


@dataclass(frozen=True)
class Inefficiency(Effect):
    """Each count is missed with a fixed probability."""

    name = "inefficiency"
    parameters = (Parameter("lost", 0, 0.98, 0, "1"),)
    sentence: ClassVar = "Every count has the same chance to be missed."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.V"

    def apply(self, simulate, theta, phi, rng):
        return exposed(simulate, theta, 1 - phi[:, 0], rng)
