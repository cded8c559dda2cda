"""A flat background: some events have nothing to do with the source."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect


@dataclass(frozen=True)
class FlatBackground(CountEffect):
    """A share of the events has nothing to do with the source: counts are uniform, or exponential, up to `reach`.

    In the shape `added` such counts come on top of those of the source. In `swept` their rate swings up and down.
    """

    shape: str = "uniform"

    stage = 4
    name = "flat_background"
    position = 5
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {
        "uniform": (Parameter("reach", 2, 400, None, "counts"),),
        "exponential": (Parameter("reach", 1, 200, None, "counts"),),
        "added": (Parameter("reach", 1, 200, None, "counts"),),
        "swept": (Parameter("reach", 2, 400, None, "counts"),),
    }
    sentence: ClassVar = "Some events are background whose counts spread over the whole range."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 20.II"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        reach, u = phi[rows, 1:], rng.random((len(rows), len(self.columns)))
        if self.shape == "swept":
            drawn = rng.poisson(reach * np.sin(np.pi / 2 * u) ** 2)
        else:
            drawn = u * (reach + 1) if self.shape == "uniform" else -reach * np.log1p(-u)
        x[self.cells(rows)] = np.floor(drawn) + (x[self.cells(rows)] if self.shape == "added" else 0)
        return x
