"""What effects on the particles that a generator sends into a tracker share: images show only some of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.images.grid import ImageEffect
from avobench.tasks.alignment import Particles

PARTICLES = "particles"
"""What a task must say that it `generates`."""
AZIMUTH = Parameter("azimuth", -np.pi, np.pi, None, "rad")


@dataclass(frozen=True)
class ParticleEffect(ImageEffect):
    """An effect on particles, whose simulator is that of a task that `generates` them and lets them be altered."""

    stage = 0

    @classmethod
    def entries(cls, site):
        """None where a task makes its images in one step."""
        return super().entries(site) if site.task.generates == PARTICLES else []

    def altered(
        self,
        particles: Particles,
        theta: NDArray[np.float64],
        phi: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Particles:
        """What reaches the detector, of m particles: theta (m,), where along the beam they start [mm], phi (m, q)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        def alter(particles, rows):
            event = np.repeat(np.arange(len(particles)), np.diff(particles.offsets))
            return self.altered(particles, theta[rows, 0][event], phi[rows][event], rng)

        return simulate(theta, rng, alter)
