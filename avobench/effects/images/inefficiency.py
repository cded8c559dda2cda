"""Inefficiency: hits are missed, everywhere alike or, where particles are known, those of low momentum."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from avobench.effects.contract import Effect, Parameter
from avobench.effects.images.grid import ImageEffect
from avobench.effects.images.particles import PARTICLES, ParticleEffect


@dataclass(frozen=True)
class Inefficiency(ImageEffect):
    """Each hit is lost with a fixed probability."""

    stage = 4
    name = "inefficiency"
    position = 3
    sentence = "Every cell misses a share of its hits."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"
    parameters = (Parameter("lost", 0, 0.95, 0, "1"),)

    @classmethod
    def entries(cls, site):
        """Where the task generates particles, with the shape that knows their momenta."""
        family = TrackInefficiency if site.task.generates == PARTICLES else cls
        return [family(site.task.event_shape)]

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        event, cell = np.nonzero(x)
        gone = rng.random(len(event)) < phi[event, 0]
        x[event[gone], cell[gone]] = 0
        return x


@dataclass(frozen=True)
class SoftInefficiency(ParticleEffect):
    """A particle is lost if its momentum is below a threshold, which differs from particle to particle."""

    shape: str = "soft"
    name, sentence, source = Inefficiency.name, "Particles of low momentum are missed.", Inefficiency.source
    parameters = (Parameter("threshold", 0, 3, 0, "GeV", soft=True), Parameter("width", 0.05, 0.5, None, "of it"))

    def altered(self, particles, theta, phi, rng):
        momentum = np.sqrt((particles.momentum**2).sum(axis=0))
        threshold, width = phi.T
        excess = (momentum / np.where(threshold > 0, threshold, 1) - 1) / width
        return particles.only((rng.random(len(momentum)) < ndtr(excess)) | (threshold == 0))


@dataclass(frozen=True)
class TrackInefficiency(Inefficiency):
    """Hits are lost everywhere alike, or those of particles of low momentum."""

    def shapes(self) -> tuple[Effect, ...]:
        return (self, SoftInefficiency(self.grid))
