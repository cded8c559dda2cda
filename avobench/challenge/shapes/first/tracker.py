"""The tracker around e+e- collisions: effects on Pythia's particles themselves, with exact geometry.

The particles start elsewhere, or the detector is turned, before they cross it. Written apart from the geometry of the
catalogue, which the tests compare with it.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Injection, Place, Simulate, drawn, strength
from avobench.tasks.alignment import Alignment, Particles


class ParticleInjection(Injection):
    """An injection that acts before the detector. It generates events itself, so nothing can act before it."""

    stage = 0

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.task.generates == "particles"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        task, images = self.place.task, []
        start = 0
        for particles in task.generate(len(theta), rng):
            stop = start + len(particles)
            images.append(self.detect(task, particles, theta[start:stop], rng))
            start = stop
        return np.concatenate(images)

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        """Images of `particles`: theta (n, 1) [mm] -> (n, d)."""
        raise NotImplementedError


@dataclass(frozen=True)
class MovedBeam(ParticleInjection):
    """The beams collide beside the axis of the detector."""

    name: ClassVar = "transverse_offset"
    source: ClassVar = "beam-spot displacement at colliders"
    strength: float = strength(0.01, 1, "mm")
    azimuth: float = drawn(0, 2 * np.pi, "rad")

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        shift = self.strength * np.array([[np.cos(self.azimuth)], [np.sin(self.azimuth)], [0]])
        return task.detect(replace(particles, position=particles.position + shift), theta)


@dataclass(frozen=True)
class TiltedDetector(ParticleInjection):
    """The axis of the detector makes an angle with the beam; it is turned about its centre."""

    name: ClassVar = "axial_tilt"
    source: ClassVar = "global rotations in tracker alignment"
    strength: float = strength(0.003, 0.3, "rad")
    azimuth: float = drawn(0, 2 * np.pi, "rad, of the axis of rotation")

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        position = particles.position.copy()
        position[2] += np.repeat(theta[:, 0], np.diff(particles.offsets))
        x, y = np.cos(self.azimuth), np.sin(self.azimuth)
        cross = np.array([[0, 0, y], [0, 0, -x], [-y, x, 0]])  # Rodrigues, axis (x, y, 0)
        turn = np.eye(3) + np.sin(self.strength) * cross + (1 - np.cos(self.strength)) * cross @ cross
        turned = replace(particles, position=turn @ position, momentum=turn @ particles.momentum)
        return task.detect(turned, np.zeros_like(theta))


@dataclass(frozen=True)
class SoftParticles(ParticleInjection):
    """Hits are lost where a particle's momentum is low: an erf turn-on in momentum."""

    name: ClassVar = "inefficiency"
    source: ClassVar = "efficiency of tracking detectors as a function of momentum"
    strength: float = strength(0.03, 1, "GeV")
    width: float = drawn(0.1, 0.4, "of the threshold")

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        momentum = np.sqrt((particles.momentum**2).sum(axis=0))
        kept = rng.random(len(momentum)) < ndtr((momentum / self.strength - 1) / self.width)
        before = np.concatenate([[0], np.cumsum(kept)])
        seen = Particles(
            before[particles.offsets],
            particles.position[:, kept],
            particles.momentum[:, kept],
            particles.energy[kept],
            particles.reach[kept],
        )
        return task.detect(seen, theta)
