"""What can data tell apart? `python -m paper.tables.indistinguishable` prints exact likelihoods.

A count, and the cosine of an angle, have exact distributions under several effects. A row takes one effect, so strong
that the simulator as it is misses its distribution by SEEN in the log likelihood expected of NUM_EVENTS events, and
fits every effect of another family to it, the simulator's parameter along with all its own. What is left then is all
that any search can have to tell the two apart: below about 1 it cannot, and two names are a tie, whatever is done.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import expit
from scipy.stats import binom, nbinom, norm, poisson

NUM_EVENTS = 50_000
"""As many as a data set of `avobench challenge` has."""
SEEN = 30.0
"""Twice as much is a chi-squared of 60 for the effect alone: no test misses it."""
RATE = 30.0
"""Of the counts: in the middle of what the prior allows."""
COUNTS = np.arange(120)
"""All that have a probability: beyond, RATE leaves next to none."""
ASYMMETRY = 0.3
"""Of the cosine c, whose density is 1 + c^2 + 2 a c, up to a factor: a of electroweak interference."""
BINS = 200
"""Of the cosine."""
COSINE = (2 * np.arange(BINS) + 1) / BINS - 1

Pmf = NDArray[np.float64]


def _poisson(rate: float) -> Pmf:
    return poisson.pmf(COUNTS, rate)


def _after(kernel: Callable[[NDArray, float], Pmf]) -> Callable[..., Pmf]:
    """The distribution of counts each of which becomes another by `kernel`: (y - x or y, x), strength -> (K, K)."""
    return lambda rate, strength: kernel(COUNTS, strength) @ _poisson(rate)


def _noise(rate: float, sigma: float) -> Pmf:
    edges = np.r_[-np.inf, COUNTS[:-1] + 0.5, np.inf]
    return np.diff(norm.cdf((edges[:, None] - COUNTS) / max(sigma, 1e-3)), axis=0) @ _poisson(rate)


def _lost(rate: float, lost: float, threshold: float) -> Pmf:
    """About the threshold, as wide as three tenths of its root: the shape `turn_on`."""
    kept = _poisson(rate) * (1 - lost * expit((threshold - COUNTS) / (0.3 * np.sqrt(threshold))))
    return kept / kept.sum()


def _dead(rate: float, tau: float) -> Pmf:
    """At least n are counted if the n-th of those that were seen came before the end: a gamma distribution."""
    free = np.maximum(1 - (COUNTS - 1) * tau, 0)
    at_least = np.where(COUNTS == 0, 1.0, poisson.sf(COUNTS - 1, rate * free))
    return at_least - np.r_[at_least[1:], 0]


def _angles(asymmetry: float) -> Pmf:
    density = 1 + COSINE**2 + 2 * asymmetry * COSINE
    return density / density.sum()


def _kept(efficiency: Callable[..., NDArray[np.float64]]) -> Callable[..., Pmf]:
    """The distribution of cosines of which `efficiency` (phi) -> (BINS,) is kept."""

    def pmf(asymmetry: float, *phi: float) -> Pmf:
        kept = _angles(asymmetry) * efficiency(*phi)
        return kept / kept.sum()

    return pmf


def _smeared(asymmetry: float, sigma: float) -> Pmf:
    """What would lie beyond an end is folded back."""
    edges = np.arange(BINS + 1) * 2 / BINS - 1
    kernel = sum(np.diff(norm.cdf((edges[:, None] - at) / sigma), axis=0) for at in (COSINE, -2 - COSINE, 2 - COSINE))
    return kernel @ _angles(asymmetry)


def _gaussian(centre: float, width: float) -> Pmf:
    density = np.exp(-0.5 * ((COSINE - centre) / width) ** 2)
    return density / density.sum()


@dataclass(frozen=True)
class Shape:
    """An effect of the catalogue in one shape, as the distribution that it gives to events."""

    family: str
    pmf: Callable[..., Pmf]
    """The simulator's parameter, strength, other parameters -> (K,)"""
    bounds: tuple[tuple[float, float], ...]
    """Of the strength and the other parameters, all positive; the middle of the others, by ratio, is where it is."""

    @property
    def others(self) -> list[float]:
        return [float(np.sqrt(low * high)) for low, high in self.bounds[1:]]


FRACTION, VARIANCE = (1e-5, 0.95), (1e-6, 0.3)
COUNTED = {
    "gamma rates": Shape("overdispersion", lambda r, v: nbinom.pmf(COUNTS, 1 / v, 1 / (1 + r * v)), (VARIANCE,)),
    "uniform rates": Shape(
        "overdispersion",
        lambda r, v: np.mean([_poisson(r * (1 + np.sqrt(3 * v) * u)) for u in np.linspace(-0.99, 0.99, 100)], axis=0),
        (VARIANCE,),
    ),
    "pairs": Shape("double_counting", _after(lambda x, p: binom.pmf(x[:, None] - x, x, p)), (FRACTION,)),
    "after-pulses": Shape("double_counting", _after(lambda x, p: poisson.pmf(x[:, None] - x, x * p)), (FRACTION,)),
    "two events in one": Shape(
        "double_counting", lambda r, f: (1 - f) * _poisson(r) + f * _poisson(2 * r), (FRACTION,)
    ),
    "noise": Shape("readout_noise", _noise, ((0.1, 20),)),
    "dead channel": Shape("zero_inflation", lambda r, f: (1 - f) * _poisson(r) + f * (COUNTS == 0), (FRACTION,)),
    "weak channel": Shape(
        "zero_inflation", lambda r, f, w: (1 - f) * _poisson(r) + f * _poisson(w * r), (FRACTION, (0.001, 0.3))
    ),
    "second source": Shape(
        "mixture", lambda r, f, s: (1 - f) * _poisson(r) + f * _poisson(s * r), ((1e-5, 0.5), (0.2, 3))
    ),
    "few are lost": Shape("threshold_loss", _lost, ((1e-5, 1), (10, 60))),
    "dead time": Shape("dead_time", _dead, ((1e-6, 1 / RATE),)),
}
"""Effects on counts, by what happens."""


