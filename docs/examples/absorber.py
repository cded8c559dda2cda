"""An absorber: material in front of the tracker, which the simulation lacks, stops some of the particles."""

from dataclasses import replace

import numpy as np

from avobench.effects import Effect, Parameter


class Absorber(Effect):
    """Each particle that a generator makes ends before it reaches the detector, with a fixed probability."""

    name = "absorber"
    stage = 0
    parameters = (Parameter("stopped", 0, 0.9, 0, "1"),)
    sentence = "Material in front of the tracker stops some of the particles."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 2"

    def apply(self, simulate, theta, phi, rng):
        def alter(particles, rows):
            event = np.repeat(np.arange(len(particles)), np.diff(particles.offsets))
            stopped = rng.random(len(event)) < phi[rows, 0][event]
            return replace(particles, reach=np.where(stopped, 0.0, particles.reach))

        return simulate(theta, rng, alter)
