"""Effects that make an observation longer or shorter than that of the simulator, all events alike or not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter, Simulate
from avobench.effects.counts.feature import CountEffect, whole
from avobench.effects.noise import skewed_noise

LONGEST = 30.0
"""Times the simulator's own exposure; the tails of a distribution of rates are cut there."""


def exposed(
    simulate: Simulate,
    theta: NDArray[np.float64],
    g: NDArray[np.float64],
    rng: np.random.Generator,
    columns: Sequence[int] = (0,),
) -> NDArray:
    """Events whose counts in `columns` are over g times the exposure: g (n,) -> (n, d).

    Whole exposures are added, a part of one is thinned: of a Poisson count exactly that at g times the rate.
    """
    g, at = np.minimum(g, LONGEST), list(columns)
    x = simulate(theta, rng)
    x[:, at] = np.where(g[:, None] < 1, rng.binomial(whole(x[:, at]), np.minimum(g, 1)[:, None]), x[:, at])
    rows, remaining = np.flatnonzero(g > 1), g[g > 1] - 1
    while len(rows):
        more = whole(simulate(theta[rows], rng)[:, at])
        x[np.ix_(rows, at)] += rng.binomial(more, np.minimum(remaining, 1)[:, None])
        rows, remaining = rows[remaining > 1], remaining[remaining > 1] - 1
    return x


LOWEST = 0.3
"""The lower of two rates at least: below, it is a channel that is off now and then, another effect."""
HIGHEST = 1.8
"""The higher of two rates at most: above, it is two events in one, another effect."""
FALLEN = np.geomspace(1e-3, 8, 400)
"""Lifetimes over which a source may decay: from what changes no count to one that is used up."""
VARIANCES = FALLEN / 2 / np.tanh(FALLEN / 2) - 1
LEAST_VARIANCE = 1e-12
"""Variance at the null value: a scatter of 1e-6 of the rate, which changes no count."""


class Rates(NamedTuple):
    """A distribution of rates of mean 1."""

    highest: float
    """The largest relative variance with which it keeps its form."""
    parameters: tuple[Parameter, ...]
    drawn: Callable[[NDArray, NDArray, np.random.Generator], NDArray[np.float64]]
    """Relative variances (n,), phi (n, q) -> rates (n,)."""


def _lognormal(variance, phi, rng):
    s = np.sqrt(np.log1p(variance))
    return np.exp(s * rng.standard_normal(len(phi)) - s**2 / 2)


def _two_rates(variance, phi, rng):
    """A share w of the events at the higher of two rates, of which neither is a channel that is off."""
    w, s = phi[:, 1], np.sqrt(variance)
    high = rng.random(len(phi)) < w
    return np.clip(np.where(high, 1 + s * np.sqrt((1 - w) / w), 1 - s * np.sqrt(w / (1 - w))), LOWEST, HIGHEST)


def _flares(variance, phi, rng):
    """The rate is higher by an exponential amount in a share w of the events."""
    w, s = phi[:, 1], np.sqrt(variance)
    mean = s / (np.sqrt(w * (2 - w)) - s * w)  # of that amount, beside the quiet rate
    return (1 + mean * rng.standard_exponential(len(phi)) * (rng.random(len(phi)) < w)) / (1 + w * mean)


def _decaying(variance, phi, rng):
    """The rate falls exponentially while the events are taken."""
    fallen = np.interp(variance, VARIANCES, FALLEN)
    return np.exp(-fallen * rng.random(len(phi))) * fallen / -np.expm1(-fallen)


RATES = {
    "gamma": Rates(4.0, (), lambda v, phi, rng: rng.gamma(1 / v) * v),
    "lognormal": Rates(4.0, (), _lognormal),
    "skewed": Rates(
        0.5,
        (Parameter("skewness", -2, 2, None, "1"),),
        lambda v, phi, rng: np.maximum(1 + np.sqrt(v) * skewed_noise(phi[:, 1], rng), 0),
    ),
    # one period of a sine
    "drift": Rates(0.5, (), lambda v, phi, rng: 1 + np.sqrt(2 * v) * np.sin(2 * np.pi * rng.random(len(phi)))),
    "uniform": Rates(0.33, (), lambda v, phi, rng: 1 + np.sqrt(3 * v) * rng.uniform(-1, 1, len(phi))),
    "two_rates": Rates(1.0, (Parameter("share", 0.1, 0.9, None, "1"),), _two_rates),
    "decaying": Rates(1.0, (), _decaying),
    "flares": Rates(1.0, (Parameter("share", 0.01, 0.5, None, "1"),), _flares),
}
"""Distributions of rates by shape."""


@dataclass(frozen=True)
class Overdispersion(CountEffect):
    """The rate differs from event to event, with mean 1 and relative variance `variance`."""

    shape: str = "gamma"

    stage = 1
    name = "overdispersion"
    position = 2
    SHAPES: ClassVar = {shape: rates.parameters for shape, rates in RATES.items()}
    sentence: ClassVar = "The rate is not the same in every event, so the counts scatter more than they should."
    source: ClassVar = "M. Greenwood, G. U. Yule, J. R. Stat. Soc. 83 (1920) 255"

    def strength(self) -> Parameter:
        return Parameter("variance", 0, RATES[self.shape].highest, 0, "1")

    def apply(self, simulate, theta, phi, rng):
        rates = RATES[self.shape].drawn(np.maximum(phi[:, 0], LEAST_VARIANCE), phi, rng)
        return exposed(simulate, theta, rates, rng, self.columns)


@dataclass(frozen=True)
class PileUp(CountEffect):
    """A part of another event's counts falls into the window of each event.

    In the shape `sometimes` of a share of them. It is then any part up to `overlap`, as the other comes at any time. In
    `several` that part of each of a random number of others, `others` in the mean.
    """

    stage = 1
    name = "pile_up"
    position = 9
    STRENGTH = Parameter("overlap", 0, 1, 0, "1")
    SHAPES: ClassVar = {
        "": (),
        "sometimes": (Parameter("share", 0.01, 1, None, "1"),),
        "several": (Parameter("others", 0.05, 5, None, "1"),),
    }
    sentence: ClassVar = "Counts that belong to neighbouring events fall into an event."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.VII"

    def apply(self, simulate, theta, phi, rng):
        overlap = phi[:, 0]
        if self.shape == "sometimes":
            overlap = overlap * rng.random(len(phi)) * (rng.random(len(phi)) < phi[:, 1])
        if self.shape == "several":
            overlap = overlap * rng.poisson(phi[:, 1])
        return exposed(simulate, theta, 1 + overlap, rng, self.columns)


@dataclass(frozen=True)
class Inefficiency(CountEffect):
    """Each count is missed with a fixed probability."""

    name = "inefficiency"
    position = 10
    STRENGTH = Parameter("lost", 0, 0.98, 0, "1")
    sentence: ClassVar = "Every count has the same chance to be missed."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.V"

    def apply(self, simulate, theta, phi, rng):
        return exposed(simulate, theta, 1 - phi[:, 0], rng, self.columns)
