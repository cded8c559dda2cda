"""An axial tilt: the axis of the tracker is tilted against the beam."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.contract import Parameter
from avobench.effects.images.particles import AZIMUTH, ParticleEffect


@dataclass(frozen=True)
class AxialTilt(ParticleEffect):
    """The axis of the detector, turned about its centre, is tilted against the beam by an angle, towards an azimuth."""

    name = "axial_tilt"
    position = 8
    sentence = "The axis of the detector is tilted against the beam."
    source = "V. Blobel, Nucl. Instrum. Methods A 566 (2006) 5"
    parameters = (Parameter("tilt", 0, 0.5, 0, "rad"), AZIMUTH)

    def altered(self, particles, theta, phi, rng):
        towards = np.array([np.cos(phi[:, 1]), np.sin(phi[:, 1])])
        sine, cosine = np.sin(phi[:, 0]), np.cos(phi[:, 0])

        def turned(r):
            along = (r[:2] * towards).sum(axis=0)
            outward = along * cosine + r[2] * sine - along
            return np.concatenate([r[:2] + towards * outward, (r[2] * cosine - along * sine)[None]])

        start = np.zeros_like(particles.position)
        start[2] = theta  # the detector adds it along its own axis
        return replace(
            particles,
            position=turned(particles.position + start) - start,
            momentum=turned(particles.momentum),
        )
