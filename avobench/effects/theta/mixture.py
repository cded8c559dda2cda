"""Mixture: some events come from a second population, which the same simulator describes at another theta."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Effect, Parameter

MOST = 3
"""Parameters in which the second population may differ at once: a grid over more of them would be too coarse."""
BEYOND = 0.5
"""Of the prior's width, how far outside of it the second population may lie: it need not be what was expected."""


@dataclass(frozen=True)
class Mixture(Effect):
    """A share of the events is simulated at another theta.

    It differs in all parameters of the task, or, where there are more than MOST, in the one that `feature` names.
    Beyond a half the two populations only swap their names.
    """

    feature: str | None = None
    columns: tuple[int, ...] = ()
    """Of the parameters in theta."""
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
        """One, or one a parameter where there are more than MOST."""
        task = site.task
        low = np.maximum(task.prior.low - BEYOND * task.prior.width, task.support.low)
        high = np.minimum(task.prior.high + BEYOND * task.prior.width, task.support.high)
        others = tuple(
            Parameter(f"other_{name}", float(a), float(b), None, unit)
            for name, a, b, unit in zip(task.parameter_names, low, high, task.parameter_units, strict=True)
        )
        if len(others) <= MOST:
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
            other[:, self.columns] = phi[rows, 1:]
            x[rows] = simulate(other, rng)
        return x