ANGLES = {
    "flat": Shape("flat_background", lambda a, f: (1 - f) * _angles(a) + f / BINS, (FRACTION,)),
    "loss at both ends": Shape("edge_acceptance", _kept(lambda f, q: 1 - f * np.abs(COSINE) ** q), (FRACTION, (2, 30))),
    "cut at one end": Shape("edge_acceptance", _kept(lambda f, e: 1 - f * (e < COSINE)), (FRACTION, (0.6, 0.95))),
    "one half is worse": Shape("forward_backward_acceptance", _kept(lambda f: 1 - f * (COSINE > 0)), (FRACTION,)),
    "worse along one half": Shape(
        "forward_backward_acceptance", _kept(lambda f, q: 1 - f * np.maximum(COSINE, 0) ** q), (FRACTION, (0.3, 3))
    ),
    "peak": Shape(
        "peak_background",
        lambda a, f, c, w: (1 - f) * _angles(a) + f * _gaussian(c - 1, w),
        (FRACTION, (0.1, 1.9), (0.02, 0.35)),
    ),
    "hole": Shape(
        "dead_region",
        _kept(lambda f, c, w: 1 - f * (np.abs(COSINE + 1 - c) < w / 2)),
        (FRACTION, (0.3, 1.7), (0.05, 0.5)),
    ),
    "smearing": Shape("resolution", _smeared, ((0.005, 0.7),)),
}
"""Effects on a cosine. Places are told from the lower end."""
SETTINGS = {
    "counts": (COUNTED, _poisson, RATE, (RATE / 3, 3 * RATE)),
    "cosine": (ANGLES, _angles, ASYMMETRY, (-0.99, 0.99)),
}
"""By kind of events: effects, the simulator as it is, its parameter and the bounds of that."""


def missed(truth: Pmf, pmf: Pmf) -> float:
    """By how much the expected log likelihood of NUM_EVENTS events of `truth` (K,) is less under `pmf` (K,)."""
    some = truth > 0
    return float(NUM_EVENTS * truth[some] @ (np.log(truth[some]) - np.log(np.maximum(pmf[some], 1e-300))))


def fitted(truth: Pmf, shape: Shape, bounds: tuple[float, float]) -> float:
    """The least that a shape misses a distribution (K,) by, whatever its parameters and the simulator's are."""
    low, high = np.log(shape.bounds).T
    begin, (lowest, highest) = (low + high) / 2, bounds
    found = [
        minimize(
            lambda z: missed(truth, shape.pmf(z[0], *np.exp(z[1:]))),
            np.r_[lowest + at * (highest - lowest), low[0] + share * (high[0] - low[0]), begin[1:]],
            method="Nelder-Mead",
            bounds=[bounds, *zip(low, high, strict=True)],
            options={"maxiter": 1000, "xatol": 1e-6, "fatol": 1e-4},
        ).fun
        for share in (0.3, 0.5, 0.7)
        for at in (0.25, 0.5, 0.75)
    ]
    return float(min(found))


def seen(shape: Shape, kind: str) -> Pmf:
    """The distribution (K,) that a shape gives at the strength at which the simulator alone misses it by SEEN."""
    _, simulator, at, bounds = SETTINGS[kind]

    def more(log_strength: float) -> float:
        pmf = shape.pmf(at, np.exp(log_strength), *shape.others)
        return minimize_scalar(lambda z: missed(pmf, simulator(z)), bounds=bounds, method="bounded").fun - SEEN

    strengths = np.linspace(*np.log(shape.bounds[0]), 40)
    enough = next(k for k, strength in enumerate(strengths) if more(strength) > 0)
    strength = brentq(more, strengths[enough - 1], strengths[enough], xtol=1e-4)
    return shape.pmf(at, np.exp(strength), *shape.others)


def table(kind: str) -> pd.DataFrame:
    """Of each shape, the shapes of two other families that leave least, and what they leave."""
    shapes, _, _, bounds = SETTINGS[kind]
    rows = []
    for name, shape in shapes.items():
        truth = seen(shape, kind)
        left: dict[str, tuple[float, str]] = {}
        for other, than in shapes.items():
            if than.family != shape.family:
                least = (fitted(truth, than, bounds), f"{other} ({than.family})")
                left[than.family] = min(least, left.get(than.family, least))
        (first, most_alike), (second, then) = sorted(left.values())[:2]
        rows.append(
            {kind: f"{name} ({shape.family})", "most alike": most_alike, "left": first, "then": then, "": second}
        )
    return pd.DataFrame(rows)


def main() -> None:
    """Print the tables."""
    print("\n\n".join(table(kind).to_string(index=False, float_format="{:.1f}".format) for kind in SETTINGS))


if __name__ == "__main__":
    main()
