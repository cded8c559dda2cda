"""Cells of an image that fail or fire, noise, and several collisions in one image. None needs to know the task."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avobench.challenge.shapes.contract import Injection, Place, Selection, Simulate, drawn, strength


class ImageInjection(Injection):
    """An injection that changes images once they are made."""

    stage = 4

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.change(simulate(theta, rng).copy(), rng)

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        """(n, d) -> (n, d), possibly in place."""
        raise NotImplementedError


def overlay(place: Place, x: NDArray, more: NDArray) -> NDArray:
    """Two images in one: hits stay hits, energies add up. (n, d), (n, d) -> (n, d) of x's type."""
    return np.maximum(x, more) if place.binary else (x + more).astype(x.dtype)


def lose(x: NDArray, probability: NDArray[np.float64] | float, rng: np.random.Generator) -> NDArray:
    """Lose hits, in place, each with its probability: (n, d), what broadcasts to (n, d) -> (n, d)."""
    event, cell = np.nonzero(x)
    lost = rng.random(len(cell)) < np.broadcast_to(probability, x.shape)[event, cell]
    x[event[lost], cell[lost]] = 0
    return x


def walk(place: Place, cells: int, seed: int) -> NDArray[np.int64]:
    """The first `cells` cells that a random walk on the image visits, without end on cyclic axes: (cells,)."""
    rng, shape = np.random.default_rng(seed), np.array(place.task.event_shape)
    at = rng.integers(shape)
    visited = {tuple(at)}
    while len(visited) < min(cells, shape.prod()):
        axis = rng.integers(len(shape))
        step = at[axis] + rng.choice([-1, 1])
        at[axis] = step % shape[axis] if axis in place.task.cyclic_axes else np.clip(step, 0, shape[axis] - 1)
        visited.add(tuple(at))
    return np.array([np.ravel_multi_index(cell, shape) for cell in sorted(visited)])


@dataclass(frozen=True)
class DeadPatch(ImageInjection):
    """A patch of neighbouring cells of irregular shape answers seldom or not at all."""

    name: ClassVar = "dead_cells"
    source: ClassVar = "dead readout channels of pixel detectors"
    strength: float = strength(2, 80, "cells")
    residual: float = drawn(0, 0.3)
    seed: float = drawn(0, 2**31, "where")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        cells = walk(self.place, round(self.strength), int(self.seed))
        x[:, cells] *= rng.random((len(x), len(cells))) < self.residual
        return x


@dataclass(frozen=True)
class HotCells(ImageInjection):
    """A few cells, scattered over the detector, fire on their own, each with its own probability."""

    name: ClassVar = "noisy_cells"
    source: ClassVar = "hot pixels, whose rates spread over orders of magnitude"
    strength: float = strength(0.003, 0.3, "per event and cell")
    cells: float = drawn(2, 12, "rounded down")
    spread: float = drawn(0.2, 1, "standard deviation of the logarithm")
    seed: float = drawn(0, 2**31, "where")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        which = np.random.default_rng(int(self.seed))
        cells = which.choice(x.shape[1], int(self.cells), replace=False)
        rate = np.minimum(self.strength * np.exp(self.spread * which.standard_normal(len(cells))), 1)
        fired = rng.random((len(x), len(cells))) < rate
        x[:, cells] = overlay(self.place, x[:, cells], fired * hit_size(self.place))
        return x


@dataclass(frozen=True)
class UnevenEfficiency(ImageInjection):
    """Hits are lost everywhere, in some parts of the detector more than in others."""

    name: ClassVar = "inefficiency"
    source: ClassVar = "ageing of detectors, uneven over their surface"
    strength: float = strength(0.003, 0.3)
    unevenness: float = drawn(0, 0.3)
    phase: float = drawn(0, 2 * np.pi, "rad")

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        axes = np.meshgrid(
            *(np.linspace(0, 2 * np.pi, n, endpoint=False) for n in self.place.task.event_shape), indexing="ij"
        )
        wave = np.cos(sum(axes) + self.phase).ravel()
        return lose(x, self.strength * (1 + self.unevenness * wave), rng)


@dataclass(frozen=True)
class NoiseClusters(ImageInjection):
    """False hits at random places, in a number that varies widely from event to event, some of them in pairs."""

    name: ClassVar = "random_noise"
    source: ClassVar = "electronic noise in bursts; delta electrons make neighbouring hits"
    strength: float = strength(0.02, 3, "clusters an event")
    burst: float = drawn(0.2, 0.8, "standard deviation of the logarithm")
    pairs: float = drawn(0, 0.5)

    def change(self, x: NDArray, rng: np.random.Generator) -> NDArray:
        size = np.exp(self.burst * rng.standard_normal(len(x)) - self.burst**2 / 2)
        event = np.repeat(np.arange(len(x)), rng.poisson(self.strength * size))
        cell = rng.integers(x.shape[1], size=len(event))
        second = (rng.random(len(event)) < self.pairs) & (cell + 1 < x.shape[1])
        noise = np.zeros_like(x)
        noise[event, cell] = hit_size(self.place)
        noise[event[second], cell[second] + 1] = hit_size(self.place)
        return overlay(self.place, x, noise)


class PileUp(Injection):
    """An injection by which other collisions, `strength` of them an event on average, are seen in the same image."""

    name = "pile_up"
    stage = 2
    strength: float

    def others(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """Images of other collisions in events at theta: (m, p) -> (m, d)."""
        raise NotImplementedError

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        x = simulate(theta, rng)
        event = np.repeat(np.arange(len(x)), rng.poisson(self.strength, len(x)))
        if not len(event):
            return x
        for one, image in zip(event, self.others(simulate, theta[event], rng), strict=True):
            x[one] = overlay(self.place, x[one], image)
        return x


@dataclass(frozen=True)
class SpreadPileUp(PileUp):
    """Other collisions, spread along the beam, leave their tracks in the same image."""

    source: ClassVar = "pile-up at colliders, with a luminous region of finite length"
    strength: float = strength(0.003, 0.3, "collisions an event")
    spread: float = drawn(0, 0.2, "of the support's width")

    def others(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        support = self.place.task.support
        elsewhere = theta + self.spread * support.width * rng.uniform(-1, 1, theta.shape)
        return simulate(np.clip(elsewhere, support.low, support.high), rng)


@dataclass(frozen=True)
class MultiplicityTrigger(Selection):
    """An event with few hits may not start the readout: an erf turn-on in the number of hits."""

    name: ClassVar = "threshold"
    source: ClassVar = "the usual erf turn-on of multiplicity triggers"
    strength: float = strength(0.01, 0.4, "share of the events below the threshold")
    width: float = drawn(0.1, 0.5, "standard deviations")

    def efficiency(self, x: NDArray) -> NDArray[np.float64]:
        hits = np.count_nonzero(self.place.reference, axis=1)
        threshold = np.quantile(hits, self.strength)
        return ndtr((np.count_nonzero(x, axis=1) + 0.5 - threshold) / (self.width * hits.std()))


def hit_size(place: Place) -> float:
    """What a false hit leaves: 1, or the median of what a true one leaves where hits have sizes."""
    return 1 if place.binary else float(np.median(place.reference[place.reference > 0]))
