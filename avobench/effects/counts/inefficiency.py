"""Inefficiency: every count has the same chance to be missed."""

from dataclasses import dataclass
from typing import ClassVar

from avobench.effects.contract import Parameter
from avobench.effects.counts.exposure import exposed
from avobench.effects.counts.feature import CountEffect


@dataclass(frozen=True)
class Inefficiency(CountEffect):
    """Each count is missed with a fixed probability."""

    name = "inefficiency"
    position = 10
    STRENGTH = Parameter("lost", 0, 0.98, 0, "1")
    SHAPES: ClassVar = {"": ()}
    sentence: ClassVar = "Every count has the same chance to be missed."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.V"

    def apply(self, simulate, theta, phi, rng):
        return exposed(simulate, theta, 1 - phi[:, 0], rng, self.columns)
