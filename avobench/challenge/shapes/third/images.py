"""Effects hidden in images of hits."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Change, Injection, Place, Selection, Simulate, drawn, strength

if TYPE_CHECKING:
    from avobench.tasks.alignment import Particles

Grid = NDArray[np.float64]


def run_time(n: int) -> NDArray[np.float64]:
    """When each of n events was taken, as a share of the run: (n,)."""
    return (np.arange(n) + 0.5) / max(n, 1)


def turned(vector: Grid, axis: Grid, angle: Grid) -> Grid:
    """Vectors (3, m) turned about one axis (3,), each by an angle of its own (m,): Rodrigues' formula."""
    along = axis[:, None] * (axis @ vector)
    across = np.cross(axis, vector, axisb=0, axisc=0)
    return along + (vector - along) * np.cos(angle) + across * np.sin(angle)


class Imaging(Injection):
    """What all shapes of images share."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return place.feature is None and len(place.task.event_shape) == 2 and place.binary

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of an image."""
        return self.place.task.event_shape

    @property
    def row(self) -> Grid:
        """Of each cell, in [-1, 1]: (d,)."""
        rows, columns = self.shape
        return np.repeat((np.arange(rows) + 0.5) / rows * 2 - 1, columns)

    @property
    def azimuth(self) -> Grid:
        """Of each cell [rad]: (d,)."""
        rows, columns = self.shape
        return np.tile((np.arange(columns) + 0.5) / columns * 2 * np.pi, rows)

    def distance(self, row: float, azimuth: float) -> Grid:
        """Of each cell from a point, row in [-1, 1] and azimuth in turns, in cells: (d,)."""
        rows, columns = self.shape
        around = np.angle(np.exp(1j * (self.azimuth - 2 * np.pi * azimuth))) * columns / (2 * np.pi)
        return np.hypot((self.row - row) * rows / 2, around)

    def scattered(self, count: float, seed: float) -> NDArray[np.int64]:
        """Cells here and there, most of them where hits are frequent, and the same for the same seed."""
        often = self.place.reference.mean(axis=0, dtype=float) + 1e-3
        order = np.random.default_rng(int(seed))
        count = min(max(round(count), 1), len(often))
        return order.choice(len(often), count, replace=False, p=often / often.sum())


