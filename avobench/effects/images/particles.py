"""Effects on the particles that a generator sends into a tracker: images show only some of them."""

from dataclasses import dataclass, replace

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
        return super().entries(site) if site.task.generates == PARTICLES else []

    def altered(
        self, particles: Particles, theta: NDArray[np.float64], phi: NDArray[np.float64], rng: np.random.Generator
    ) -> Particles:
        """What reaches the detector, of m particles: theta (m,), where along the beam they start [mm], phi (m, q)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        def alter(particles, rows):
            event = np.repeat(np.arange(len(particles)), np.diff(particles.offsets))
            return self.altered(particles, theta[rows, 0][event], phi[rows][event], rng)

        return simulate(theta, rng, alter)


@dataclass(frozen=True)
class TransverseOffset(ParticleEffect):
    """The interaction point is `shift` radii of the tracker away from its axis, towards an azimuth."""

    radius: float = 1.0
    """Radius of the tracker [mm]."""
    name = "transverse_offset"
    position = 7
    sentence = "The collisions do not happen on the axis of the detector."
    source = "V. Blobel, Nucl. Instrum. Methods A 566 (2006) 5"
    parameters = (Parameter("shift", 0, 0.5, 0, "of the radius"), AZIMUTH)

    @classmethod
    def entries(cls, site):
        return [replace(effect, radius=site.task.radius) for effect in super().entries(site)]

    def altered(self, particles, theta, phi, rng):
        shift = self.radius * phi[:, 0] * np.array([np.cos(phi[:, 1]), np.sin(phi[:, 1]), np.zeros(len(phi))])
        return replace(particles, position=particles.position + shift)


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
            particles, position=turned(particles.position + start) - start, momentum=turned(particles.momentum)
        )
