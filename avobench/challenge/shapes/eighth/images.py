"""Images of hits: cells, lines, triggers and second events that a real detector has and the simulation lacks."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Injection, Selection, Simulate, drawn, strength
from avobench.challenge.shapes.places import Image, Picture


def usual_number(injection: Image) -> float:
    """Mean number of hits in an image."""
    return float(injection.place.reference.sum(axis=1, dtype=float).mean())


def struck(hits: NDArray[np.bool_]) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """The images as one flat view, where in it the hits are, and of which event and cell each is."""
    flat = hits.reshape(-1)
    at = np.flatnonzero(flat)
    event, cell = np.divmod(at, hits[0].size)
    return flat, at, event, cell


def chosen_cells(shape: tuple[int, ...], pattern: float) -> NDArray[np.int64]:
    """All cells in an order that `pattern` fixes."""
    return np.random.default_rng(int(pattern)).permutation(shape[0] * shape[1])


@dataclass(frozen=True)
class PeelingBonds(Picture):
    """The solder bonds between a sensor and its chip tear off from the corner of the chip where two modules meet. Cells
    up to some distance from it record nothing, and those at the front of the tear have a loose contact."""

    strength: float = strength(0.15, 7, "cells")
    chip: float = drawn(0, 8)
    """Which of the chips along the seam in the middle, 4 on either side."""
    corner: float = drawn(0, 2)
    """Which of its two corners at the seam."""

    name = "dead_cells"
    source = "hybrid pixel detectors after thermal cycles"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        height, width = (length // 4 for length in self.shape)
        below, along = divmod(int(self.chip) % 8, 4)
        row, column = np.arange(height), np.arange(width)
        distance = (row if below else row[::-1])[:, None] + (column[::-1] if self.corner >= 1 else column)
        loose = np.clip(self.strength - distance, 0, 1)
        top = self.shape[0] // 2 - (0 if below else height)
        part = hits[:, top : top + height, along * width : (along + 1) * width]
        part &= rng.random(part.shape) >= loose
        return hits


@dataclass(frozen=True)
class UpsetMasks(Picture):
    """Radiation flips bits in the mask register, and a cell that was masked so stays silent to the end of the run. The
    later an event is, the more cells are missing, and always the same ones."""

    strength: float = strength(0.006, 0.3)
    """How many upsets a cell suffers in the run on average."""
    pattern: float = drawn(0, 1e6)
    """Which cells are hit first."""

    name = "dead_cells"
    source = "single-event upsets in pixel chips"

    @cached_property
    def upset(self) -> NDArray[np.float64]:
        """When each cell is masked, where the run lasts from 0 to 1."""
        rank = np.argsort(chosen_cells(self.shape, self.pattern))
        return -np.log1p(-(rank + 0.5) / len(rank)) / self.strength

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        time = rng.random(len(hits))
        flat, at, event, cell = struck(hits)
        flat[at[time[event] > self.upset[cell]]] = False
        return hits


@dataclass(frozen=True)
class LeakyPixels(Picture):
    """A handful of cells have a leakage current so large that they fire by themselves. The worst of them fires most,
    the second half as often, the third a third as often."""

    strength: float = strength(0.003, 0.4)
    """How often the worst cell fires in an event."""
    pattern: float = drawn(0, 1e6)
    """Which cells."""

    name = "noisy_cells"
    source = "hot pixels of silicon sensors and cameras"
    stage = 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        cells = chosen_cells(self.shape, self.pattern)[:7]
        flat = hits.reshape(len(hits), -1)
        flat[:, cells] |= rng.random((len(hits), len(cells))) < self.strength / np.arange(1, len(cells) + 1)
        return hits


@dataclass(frozen=True)
class PinholeLight(Picture):
    """Room light enters by a pinhole in the wrapping and shines on the few cells below it. They fire without a
    particle, the one straight below most often and the others less with the fourth power of the cosine of the angle."""

    strength: float = strength(0.003, 0.7)
    """Mean number of light pulses in a cell straight below the hole."""
    row: float = drawn(4, 27, "cells")
    column: float = drawn(0, 32, "cells")

    name = "noisy_cells"
    source = "light leaks of photomultiplier and silicon photomultiplier arrays"
    stage = 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        down = np.arange(rows)[:, None] - self.row
        right = (np.arange(columns) - self.column + columns / 2) % columns - columns / 2
        fires = -np.expm1(-self.strength / (1 + (down**2 + right**2) / 0.7**2) ** 2)
        lit = np.nonzero((fires > 0.02 * self.strength) & (down**2 + right**2 < 9))
        hits[:, *lit] |= rng.random((len(hits), len(lit[0]))) < fires[lit]
        return hits


@dataclass(frozen=True)
class CrowdedLink(Picture):
    """All hits of an event share one data link, which drops words at random when it is crowded. The more hits an image
    has, the larger is the part of them that is missing, wherever they are."""

    strength: float = strength(0.004, 0.5)
    """Share of the hits lost in an image of the mean number of hits, as long as it is small."""

    name = "inefficiency"
    source = "bandwidth limits of tracker readout"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        flat, at, event, _ = struck(hits)
        passed = np.exp(-self.strength * np.bincount(event, minlength=len(hits)) / usual_number(self))
        flat[at[rng.random(len(at)) >= passed[event]]] = False
        return hits


@dataclass(frozen=True)
class ClockEdge(Picture):
    """Particles come at any phase of the readout clock, and signals close to the clock's edge slip into the next gate.
    Such images miss a part of their hits all over the detector, anything from a few to nearly all."""

    strength: float = strength(0.008, 0.6)
    """Share of the clock's period that lies close to its edge."""

    name = "inefficiency"
    source = "beam tests with an asynchronous clock"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        slips = np.maximum(1 - rng.random(len(hits)) / self.strength, 0)
        flat, at, event, _ = struck(hits)
        flat[at[rng.random(len(at)) < slips[event]]] = False
        return hits


