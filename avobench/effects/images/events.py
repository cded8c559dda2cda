"""Effects on whole images: two events in one, or too few hits to be recorded."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect
from avobench.effects.rejection import accepted


@dataclass(frozen=True)
class PileUp(ImageEffect):
    """Another event is added to a share of the events."""

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


@dataclass(frozen=True)
class Threshold(ImageEffect):
    """Events of few hits are not recorded: n of them with probability 1 - exp(-(n / threshold)^4)."""

    stage = 3
    name = "threshold"
    position = 6
    sentence = "Events with few hits do not start the readout."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 17.1"

    @property
    def parameters(self):
        return (Parameter("threshold", 0, 0.04 * self.num_cells, 0, "hits"),)

    def apply(self, simulate, theta, phi, rng):
        def keep(x, rows):
            t = phi[rows, 0]
            return np.where(t > 0, -np.expm1(-(((x > 0).sum(axis=1) / np.where(t > 0, t, 1)) ** 4)), 1)

        return accepted(simulate, theta, keep, rng)
