"""Effects on the particles that a generator sends into the tracker, of which images show only some."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.effects.contract import Effect, Parameter
from avobench.effects.images.cells import Inefficiency
from avobench.effects.images.grid import ImageEffect
from avobench.tasks.alignment import Particles

SOURCE = "V. Blobel, Nucl. Instrum. Methods A 566 (2006) 5"
AZIMUTH = Parameter("azimuth", -np.pi, np.pi, None, "rad")


@dataclass(frozen=True)
class ParticleEffect(ImageEffect):
    """An effect on generated particles. Its simulator is one of a two-stage task, which lets them be altered."""

    stage = 0

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


@dataclass(frozen=True)
class TransverseOffset(ParticleEffect):
    """The interaction point is `shift` radii of the tracker away from its axis, towards an azimuth."""

    radius: float = 1.0
    """Of the tracker [mm]."""
    name = "transverse_offset"
    sentence = "The collisions do not happen on the axis of the detector."
    source = SOURCE
    parameters = (Parameter("shift", 0, 0.5, 0, "of the radius"), AZIMUTH)

    def altered(self, particles, theta, phi, rng):
        shift = self.radius * phi[:, 0] * np.array([np.cos(phi[:, 1]), np.sin(phi[:, 1]), np.zeros(len(phi))])
        return replace(particles, position=particles.position + shift)


@dataclass(frozen=True)
class AxialTilt(ParticleEffect):
    """The axis of the detector, turned about its centre, is tilted against the beam by an angle, towards an azimuth."""

    name = "axial_tilt"
    sentence = "The axis of the detector is tilted against the beam."
    source = SOURCE
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