@dataclass(frozen=True)
class WarmHall(Picture):
    """Cells fire at random from thermal noise, anywhere on the detector. Its rate rises and falls exponentially with
    the temperature of the hall, which swings between night and day."""

    strength: float = strength(0.004, 0.5)
    """Noise hits at the mean temperature, for each hit of a particle."""
    swing: float = drawn(0.2, 1.2)
    """Logarithm of how much more noise there is at the warmest hour."""

    name = "random_noise"
    source = "dark counts of uncooled silicon"
    stage = 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        hour = rng.uniform(0, 2 * np.pi, len(hits))
        number = rng.poisson(self.strength * usual_number(self) * np.exp(self.swing * np.cos(hour)))
        event = np.repeat(np.arange(len(hits)), number)
        hits.reshape(len(hits), -1)[event, rng.integers(hits[0].size, size=len(event))] = True
        return hits


@dataclass(frozen=True)
class StrayElectrons(Picture):
    """Decays in the surrounding rock shoot stray electrons into the detector, which stop anywhere in it. Each leaves a
    short random walk of a few fired cells that has nothing to do with the event."""

    strength: float = strength(0.002, 0.25)
    """Electrons for each hit of a particle."""
    goes_on: float = drawn(0.2, 0.7)
    """How likely an electron reaches yet another cell."""

    name = "random_noise"
    source = "natural radioactivity in gaseous and pixel detectors"
    stage = 4

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        rows, columns = self.shape
        event = np.repeat(np.arange(len(hits)), rng.poisson(self.strength * usual_number(self), len(hits)))
        row, column = rng.integers(rows, size=len(event)), rng.integers(columns, size=len(event))
        for _ in range(12):
            hits[event, row, column] = True
            on = rng.random(len(event)) < self.goes_on
            turn = rng.integers(4, size=len(event))
            row, column = row + np.array([1, -1, 0, 0])[turn], (column + np.array([0, 0, 1, -1])[turn]) % columns
            on &= (row >= 0) & (row < rows)
            event, row, column = event[on], row[on], column[on]
        return hits


@dataclass(frozen=True)
class UnevenBunches(Image):
    """Bunches of the beam hold unequal charges, and in the rich ones a second or third collision happens at once. Their
    hits stand in the same image."""

    strength: float = strength(0.004, 0.5)
    """Mean number of further collisions."""
    evenness: float = drawn(0.5, 5, log=True)
    """One over the variance of the relative charge."""

    name = "pile_up"
    source = "colliders with uneven bunch charges"
    stage = 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        more = rng.poisson(self.strength * rng.gamma(self.evenness, 1 / self.evenness, len(x)))
        for k in range(4):
            rows = np.flatnonzero(more > k)
            if len(rows):
                x[rows] = np.maximum(x[rows], simulate(theta[rows], rng))
        return x


