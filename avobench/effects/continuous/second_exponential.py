"""A second exponential: some events decay with another lifetime, or are background that falls off."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Background
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class SecondExponential(Background):
    """A share of the events falls off exponentially from the lower end of the range, or from the upper."""

    shape: str = "falling"
    stage = 1
    on_all = False
    of_positive = True
    name = "second_exponential"
    position = 25
    sentence = "Some events decay with a lifetime of their own."
    source = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Chapter 1"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.95, 0, "1")

    def variants(self):
        length = Parameter("length", 0.02 * self.half, 3 * self.half, None, "of the feature")
        return {shape: (length,) for shape in ("falling", "rising")}

    def drawn(self, span, phi, rng):
        most = -np.expm1(-2 * span.half / phi[:, 1]) if span.bounded else 1
        from_end = -phi[:, 1] * np.log1p(-most * rng.random(len(phi)))
        return span.low + from_end if self.shape == "falling" else span.high - from_end
