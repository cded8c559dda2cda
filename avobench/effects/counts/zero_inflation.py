"""Zero inflation: some events read nothing, whatever happened."""

from dataclasses import dataclass
from typing import ClassVar

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole


@dataclass(frozen=True)
class ZeroInflation(CountEffect):
    """A share of the events reads nothing, or, in the shape `weak`, a fraction of its counts."""

    shape: str = "dead"

    name = "zero_inflation"
    position = 1
    STRENGTH = Parameter("fraction", 0, 0.98, 0, "1")
    SHAPES: ClassVar = {"dead": (), "weak": (Parameter("left", 0.001, 0.3, None, "1"),)}
    sentence: ClassVar = "Some events read zero whatever happened, as from a channel that is sometimes off."
    source: ClassVar = "D. Lambert, Technometrics 34 (1992) 1"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        off = rng.random(len(x)) < phi[:, 0]
        cells = self.cells(off)
        x[cells] = rng.binomial(whole(x[cells]), phi[off, 1:]) if self.shape == "weak" else 0
        return x