class HitChange(Imaging, Change):
    """A change of the hits, of which some go and some come."""

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray | None:
        """Probability that a hit is lost, if any is, broadcast to (n, d)."""
        return None

    def made(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray | None:
        """Probability that an empty cell becomes a hit, if any does, broadcast to (n, d)."""
        return None

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        return self._changed(x > 0, rng).astype(x.dtype)

    def change(self, x: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        return self._changed(x > 0, rng).astype(float)

    def _changed(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        changed, lost, made = hits.copy(), self.lost(hits, rng), self.made(hits, rng)
        if lost is not None:
            event, cell = np.nonzero(hits)
            changed[event, cell] = rng.random(len(event)) >= np.broadcast_to(lost, hits.shape)[event, cell]
        if made is not None:
            changed |= rng.random(hits.shape, dtype=np.float32) < made
        return changed


class ImageSelection(Imaging, Selection):
    """A loss of events that depends on their hits."""


class ParticleChange(Imaging):
    """A change of the particles before they reach the detector."""

    stage = 0

    @classmethod
    def suits(cls, place: Place) -> bool:
        return super().suits(place) and place.task.generates == "particles"

    def altered(self, particles: "Particles", theta: Grid, time: Grid) -> "Particles":
        """Of events at theta (n, 1) and times (n,) of the run."""
        raise NotImplementedError

    def alter(self, theta: NDArray[np.float64]) -> Callable[["Particles", slice], "Particles"]:
        """What the simulator asks for."""
        time = run_time(len(theta))
        return lambda particles, rows: self.altered(particles, theta[rows], time[rows])

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.place.task.simulate(theta, rng, self.alter(theta))


@dataclass(frozen=True)
class ScratchedSensor(HitChange):
    """A scratch runs obliquely over the sensor; the cells on it are mostly dead, and more so in its middle."""

    strength: float = strength(0.5, 12, "cells")
    at_row: float = drawn(-0.45, 0.45)
    at_column: float = drawn(0, 1)
    slope: float = drawn(-1.2, 1.2)

    name = "dead_cells"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 5"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        rows, columns = self.shape
        step = np.linspace(-0.5, 0.5, 200) * self.strength
        across, along = step / np.hypot(1, self.slope), step * self.slope / np.hypot(1, self.slope)
        i = np.clip((self.at_row + 1) / 2 * rows + along, 0, rows - 1).astype(int)
        j = np.floor(self.at_column * columns + across).astype(int) % columns
        dead = np.zeros(rows * columns)
        np.maximum.at(dead, i * columns + j, 1 - 0.6 * np.abs(step) / max(self.strength / 2, 0.5))
        return dead


@dataclass(frozen=True)
class CrackedBonds(HitChange):
    """Bonds of some cells are cracked: in the cold they lose contact, so that they are dead for part of the run."""

    strength: float = strength(1, 30, "cells")
    cold: float = drawn(0.3, 0.9, "of the run")
    seed: float = drawn(0, 1e6)

    name = "dead_cells"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 4: bump bonding"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        broken = np.zeros(hits.shape[1])
        broken[self.scattered(self.strength, self.seed)] = 1
        return (run_time(len(hits)) < self.cold)[:, None] * broken


@dataclass(frozen=True)
class Delamination(HitChange):
    """The sensor has come loose from its chips at one corner of a module: a round patch is dead, and fades outwards."""

    strength: float = strength(0.3, 3, "cells")
    at_row: float = drawn(-0.5, 0.5)
    at_column: float = drawn(0, 1)

    name = "dead_cells"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 4: bump bonding"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        return 1 / (1 + np.exp(np.clip((self.distance(self.at_row, self.at_column) - self.strength) / 0.35, -50, 50)))


@dataclass(frozen=True)
class BlinkingCells(HitChange):
    """Some cells blink: they fire in a part of the run, in spells, each at a rate of its own."""

    strength: float = strength(0.0005, 0.012)
    cells: float = drawn(3, 20, "cells")
    duty: float = drawn(0.2, 0.7)
    seed: float = drawn(0, 1e6)

    name = "noisy_cells"
    stage = 4
    source = "Kogan, Electronic Noise and Fluctuations in Solids (1996): random telegraph noise"

    def made(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        cells = np.random.default_rng(int(self.seed)).choice(hits.shape[1], int(self.cells), replace=False)
        rate = np.minimum(self.strength * np.linspace(0.5, 1.5, len(cells)) / self.duty, 1)
        spells = np.repeat(rng.random((len(hits) // 50 + 1, len(cells))) < self.duty, 50, axis=0)[: len(hits)]
        chance = np.zeros(hits.shape, np.float32)
        chance[:, cells] = rate * spells
        return chance


@dataclass(frozen=True)
class HotCluster(HitChange):
    """A cell breaks down and heats its neighbours: all fire without a particle, the less the further from it."""

    strength: float = strength(0.0006, 0.008)
    at_row: float = drawn(-0.95, 0.95)
    at_column: float = drawn(0, 1)
    reach: float = drawn(0.5, 2, "cells")

    name = "noisy_cells"
    stage = 4
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 2: breakdown and hot pixels"

    def made(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        return self.strength * np.exp(-self.distance(self.at_row, self.at_column) / self.reach)


@dataclass(frozen=True)
class CrowdedReadout(HitChange):
    """The readout keeps up with quiet events, but loses hits of crowded ones, the more the more hits there are."""

    strength: float = strength(0.002, 0.03)
    power: float = drawn(1, 3)

    name = "inefficiency"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 3: readout losses"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        usual = max(float(self.place.reference.sum(axis=1).mean()), 1)
        return np.minimum(self.strength * (hits.sum(axis=1) / usual) ** self.power, 1)[:, None]


@dataclass(frozen=True)
class RotatingShadow(HitChange):
    """Efficiency differs around the beam like a wave, as where gas is renewed from one side, and is zero nowhere."""

    strength: float = strength(0.005, 0.07)
    waves: float = drawn(1, 3.99)
    phase: float = drawn(0, 1)
    even: float = drawn(0.3, 1)

    name = "inefficiency"
    source = "Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 7"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        wave = np.cos(int(self.waves) * self.azimuth + 2 * np.pi * self.phase)
        return self.strength * (self.even + (1 - self.even) * (1 + wave))


@dataclass(frozen=True)
class SinkingBias(HitChange):
    """The bias sinks during the run with the leakage current, so that hits are lost ever more often, most at the ends.

    Hits of slanted tracks share their charge among cells and so are the first to be missed.
    """

    strength: float = strength(0.008, 0.12)
    slant: float = drawn(0.5, 2)

    name = "inefficiency"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 2: depletion after irradiation"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        where = (1 + self.slant * np.abs(self.row)) / (1 + self.slant)
        return (self.strength * run_time(len(hits)))[:, None] * where


@dataclass(frozen=True)
class NoiseBursts(HitChange):
    """Now and then the whole sensor is noisy at once: an event then has a burst of extra hits anywhere, of any size."""

    strength: float = strength(0.0015, 0.02, "of events")
    size: float = drawn(4, 20, "hits")

    name = "random_noise"
    stage = 4
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 3: common-mode noise"

    def made(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        burst = rng.standard_exponential(len(hits)) * (rng.random(len(hits)) < self.strength)
        return np.minimum(self.size * burst / hits.shape[1], 0.5)[:, None]


@dataclass(frozen=True)
class BeamHalo(HitChange):
    """Particles of the beam's halo leave extra hits at random, more often towards both ends of the detector."""

    strength: float = strength(0.004, 0.12, "hits an event")
    power: float = drawn(1, 4)
    spill: float = drawn(0, 1)

    name = "random_noise"
    stage = 4
    source = "Grupen and Shwartz, Particle Detectors, 2nd ed. (2008), Ch. 3: beam background"

    def made(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        where = 0.2 + np.abs(self.row) ** self.power
        when = 1 + self.spill * np.cos(2 * np.pi * 7 * run_time(len(hits)))
        return (self.strength * when)[:, None] * (where / where.sum())


@dataclass(frozen=True)
class LateRemnant(Imaging):
    """Hits of the event before are still in the buffer when some events are read, and part of them are overlaid."""

    strength: float = strength(0.004, 0.1, "of events")
    part: float = drawn(0.4, 1)

    name = "pile_up"
    stage = 4
    source = "Wigmans, Calorimetry, 2nd ed. (2017): out-of-time pile-up"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        if len(x) < 2:
            return x
        rows = np.flatnonzero(rng.random(len(x)) < self.strength)
        before = x[rows - 1] * (rng.random((len(rows), x.shape[1])) < self.part)
        x[rows] = np.maximum(x[rows], before.astype(x.dtype))
        return x


@dataclass(frozen=True)
class DisplacedSecond(Imaging):
    """When bunches are full, a second collision elsewhere along the beam is recorded in the same image."""

    strength: float = strength(0.003, 0.06, "of events")
    apart: float = drawn(0.05, 0.4, "prior widths", sign=True)

    name = "pile_up"
    stage = 4
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 35; ATLAS, CMS pile-up"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        rows = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(rows):
            box, width = self.place.task.support, self.place.task.prior.width
            shift = self.apart * width * rng.standard_normal((len(rows), 1))
            second = simulate(np.clip(theta[rows] + shift, box.low, box.high), rng)
            x[rows] = np.maximum(x[rows], second)
        return x


@dataclass(frozen=True)
class QuietEventsVetoed(ImageSelection):
    """The trigger needs a sum of many hits, each of which it may miss, so that quiet events are often not recorded."""

    strength: float = strength(0.04, 0.8)
    fall: float = drawn(0.15, 0.4)

    name = "threshold"
    source = "PDG, Review of Particle Physics, Prog. Theor. Exp. Phys. 2022, 083C01, Sec. 35: triggers"

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        usual = max(float(self.place.reference.sum(axis=1).mean()), 1)
        return 1 - self.strength * np.exp(-((x.sum(axis=1) / (2 * self.fall * usual)) ** 2))


@dataclass(frozen=True)
class UnsettledThreshold(ImageSelection):
    """The least number of hits that starts the readout was changed several times in the run, and was once too high.

    Only hits away from both ends count.
    """

    strength: float = strength(0.05, 0.9)
    top: float = drawn(0.1, 0.35)
    barrel: float = drawn(0.5, 0.8)

    name = "threshold"
    source = "Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Ch. 17"

    def counted(self, x: NDArray) -> NDArray[np.float64]:
        """Hits that count: (n, d) -> (n,)."""
        return x[:, np.abs(self.row) < self.barrel].sum(axis=1, dtype=float)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        highest = max(np.quantile(self.counted(self.place.reference), self.top), 1)
        return 1 - self.strength * (np.ceil(4 * np.clip(1 - self.counted(x) / highest, 0, 1)) / 4)


@dataclass(frozen=True)
class DriftingBeam(ParticleChange):
    """The beam drifts sideways, slowly and in one direction, from the axis in the beginning to off it in the end."""

    strength: float = strength(0.04, 0.6, "mm")
    azimuth_turns: float = drawn(0, 1, "turns")
    power: float = drawn(0.4, 2)

    name = "transverse_offset"
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: beam spot"

    def altered(self, particles: "Particles", theta: Grid, time: Grid) -> "Particles":
        size = np.repeat(self.strength * time**self.power, np.diff(particles.offsets))
        angle = 2 * np.pi * self.azimuth_turns
        move = np.stack([np.cos(angle) * size, np.sin(angle) * size, np.zeros_like(size)])
        return replace(particles, position=particles.position + move)


@dataclass(frozen=True)
class TwoOrbits(ParticleChange):
    """Fills on two orbits follow each other: both lie off the axis on the same side, one further out than the other."""

    strength: float = strength(0.02, 0.3, "mm")
    azimuth_turns: float = drawn(0, 1, "turns")
    turned: float = drawn(0.02, 0.2, "turns")
    inner: float = drawn(0.1, 0.6)

    name = "transverse_offset"
    source = "Minty and Zimmermann, Measurement and Control of Charged Particle Beams (2003), Ch. 3"

    def altered(self, particles: "Particles", theta: Grid, time: Grid) -> "Particles":
        second = np.mod(np.floor(time * 12), 2) > 0
        size = self.strength * np.where(second, self.inner, 1)
        angle = 2 * np.pi * (self.azimuth_turns + np.where(second, self.turned, 0))
        move = np.stack([size * np.cos(angle), size * np.sin(angle), 0 * size])
        return replace(particles, position=particles.position + np.repeat(move, np.diff(particles.offsets), axis=1))


@dataclass(frozen=True)
class SettlingSupport(ParticleChange):
    """One foot of the support gives way, fast and then ever slower: the detector leans more and more to that side."""

    strength: float = strength(0.015, 0.25, "rad")
    azimuth_turns: float = drawn(0, 1, "turns")
    settle: float = drawn(0.1, 0.6, "run")

    name = "axial_tilt"
    source = "Blobel and Kleinwort, A new method for the alignment of track detectors, arXiv:hep-ex/0208021"

    def altered(self, particles: "Particles", theta: Grid, time: Grid) -> "Particles":
        number = np.diff(particles.offsets)
        tilt = np.repeat(self.strength * (1 - np.exp(-time / self.settle)), number)
        angle = 2 * np.pi * self.azimuth_turns
        axis = np.array([-np.sin(angle), np.cos(angle), 0.0])
        vertex = np.zeros_like(particles.position)
        vertex[2] = np.repeat(theta[:, 0], number)
        position = turned(particles.position + vertex, axis, tilt) - vertex
        return replace(particles, position=position, momentum=turned(particles.momentum, axis, tilt))


@dataclass(frozen=True)
class RockingFrame(ParticleChange):
    """The frame rocks about one horizontal axis with the pumps, around a resting position that is itself tilted."""

    strength: float = strength(0.01, 0.18, "rad")
    azimuth_turns: float = drawn(0, 1, "turns")
    rock: float = drawn(0.3, 1)
    cycles: float = drawn(5, 80, "1/run", log=True)

    name = "axial_tilt"
    source = "Blobel and Kleinwort, A new method for the alignment of track detectors, arXiv:hep-ex/0208021"

    def altered(self, particles: "Particles", theta: Grid, time: Grid) -> "Particles":
        number = np.diff(particles.offsets)
        tilt = np.repeat(self.strength * (1 + self.rock * np.sin(2 * np.pi * self.cycles * time)), number)
        angle = 2 * np.pi * self.azimuth_turns
        axis = np.array([-np.sin(angle), np.cos(angle), 0.0])
        vertex = np.zeros_like(particles.position)
        vertex[2] = np.repeat(theta[:, 0], number)
        position = turned(particles.position + vertex, axis, tilt) - vertex
        return replace(particles, position=position, momentum=turned(particles.momentum, axis, tilt))


@dataclass(frozen=True)
class LongBunch(Imaging):
    """Bunches are long: where in them two particles meet differs between events, so that the vertex moves."""

    strength: float = strength(0.04, 0.2, "prior widths")

    name = "spread"
    stage = 1
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rept. 427 (2006) 257: luminous region"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        box, width = self.place.task.support, self.place.task.prior.width
        jitter = rng.triangular(-1, 0, 1, theta.shape) * np.sqrt(6)
        return simulate(np.clip(theta + self.strength * width * jitter, box.low, box.high), rng)


@dataclass(frozen=True)
class SatelliteBunch(Imaging):
    """A share of the collisions takes place between satellite bunches, a fixed distance away along the beam."""

    strength: float = strength(0.03, 0.4, "of events")
    apart: float = drawn(0.3, 0.7, "prior widths", sign=True)

    name = "mixture"
    stage = 1
    source = "McLachlan and Peel, Finite Mixture Models (2000); ALICE and LHCb on satellite bunches"

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        box, width = self.place.task.support, self.place.task.prior.width
        other = rng.random(theta.shape) < self.strength
        return simulate(np.clip(theta + np.where(other, self.apart, 0) * width, box.low, box.high), rng)


@dataclass(frozen=True)
class WeakRowDriver(HitChange):
    """The driver of one row or column has too low a gain, so that part of the hits on it stay below the threshold."""

    strength: float = strength(0.02, 0.4)
    at: float = drawn(0.25, 0.75)
    along: float = drawn(1, 1, sign=True)
    neighbour: float = drawn(0, 0.5)

    name = "gain"
    source = "Rossi, Fischer, Rohe, Wermes, Pixel Detectors (2006), Ch. 3"

    def lost(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray:
        rows, columns = self.shape
        low = np.zeros(rows if self.along > 0 else columns)
        line = min(int(self.at * len(low)), len(low) - 1)
        low[line], low[line - 1] = self.strength, self.strength * self.neighbour
        return np.repeat(low, columns) if self.along > 0 else np.tile(low, rows)


FAMILIES = (
    ScratchedSensor,
    CrackedBonds,
    Delamination,
    BlinkingCells,
    HotCluster,
    CrowdedReadout,
    RotatingShadow,
    SinkingBias,
    NoiseBursts,
    BeamHalo,
    LateRemnant,
    DisplacedSecond,
    QuietEventsVetoed,
    UnsettledThreshold,
    DriftingBeam,
    TwoOrbits,
    SettlingSupport,
    RockingFrame,
)
NEW_FAMILIES = (
    LongBunch,
    SatelliteBunch,
    WeakRowDriver,
)
