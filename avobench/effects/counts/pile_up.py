"""Pile-up: counts of neighbouring events fall into every event."""

from dataclasses import dataclass
from typing import ClassVar

from avobench.effects.contract import Parameter
from avobench.effects.counts.exposure import exposed
from avobench.effects.counts.feature import CountEffect


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
