"""Effects that act through the parameters of a simulator, whatever its events are."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtr, ndtri

from avobench.effects.contract import Effect, Family, Parameter

WIDEST = 0.3
"""Largest spread in the prior's width: about the standard deviation of values that spread over all of it."""
LEAST = 1e-9
"""Spread at the null value in the support's width, which no event shows."""


def _gaussian(at, width, low, high, rng):
    """What falls outside the support is drawn again: here by the inverse of the distribution function, at once."""
    below, above = ndtr((low - at) / width), ndtr((high - at) / width)
    return at + width * ndtri(below + (above - below) * rng.random(len(at)))


def _uniform(at, width, low, high, rng):
    """What falls outside the support is drawn again."""
    low, high = np.maximum(at - np.sqrt(3) * width, low), np.minimum(at + np.sqrt(3) * width, high)
    return low + (high - low) * rng.random(len(at))


def _two_values(at, width, low, high, rng):
    """One in each half of the events; a value outside the support is its end."""
    return at + np.where(rng.random(len(at)) < 0.5, -width, width)


DRAWN = {"gaussian": _gaussian, "uniform": _uniform, "two_values": _two_values}
"""Random values (n,) of a parameter around `at` (n,), by shape. Their standard deviation is `width` (n,) where the
support from `low` to `high` does not cut them off."""


@dataclass(frozen=True)
class Spread(Family):
    """A parameter of the task, named by `feature`, has another value in each event, around that of theta.

    Where an event is one count and theta one parameter, it is `overdispersion` and left to that.
    """

    shape: str = "gaussian"
    feature: str = ""
    column: int = 0
    """Column of the parameter in theta."""
    support: tuple[float, float] = (0.0, 1.0)
    widest: float = WIDEST
    parameter_unit: str = "1"

    stage = 1
    name = "spread"
    domains = ("counts", "continuous", "images")
    moves_theta = True
    odds = 0.25
    position = 30
    SHAPES: ClassVar = {shape: () for shape in DRAWN}
    sentence: ClassVar = (
        "A parameter of the simulator is not the same in every event; of a rate, this is overdispersion."
    )
    source: ClassVar = "N. M. Laird, J. H. Ware, Biometrics 38 (1982) 963"

    @classmethod
    def entries(cls, site):
        task = site.task
        if site.counts == [None] and len(task.parameter_names) == 1:
            return []
        supports = zip(task.support.low, task.support.high, strict=True)
        described = zip(task.parameter_names, supports, WIDEST * task.prior.width, task.parameter_units, strict=True)
        return [
            cls(feature=name, column=j, support=support, widest=float(widest), parameter_unit=unit)
            for j, (name, support, widest, unit) in enumerate(described)
        ]

    def strength(self) -> Parameter:
        return Parameter("width", 0, self.widest, 0, self.parameter_unit, soft=True)

    def apply(self, simulate, theta, phi, rng):
        low, high = self.support
        theta, width = theta.copy(), np.maximum(phi[:, 0], LEAST * (high - low))
        drawn = DRAWN[self.shape](theta[:, self.column], width, low, high, rng)
        theta[:, self.column] = np.clip(drawn, low, high)
        return simulate(theta, rng)


MOST = 6
"""Parameters in which the second population may differ at once: of more, a fit takes too many events."""
BEYOND = 0.5
"""How far outside the prior the second population may lie, in its widths: it need not be what was expected."""


@dataclass(frozen=True)
class Mixture(Effect):
    """A share of the events is simulated at another theta.

    It differs in all parameters of the task, or, where there are more than MOST, in the one that `feature` names.
    Beyond a half the two populations only swap their names.
    """

    feature: str | None = None
    second: tuple[int, ...] = ()
    others: tuple[Parameter, ...] = ()
    """What they are in the second population."""

    stage = 1
    name = "mixture"
    domains = ("counts", "continuous", "images")
    odds = 0.25
    position = 31
    sentence: ClassVar = "Some events come from a second population: the same simulator at other parameters."
    source: ClassVar = "K. Pearson, Phil. Trans. R. Soc. A 185 (1894) 71"

    @classmethod
    def entries(cls, site):
        task = site.task
        low = np.maximum(task.prior.low - BEYOND * task.prior.width, task.support.low)
        high = np.minimum(task.prior.high + BEYOND * task.prior.width, task.support.high)
        others = tuple(
            Parameter(f"other_{name}", float(a), float(b), None, unit)
            for name, a, b, unit in zip(task.parameter_names, low, high, task.parameter_units, strict=True)
        )
        if 0 < len(others) <= MOST:
            return [cls(None, tuple(range(len(others))), others)]
        return [cls(task.parameter_names[j], (j,), (other,)) for j, other in enumerate(others)]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("share", 0, 0.5, 0, "1"), *self.others)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(rows):
            other = theta[rows]
            other[:, self.second] = phi[rows, 1:]
            x[rows] = simulate(other, rng)
        return x
