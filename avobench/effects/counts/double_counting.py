"""Double counting: two events are taken for one, or what is counted is counted twice."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole


@dataclass(frozen=True)
class DoubleCounting(CountEffect):
    """Two events are taken for one (`merged`), an event is read twice (`repeated`), or single counts are (`pairs`)."""

    shape: str = "merged"

    name = "double_counting"
    position = 6
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {"merged": (), "repeated": (), "pairs": ()}
    sentence: ClassVar = "Some counts are counted twice, or two events are recorded as one."
    source: ClassVar = (
        "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 4.VII; "
        "pairs: C. D. Kemp, A. W. Kemp, Biometrika 52 (1965) 381"
    )

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.shape == "pairs":
            x[:, self.columns] += rng.binomial(whole(x[:, self.columns]), phi[:, :1])
            return x
        twice = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(twice):
            again = x[twice] if self.shape == "repeated" else simulate(theta[twice], rng)
            x[self.cells(twice)] += again[:, self.columns]
        return x
