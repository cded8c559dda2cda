"""Other failures of the tracker, its readout and its trigger, and other ways for the beams to miss its axis."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.special import expit

from avobench.challenge.shapes.contract import Selection, Simulate, drawn, strength
from avobench.challenge.shapes.first.images import ImageInjection, PileUp, hit_size, lose, overlay, walk
from avobench.challenge.shapes.first.tracker import ParticleInjection
from avobench.tasks.alignment import Alignment, Particles


@dataclass(frozen=True)
class SilentLink(ImageInjection):
    """A readout link drops out in some events; its cells, whole neighbouring columns, then say nothing."""

    name: ClassVar = "dead_cells"
    source: ClassVar = "double columns and readout links of pixel detectors"
    strength: float = strength(0.02, 1, "share of the events")
    columns: float = drawn(1, 4, "rounded down")
    seed: float = drawn(0, 2**31, "where")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        num_columns = self.place.task.event_shape[-1]
        first = np.random.default_rng(int(self.seed)).integers(num_columns)
        columns = (first + np.arange(int(self.columns))) % num_columns
        x.reshape(len(x), -1, num_columns)[..., columns] *= (rng.random(len(x)) >= self.strength)[:, None, None]
        return x


@dataclass(frozen=True)
class NoisyChip(ImageInjection):
    """Neighbouring cells of one chip fire on their own, many of them in the same events."""

    name: ClassVar = "noisy_cells"
    source: ClassVar = "common-mode noise of readout chips"
    strength: float = strength(0.003, 0.3, "share of the events")
    cells: float = drawn(3, 15, "rounded down")
    together: float = drawn(0.3, 0.9, "share of these cells that fires")
    seed: float = drawn(0, 2**31, "where")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        cells = walk(self.place, int(self.cells), int(self.seed))
        fired = (rng.random((len(x), 1)) < self.strength) & (rng.random((len(x), len(cells))) < self.together)
        x[:, cells] = overlay(self.place, x[:, cells], fired * hit_size(self.place))
        return x


@dataclass(frozen=True)
class BadTiming(ImageInjection):
    """Hits are lost that come too late for the readout: nearly none in most events, many in a few."""

    name: ClassVar = "inefficiency"
    source: ClassVar = "jitter of the readout window, with the efficiency shared by all hits of an event"
    strength: float = strength(0.003, 0.3)
    evenness: float = drawn(1, 10, "a + b of the beta distribution")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        loss = rng.beta(self.evenness * self.strength, self.evenness * (1 - self.strength), len(x))
        return lose(x, loss[:, None], rng)


@dataclass(frozen=True)
class GradedNoise(ImageInjection):
    """False hits at random places, more of them towards one end of the detector."""

    name: ClassVar = "random_noise"
    source: ClassVar = "leakage current, which grows with temperature and radiation along a detector"
    strength: float = strength(0.02, 3, "hits an event")
    gradient: float = drawn(0.1, 0.7, "from the middle to the end", sign=True)

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        rows = self.place.task.event_shape[0]
        share = np.repeat(1 + self.gradient * np.linspace(-1, 1, rows), x.shape[1] // rows) / x.shape[1]
        event = np.repeat(np.arange(len(x)), rng.poisson(self.strength, len(x)))
        noise = np.zeros_like(x)
        noise[event, rng.choice(x.shape[1], len(event), p=share)] = hit_size(self.place)
        return overlay(self.place, x, noise)


@dataclass(frozen=True)
class OutOfTime(PileUp):
    """Collisions of other bunches leave a part of their hits in the same image."""

    source: ClassVar = "out-of-time pile-up at colliders"
    strength: float = strength(0.005, 0.5, "collisions an event")
    in_time: float = drawn(0.3, 0.9, "share of their hits that is seen")
    bunch: float = drawn(0.02, 0.1, "of the support's width, the bunch's length")

    def others(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        support = self.place.task.support
        elsewhere = theta + self.bunch * support.width * rng.standard_normal(theta.shape)
        return lose(simulate(np.clip(elsewhere, support.low, support.high), rng), 1 - self.in_time, rng)


@dataclass(frozen=True)
class WanderingBeam(ParticleInjection):
    """The beams collide beside the axis of the detector, at a place that wanders from event to event."""

    name: ClassVar = "transverse_offset"
    source: ClassVar = "beam spots of finite size that move between fills"
    strength: float = strength(0.01, 1, "mm")
    azimuth: float = drawn(0, 2 * np.pi, "rad")
    wander: float = drawn(0.1, 0.5, "of the displacement")

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        spot = [np.cos(self.azimuth), np.sin(self.azimuth)] + self.wander * rng.standard_normal((len(theta), 2))
        position = particles.position.copy()
        position[:2] += self.strength * np.repeat(spot, np.diff(particles.offsets), axis=0).T
        return task.detect(replace(particles, position=position), theta)


@dataclass(frozen=True)
class TiltedBeams(ParticleInjection):
    """The beams meet where they should, but at an angle to the axis of the detector, by more or less."""

    name: ClassVar = "axial_tilt"
    source: ClassVar = "beam angles at the interaction point and their divergence"
    strength: float = strength(0.02, 0.5, "rad")
    azimuth: float = drawn(0, 2 * np.pi, "rad, of the axis of rotation")
    divergence: float = drawn(0, 0.5, "of the angle")

    def detect(
        self, task: Alignment, particles: Particles, theta: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray:
        angle = self.strength * (1 + self.divergence * rng.standard_normal(len(theta)))
        axis = np.array([np.cos(self.azimuth), np.sin(self.azimuth), 0])
        turn = Rotation.from_rotvec(np.repeat(angle, np.diff(particles.offsets))[:, None] * axis)
        position, momentum = (turn.apply(vector.T).T for vector in (particles.position, particles.momentum))
        return task.detect(replace(particles, position=position, momentum=momentum), theta)


@dataclass(frozen=True)
class CentralTrigger(Selection):
    """The trigger looks at the middle of the detector only, and may miss an event that has few hits there."""

    name: ClassVar = "threshold"
    source: ClassVar = "barrel triggers, with a logistic turn-on"
    strength: float = strength(0.01, 0.4, "share of the events below the threshold")
    width: float = drawn(0.05, 0.3, "standard deviations")
    middle: float = drawn(0.3, 0.8, "of the rows")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        hits = self._hits(self.place.reference)
        return expit((self._hits(x) + 0.5 - np.quantile(hits, self.strength)) / (self.width * hits.std()))

    def _hits(self, x: NDArray) -> NDArray[np.int64]:
        rows = self.place.task.event_shape[0]
        cut = round((1 - self.middle) / 2 * rows)
        return np.count_nonzero(x.reshape(len(x), rows, -1)[:, cut : rows - cut], axis=(1, 2))
