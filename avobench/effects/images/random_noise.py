"""Random noise: cells fire at random."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect


@dataclass(frozen=True)
class RandomNoise(ImageEffect):
    """Cells fire at random, `rate` of them in each event."""

    stage = 4
    name = "random_noise"
    position = 4
    sentence = "Cells fire at random, as from thermal noise."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 14.4"

    @property
    def parameters(self):
        return (Parameter("rate", 0, 0.1 * self.num_cells, 0, "cells an event"),)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event = np.repeat(np.arange(len(x)), rng.poisson(phi[:, 0]))
        cell = rng.integers(self.num_cells, size=len(event))
        x[event, cell] = np.maximum(x[event, cell], 1)
        return x
