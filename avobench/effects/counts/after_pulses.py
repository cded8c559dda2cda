"""Afterpulses: counts that trigger false ones."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole


@dataclass(frozen=True)
class AfterPulses(CountEffect):
    """Each count triggers further ones, `triggered` of them in the mean of one generation.

    In the shape `chain` it is followed by one with that chance, which may be followed by another: a geometric number.
    In the shape `one_generation` it triggers a Poisson number of them, which trigger none. One at most is
    the shape `pairs`, from which they are hardly told: so all are one family.
    """

    shape: str = "chain"

    name = "double_counting"
    position = 32
    STRENGTH = Parameter("triggered", 0, 0.7, 0, "1")
    SHAPES: ClassVar = {"chain": (), "one_generation": ()}
    sentence: ClassVar = "Counts trigger false ones, as the afterpulses and the crosstalk of a photomultiplier do."
    source: ClassVar = "S. Vinogradov, Nucl. Instrum. Methods A 695 (2012) 247"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        n = whole(x[:, self.columns])
        if self.shape == "one_generation":
            x[:, self.columns] += rng.poisson(n * phi[:, :1])
        else:  # of no count there is no chain, and NumPy draws of none
            x[:, self.columns] += np.where(n > 0, rng.negative_binomial(np.maximum(n, 1), 1 - phi[:, :1]), 0)
        return x
