"""An effect on counts that keeps the contract, and others that each break it in one way."""

import numpy as np

from avobench.effects import Effect, Parameter


class Sound(Effect):
    """Noise is added."""

    name = "noise"
    parameters = (Parameter("rate", 0, 2, 0, "counts"),)
    sentence = "Counts of another origin are added."
    source = "test"

    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + rng.poisson(phi)


class Silent(Sound):
    sentence = ""


class NoStage(Sound):
    stage = 7


class NoNull(Sound):
    parameters = (Parameter("rate", 0, 2, None, "counts"),)


class NeverAbsent(Sound):
    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + rng.poisson(phi + 2)


class OfTheSecondRow(Sound):
    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + rng.poisson(phi[1, 0], (len(theta), 1))


class OtherType(Sound):
    def apply(self, simulate, theta, phi, rng):
        return (simulate(theta, rng) + rng.poisson(phi)).astype(np.float32)


class OwnGenerator(Sound):
    def apply(self, simulate, theta, phi, rng):
        return simulate(theta, rng) + np.random.default_rng().poisson(phi)


class Unsendable(Sound):
    def __init__(self):
        self.noise = lambda phi, rng: rng.poisson(phi)
