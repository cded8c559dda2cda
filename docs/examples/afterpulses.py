"""Afterpulses: each count of a photomultiplier may be followed by false ones."""

import numpy as np

from avobench.effects import Effect, Parameter


class Afterpulses(Effect):
    """Each count makes a geometric number of false ones: one more with probability `chance`, again and again."""

    name = "afterpulses"
    parameters = (Parameter("chance", 0, 0.5, 0, "1"),)
    sentence = "Counts are followed by afterpulses, which are counted too."
    source = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 9.III"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        counted = np.flatnonzero(x[:, 0] > 0)
        x[counted, 0] += rng.negative_binomial(x[counted, 0], 1 - phi[counted, 0])
        return x