@dataclass(frozen=True)
class FadingPredecessor(Image):
    """The event before has not quite faded when the next one is read, as the cells forget exponentially and the time
    between events is random. Such images show, beside their own hits, what is left of another event."""

    strength: float = strength(0.008, 0.6)
    """Rate of events times the time in which a cell forgets."""

    name = "pile_up"
    source = "out-of-time signals of slow detectors, as drift chambers and monolithic pixels"
    stage = 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        left = np.exp(-rng.exponential(1 / self.strength, len(x)))
        rows = np.flatnonzero(left > 0.01)
        if len(rows):
            before = self.pictures(simulate(theta[rows], rng))
            flat, at, event, _ = struck(before)
            flat[at[rng.random(len(at)) >= left[rows[event]]]] = False
            x[rows] = np.maximum(x[rows], flat.reshape(len(rows), -1))
        return x


@dataclass(frozen=True)
class SummedTrigger(Image, Selection):
    """The readout starts when the analogue sum of all cells passes a discriminator, and the sum carries noise. Images
    with few hits are lost, with a smooth turn-on around the threshold."""

    strength: float = strength(0.004, 0.4)
    """Share of the images that have fewer hits than the threshold."""
    noise: float = drawn(0.02, 0.25, log=True)
    """Of the sum, over the threshold."""

    name = "threshold"
    source = "sum triggers of calorimeters and Cherenkov cameras"

    @cached_property
    def limit(self) -> float:
        return max(float(np.quantile(self.place.reference.sum(axis=1, dtype=float), self.strength)), 1.0)

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        return ndtr((x.sum(axis=1, dtype=float) - self.limit) / (self.noise * self.limit))


@dataclass(frozen=True)
class SelfTriggered(Image, Selection):
    """The trigger samples only a few cells, others each time, and two of them must be hit to start the readout. An
    image with few hits often has fewer than two among those cells and is lost."""

    strength: float = strength(0.004, 0.4)
    """Share of the images lost that have half the usual number of hits."""

    name = "threshold"
    source = "self-triggered arrays with a random coincidence"

    @cached_property
    def sampled(self) -> float:
        """Mean number of hits on sampled cells that an image of the usual number of hits has."""
        numbers = np.linspace(0, 30, 3001)
        return 2 * float(np.interp(-self.strength, -(1 + numbers) * np.exp(-numbers), numbers))

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        fired = self.sampled * x.sum(axis=1, dtype=float) / usual_number(self)
        return 1 - (1 + fired) * np.exp(-fired)


@dataclass(frozen=True)
class SaggingSupply(Picture):
    """One row of cells hangs on a weak supply, which sags the more of its cells draw current at once. The row loses a
    part of its hits, and a larger one when many of its cells are hit."""

    strength: float = strength(0.01, 1.5)
    """Loss for each further hit in the row, as long as it is small."""
    row: float = drawn(12, 20, "cells")

    name = "gain"
    source = "voltage drop along the power lines of pixel rows"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        line = hits[:, int(self.row) % self.shape[0]]
        others = np.maximum(line.sum(axis=1) - 1, 0)
        line &= rng.random(line.shape) < 1 / (1 + self.strength * others)[:, None]
        return hits


@dataclass(frozen=True)
class ResistiveColumn(Picture):
    """The readout line of one column has too large a resistance, so its signals shrink on the way to the amplifier. The
    column loses a part of its hits, the more the farther they are from the amplifier."""

    strength: float = strength(0.03, 3)
    """Length of the column over the length in which the signal falls by e."""
    column: float = drawn(0, 32, "cells")

    name = "gain"
    source = "attenuation in strips and resistive wires"

    def alter(self, hits: NDArray[np.bool_], rng: np.random.Generator) -> NDArray[np.bool_]:
        line = hits[:, :, int(self.column) % self.shape[1]]
        distance = (np.arange(self.shape[0]) + 0.5) / self.shape[0]
        line &= rng.random(line.shape) < np.exp(-self.strength * distance)
        return hits


FAMILIES: tuple[type[Injection], ...] = (
    PeelingBonds,
    UpsetMasks,
    LeakyPixels,
    PinholeLight,
    CrowdedLink,
    ClockEdge,
    WarmHall,
    StrayElectrons,
    UnevenBunches,
    FadingPredecessor,
    SummedTrigger,
    SelfTriggered,
    SaggingSupply,
    ResistiveColumn,
)
