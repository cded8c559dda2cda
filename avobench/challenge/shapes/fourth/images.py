"""Effects in images of the cells of a cylindrical detector: rows along its axis, columns around it."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Injection, Place, Selection, Simulate, drawn, strength


def grid(place: Place) -> tuple[int, int]:
    """Rows and columns."""
    rows, columns = place.task.event_shape[-2:]
    return int(rows), int(columns)


def hits(x: NDArray) -> NDArray[np.int64]:
    """Cells that fired, of each event."""
    return (x.reshape(len(x), -1) != 0).sum(axis=1)


def overlaid(place: Place, x: NDArray, more: NDArray) -> NDArray:
    return np.maximum(x, more) if place.binary else x + more


def fired(place: Place, x: NDArray, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray:
    """With further cells fired, each as strongly as a hit of the reference."""
    out = x.copy()
    sizes = np.ones(len(cells)) if place.binary else rng.choice(place.reference[place.reference > 0], len(cells))
    flat = out.reshape(len(out), -1)
    flat[events, cells] = np.maximum(flat[events, cells], sizes.astype(out.dtype))
    return out


class OnImage(Injection):
    """An injection that changes the image of every event by itself."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return len(place.task.event_shape) >= 2

    @abstractmethod
    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        """Images as they are read out: (n, cells) -> (n, cells)."""

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        return self.image(x.reshape(len(x), -1), rng).reshape(x.shape)


class MissingHits(OnImage):
    """An injection that loses hits."""

    @abstractmethod
    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        """The probability that a hit is lost, for the hits in these cells of these events."""

    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        events, cells = np.divmod(np.flatnonzero(x != 0), x.shape[1])
        lost = rng.random(len(cells)) < self.missed(events, cells, rng)
        out = x.copy()
        out[events[lost], cells[lost]] = 0
        return out


@dataclass(frozen=True)
class DeadChip(MissingHits):
    """One readout chip has died, and all cells of the rectangle that it serves stay empty."""

    name = "dead_cells"
    source = "front-end chips of pixel modules"

    strength: float = strength(0.001, 0.08, "of cells")
    row: float = drawn(0.3, 0.7, "of the length")
    column: float = drawn(0.0, 1.0, "of the way around")

    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        rows, columns = grid(self.place)
        side = np.sqrt(self.strength * rows * columns)
        high, wide = max(1, round(side)), max(1, round(side**2 / max(1, round(side))))
        row, column = np.divmod(cells, columns)
        inside = (np.abs(row - round(self.row * (rows - 1)) + 0.25) <= high / 2) & (
            (column - int(self.column * columns)) % columns < wide
        )
        return inside.astype(float)


@dataclass(frozen=True)
class PeelingBonds(MissingHits):
    """The bonds between sensor and electronics have come off, nearly all around one point and fewer and fewer away from
    it, and cells without a bond give no signal."""

    name = "dead_cells"
    source = "delamination of bump bonds after thermal cycles"

    strength: float = strength(0.025, 0.16, "of the detector's size, radius")
    row: float = drawn(0.3, 0.7, "of the length")
    column: float = drawn(0.0, 1.0, "of the way around")
    pattern: float = drawn(0.0, 1e6, "which bonds")

    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        rows, columns = grid(self.place)
        row, column = np.indices((rows, columns))
        across = np.abs(column / columns - self.column)
        away = np.hypot((row + 0.5) / rows - self.row, np.minimum(across, 1 - across))
        chance = np.random.default_rng(int(self.pattern)).random((rows, columns))
        dead = chance < np.exp(-((away / self.strength) ** 2))
        return dead.ravel()[cells].astype(float)


@dataclass(frozen=True)
class LeakyCells(OnImage):
    """Some cells, always the same, have a high leakage current and fire by themselves, each at its own rate: a few
    often, most of them seldom."""

    name = "noisy_cells"
    source = "noise maps of irradiated pixel detectors"
    stage = 4

    strength: float = strength(0.002, 0.06, "of cells")
    rate: float = drawn(0.02, 0.15, "an event, of the noisiest")
    pattern: float = drawn(0.0, 1e6, "which cells")

    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        fixed = np.random.default_rng(int(self.pattern))
        noisy = fixed.choice(x.shape[1], max(1, round(self.strength * x.shape[1])), replace=False)
        rates = self.rate * 0.05 ** (np.arange(len(noisy)) / len(noisy))
        events, which = np.nonzero(rng.random((len(x), len(noisy)), dtype=np.float32) < rates)
        return fired(self.place, x, events, noisy[which], rng)


