"""The likelihood of binned events over the whole range of parameters, as a network learns it, and where it is largest.

The network gives the probability of each bin at parameters u of the unit cube. It learns from single events of
parameters from a box, which narrows from round to round around where the likelihood of the measured events is large:
sequential neural likelihood (G. Papamakarios, D. C. Sterratt, I. Murray, AISTATS 2019) of bins. So it finds a narrow
peak of unknown place: no slope elsewhere leads to that, and the points of a scan seldom hit all parameters at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from avobench.diagnosis.settings import EMULATOR
from avobench.diagnosis.summary.bins import Bins
from avobench.diagnosis.summary.target import Target

Array = NDArray[np.float32]
alone = threadpool_limits.wrap(limits=1, user_api="blas")
"""Several threads only wait for each other where matrices are so small."""


@dataclass(frozen=True)
class Blocks:
    """The blocks of bins that a network learns: those of features and, unless they are many, of pairs of these."""

    summary: Bins
    starts: NDArray[np.intp]
    """The first bin of each (blocks,)."""
    size: int
    """Bins of all blocks."""

    @classmethod
    def of(cls, summary: Bins) -> "Blocks":
        sizes = [bins for _, bins in summary.blocks]
        sizes = sizes if sum(sizes) <= EMULATOR.most_bins else sizes[: len(summary.edges)]
        return cls(summary, np.cumsum([0, *sizes[:-1]]), sum(sizes))

    def bins(self, x: NDArray) -> NDArray[np.int32]:
        """The bins of events (n, d), one in each block: (n, blocks)."""
        return self.summary.indices(x)[:, : len(self.starts)]

    def normalised(self, scores: Array) -> Array:
        """Logarithms of probabilities that sum to one in each block, from scores (n, size), which are overwritten."""
        for block in np.split(scores, self.starts[1:], axis=1):
            block -= block.max(axis=1, keepdims=True)
            block -= np.log(np.exp(block).sum(axis=1, keepdims=True))
        return scores


class Network:
    """Two hidden layers and a softmax for each block of bins, trained by Adam at a rate that falls to zero.

    Scikit-learn's classifier has one block and a constant rate: with it a search took three times as long, and ended
    far from the peak in half of six cases.
    """

    @alone
    def __init__(
        self, u: NDArray[np.float64], bins: NDArray[np.int32], blocks: Blocks, rng: np.random.Generator
    ) -> None:
        """Learn from simulated events: parameters u (n, p) in [-1, 1], and the bins of each (n, blocks)."""
        self.blocks, width = blocks, EMULATOR.width
        shapes = [(u.shape[1], width), (width, width), (width, blocks.size)]
        self.weights = [rng.normal(0, np.sqrt(2 / m), (m, k)).astype(np.float32) for m, k in shapes]
        self.biases = [np.zeros(k, np.float32) for _, k in shapes]
        learnt = self.weights + self.biases
        first, second = ([np.zeros_like(each) for each in learnt] for _ in range(2))
        steps = [
            order[at : at + EMULATOR.batch]
            for order in (rng.permutation(len(u)) for _ in range(EMULATOR.epochs))
            for at in range(0, len(u), EMULATOR.batch)
        ]
        u = u.astype(np.float32)
        for step, some in enumerate(steps, 1):
            rate = EMULATOR.rate * (1 - step / len(steps)) * np.sqrt(1 - 0.999**step) / (1 - 0.9**step)
            for each, slope, m, v in zip(learnt, self._slopes(u[some], bins[some]), first, second, strict=True):
                m += 0.1 * (slope - m)
                v += 0.001 * (slope**2 - v)
                each -= (rate * m / (np.sqrt(v) + 1e-8)).astype(np.float32)

    def _layers(self, u: Array) -> tuple[Array, Array, Array]:
        one = np.maximum(u @ self.weights[0] + self.biases[0], 0)
        two = np.maximum(one @ self.weights[1] + self.biases[1], 0)
        return one, two, self.blocks.normalised(two @ self.weights[2] + self.biases[2])

    def _slopes(self, u: Array, bins: NDArray[np.int32]) -> list[Array]:
        """Those of the mean cross-entropy of the bins."""
        one, two, logarithms = self._layers(u)
        last = np.exp(logarithms)
        last[np.arange(len(u))[:, None], bins] -= 1
        last /= len(u)
        middle = (last @ self.weights[2].T) * (two > 0)
        front = (middle @ self.weights[1].T) * (one > 0)
        return [u.T @ front, one.T @ middle, two.T @ last, *(each.sum(axis=0) for each in (front, middle, last))]

    def __call__(self, u: NDArray[np.float64]) -> Array:
        """Logarithms of the probabilities at u (m, p) in [-1, 1]: (m, size)."""
        return self._layers(u.astype(np.float32))[2]

    @alone
    def followed(
        self, counts: NDArray[np.float64], rng: np.random.Generator
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points t (m, p) in [-1, 1] about as often as counts (size,) are likely there, and the logarithm of that."""

        def likelihood(t: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.concatenate([self(some) @ counts for some in np.array_split(t, len(t) // EMULATOR.at_once + 1)])

        t = rng.uniform(-1, 1, (EMULATOR.tried, len(self.weights[0])))
        value = likelihood(t)
        first = value.argsort()[-EMULATOR.points :]
        t, value = t[first], value[first]
        for _ in range(EMULATOR.moves):
            spread = EMULATOR.move * np.maximum(t.std(axis=0), EMULATOR.least)
            moved = np.clip(t + spread * rng.standard_normal(t.shape), -1, 1)
            t, value = np.vstack([t, moved]), np.r_[value, likelihood(moved)]
            drawn = (value + rng.gumbel(size=len(t))).argsort()[-EMULATOR.points :]  # in proportion to the likelihood
            t, value = t[drawn], value[drawn]
        return t, value


def most_likely(
    simulate: Callable[[NDArray[np.float64]], NDArray],
    target: Target,
    blocks: Blocks,
    dim: int,
    rng: np.random.Generator,
    num_events: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A point (p,) of the unit cube where the target is about most likely, and how near in each coordinate (p,).

    `simulate` takes parameters (n, p) to events (n, d), and is asked for `num_events` in each round.
    """
    low, high, n = np.zeros(dim), np.ones(dim), target.num_events
    # A feature is in blocks of its own and of pairs, and counts once.
    counts = n * target.mean[: blocks.size] * len(blocks.summary.edges) / len(blocks.starts)
    u, bins = np.empty((0, dim)), np.empty((0, len(blocks.starts)), np.int32)
    best = points = u
    for _ in range(EMULATOR.rounds):
        fresh = low + rng.random((num_events, dim)) * (high - low)
        u, bins = np.vstack([u, fresh]), np.vstack([bins, blocks.bins(simulate(fresh))])
        inside = ((u >= low) & (u <= high)).all(axis=1)
        network = Network(2 * (u[inside] - low) / (high - low) - 1, bins[inside], blocks, rng)
        t, value = network.followed(counts / (1 + EMULATOR.learnt * n / inside.sum()), rng)
        points, best = (low + (each + 1) / 2 * (high - low) for each in (t, t[value.argmax()]))
        margin = np.maximum(EMULATOR.margin * points.std(axis=0), EMULATOR.least)
        low = np.maximum(np.minimum(points.min(axis=0), best - margin), 0)
        high = np.minimum(np.maximum(points.max(axis=0), best + margin), 1)
    return best, points.std(axis=0)
