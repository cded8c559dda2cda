"""A value that is not recorded in a share of the events, which then lack the feature."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.continuous.feature import FeatureEffect
from avobench.effects.contract import OF_FEATURE, Parameter

SIDES = {"low": np.less, "high": np.greater}
"""On which side of a value it is lost, by shape."""


@dataclass(frozen=True)
class LostValue(FeatureEffect):
    """Events lack a feature more often than simulated: anywhere, or where its value is on one side of another."""

    stage = 4
    name = "lost_value"
    sentence: ClassVar = (
        "The value of a feature is missing in more events: the detector did not fire, or nobody answered."
    )
    source: ClassVar = "D. B. Rubin, Biometrika 63 (1976) 581"
    STRENGTH: ClassVar = Parameter("lost", 0, 1, 0, "1")

    @classmethod
    def entries(cls, site):
        return [cls(j, site.ranges) for j in site.task.missing]

    def variants(self):
        at = (Parameter("at", self.low, self.high, None, OF_FEATURE),)
        return {"": (), **dict.fromkeys(SIDES, at)}

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        lost = rng.random(len(x)) < phi[:, 0]
        if self.shape:
            lost &= SIDES[self.shape](x[:, self.feature], phi[:, 1])
        x[lost, self.feature] = np.nan
        return x
