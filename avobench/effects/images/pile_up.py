"""Pile-up: some images show two events at once."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect


@dataclass(frozen=True)
class PileUp(ImageEffect):
    """To a share of the events another one is added."""

    stage = 1
    name = "pile_up"
    position = 5
    sentence = "Some images show two events at once."
    source = "R. L. Workman et al. (Particle Data Group), Prog. Theor. Exp. Phys. 2022, 083C01, Section 34"
    parameters = (Parameter("fraction", 0, 1, 0, "1"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        if len(rows):
            other = simulate(theta[rows], rng)
            x[rows] = np.maximum(x[rows], other) if x.dtype.kind in "iu" else x[rows] + other
        return x
