"""Pile-up: counts of neighbouring events fall into every event."""

from dataclasses import dataclass
from typing import ClassVar

from avobench.effects.contract import Parameter
from avobench.effects.counts.exposure import exposed
from avobench.effects.counts.feature import CountEffect


@dataclass(frozen=True)
class PileUp(CountEffect):
    """A part of another event's counts falls into the window of each event."""

    stage = 1
    name = "pile_up"
    position = 9
    STRENGTH = Parameter("overlap", 0, 1, 0, "1")
    SHAPES: ClassVar = {"": ()}
    sentence: ClassVar = "Counts that belong to neighbouring events fall into every event."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.VII"

    def apply(self, simulate, theta, phi, rng):
        return exposed(simulate, theta, 1 + phi[:, 0], rng, self.columns)
