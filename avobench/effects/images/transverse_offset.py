"""A transverse offset: the collisions do not happen on the axis of the tracker."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.particles import AZIMUTH, ParticleEffect


@dataclass(frozen=True)
class TransverseOffset(ParticleEffect):
    """The interaction point is `shift` radii of the tracker away from its axis, towards an azimuth."""

    radius: float = 1.0
    """Of the tracker [mm]."""
    name = "transverse_offset"
    position = 7
    sentence = "The collisions do not happen on the axis of the detector."
    source = "V. Blobel, Nucl. Instrum. Methods A 566 (2006) 5"
    parameters = (Parameter("shift", 0, 0.5, 0, "of the radius"), AZIMUTH)

    @classmethod
    def entries(cls, site):
        """As of any effect on particles, with the radius of the task's tracker."""
        return [replace(effect, radius=site.task.radius) for effect in super().entries(site)]

    def altered(self, particles, theta, phi, rng):
        shift = self.radius * phi[:, 0] * np.array([np.cos(phi[:, 1]), np.sin(phi[:, 1]), np.zeros(len(phi))])
        return replace(particles, position=particles.position + shift)