@dataclass(frozen=True)
class ScratchedSensor(OnImage):
    """A scratch runs across the sensor, and the cells along it draw current and fire by themselves now and then."""

    name = "noisy_cells"
    source = "handling damage on silicon sensors"
    stage = 4

    strength: float = strength(0.0005, 0.1, "an event and cell")
    row: float = drawn(0.1, 0.9, "of the length")
    column: float = drawn(0.0, 1.0, "of the way around")
    slope: float = drawn(0.3, 1.5, "rows a column", sign=True)

    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        rows, columns = grid(self.place)
        along = np.arange(max(3, columns // 4))
        row = np.rint(self.row * (rows - 1) + self.slope * (along - along.mean())).astype(int)
        column = (int(self.column * columns) + along) % columns
        there = (row >= 0) & (row < rows)
        cells = (row * columns + column)[there]
        events, which = np.nonzero(rng.random((len(x), len(cells)), dtype=np.float32) < self.strength)
        return fired(self.place, x, events, cells[which], rng)


@dataclass(frozen=True)
class ClockPhase(MissingHits):
    """Signals that arrive late against the clock are not latched; the phase of the clock differs from event to event,
    and with it the share of the hits that all cells miss."""

    name = "inefficiency"
    source = "time walk against the bunch clock"

    strength: float = strength(0.01, 0.35, "of hits")

    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        phase = rng.random(int(events.max(initial=0)) + 1)
        return 2 * self.strength * phase[events]


@dataclass(frozen=True)
class PickUp(OnImage):
    """Radio pick-up lifts the baseline by a different amount in each event, and cells anywhere fire at random, none in
    most events and many in some."""

    name = "random_noise"
    source = "electromagnetic interference on front-end boards"
    stage = 4

    strength: float = strength(0.03, 4.0, "cells an event")

    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        number = rng.poisson(self.strength * rng.exponential(size=len(x)))
        events = np.repeat(np.arange(len(x)), number)
        return fired(self.place, x, events, rng.integers(x.shape[1], size=len(events)), rng)


@dataclass(frozen=True)
class Photons(OnImage):
    """Soft photons from the beam are absorbed anywhere in the sensor at random, and each of them fires one cell or two
    neighbouring ones."""

    name = "random_noise"
    source = "synchrotron radiation at e+e- colliders"
    stage = 4

    strength: float = strength(0.02, 3.0, "photons an event")
    pairs: float = drawn(0.1, 0.5, "of photons that fire two cells")

    def image(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        rows, columns = grid(self.place)
        events = np.repeat(np.arange(len(x)), rng.poisson(self.strength, len(x)))
        row, column = rng.integers(rows, size=len(events)), rng.integers(columns, size=len(events))
        two = rng.random(len(events)) < self.pairs
        second = row * columns + (column + 1) % columns
        cells = np.r_[row * columns + column, second[two]]
        return fired(self.place, x, np.r_[events, events[two]], cells, rng)


@dataclass(frozen=True)
class Overlay(Injection):
    """In some events a second collision happens in the same crossing of the beams, and both are read as one image."""

    name = "pile_up"
    source = "in-time pile-up at colliders"
    stage = 4

    strength: float = strength(0.005, 0.4, "of events")

    def kept(self, more: NDArray, rng: np.random.Generator) -> NDArray:
        """What is still to be seen of the second collision."""
        return more

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng).copy()
        rows = np.flatnonzero(rng.random(len(x)) < self.strength)
        if len(rows):
            x[rows] = overlaid(self.place, x[rows], self.kept(simulate(theta[rows], rng), rng))
        return x


@dataclass(frozen=True)
class LatePulses(Overlay):
    """In some events the cells of the collision one crossing before are still above threshold, a part of them, and are
    read along with the hits of this one."""

    source = "out-of-time pile-up with slow shapers"

    above: float = drawn(0.4, 0.9, "of the earlier hits")

    def kept(self, more: NDArray, rng: np.random.Generator) -> NDArray:
        return more * (rng.random(more.shape, dtype=np.float32) < self.above)


class ByHits(Selection):
    """A loss of events that depends on their number of hits."""

    @property
    def typical(self) -> float:
        return float(hits(self.place.reference).mean())


@dataclass(frozen=True)
class FastOr(ByHits):
    """Only some of the cells are wired to the trigger, which wants two of them to fire: events with few hits often fail
    it and are not read out."""

    name = "threshold"
    source = "fast-OR triggers of pixel chips"

    strength: float = strength(0.15, 0.6, "one over the typical hits that the trigger sees")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        n = hits(x)
        share = min(1 / (self.strength * max(self.typical, 1.0)), 0.9)
        return 1 - (1 - share) ** n - n * share * (1 - share) ** np.maximum(n - 1, 0)


@dataclass(frozen=True)
class DriftingLevel(ByHits):
    """The summed current of all cells must be above a level to start the readout; the level drifts evenly between two
    values, and events with few hits are below it."""

    name = "threshold"
    source = "analogue multiplicity sums"

    strength: float = strength(0.01, 0.4, "of events below the mean level")
    drift: float = drawn(0.05, 0.25, "of the typical hits")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        level = np.quantile(hits(self.place.reference), self.strength)
        return np.clip((hits(x) - level) / (2 * self.drift * self.typical) + 0.5, 0, 1)


@dataclass(frozen=True)
class WeakStave(MissingHits):
    """The sensors of one stave along the axis run at too low a voltage, and so this one column misses a share of its
    hits."""

    name = "gain"
    source = "partly depleted sensors"

    strength: float = strength(0.05, 1.0, "of the column's hits")
    column: float = drawn(0.0, 1.0, "of the way around")

    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        columns = grid(self.place)[1]
        return self.strength * (cells % columns == min(int(self.column * columns), columns - 1))


@dataclass(frozen=True)
class RingSupply(MissingHits):
    """The cells of one ring are fed one after another around it, and by the drop of voltage on the line the cells
    towards its end miss more and more of their hits."""

    name = "gain"
    source = "voltage drop on serial supply lines"

    strength: float = strength(0.05, 1.0, "of hits at the end of the line")
    row: float = drawn(0.35, 0.65, "of the length")
    feed: float = drawn(0.0, 1.0, "of the way around")

    def missed(self, events: NDArray, cells: NDArray, rng: np.random.Generator) -> NDArray[np.float64]:
        rows, columns = grid(self.place)
        along = ((cells % columns) / columns - self.feed) % 1
        return self.strength * np.sqrt(along) * (cells // columns == round(self.row * (rows - 1)))


FAMILIES = (
    DeadChip,
    PeelingBonds,
    LeakyCells,
    ScratchedSensor,
    ClockPhase,
    PickUp,
    Photons,
    Overlay,
    LatePulses,
    FastOr,
    DriftingLevel,
    WeakStave,
    RingSupply,
)
