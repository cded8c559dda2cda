"""The summary of events with features: shares of bins whose edges follow the data."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import combinations, zip_longest

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from avobench.diagnosis.settings import SUMMARY


@dataclass(frozen=True)
class Span:
    """Bins of a summary that lie side by side."""

    feature: int | str
    """The column that they are of; of images rows, columns or hits."""
    start: int
    """The position of the first one in the summary."""
    ends: NDArray[np.float64]
    """The ends of the bins, one more than there are."""


@dataclass(frozen=True)
class View:
    """What can be shown of events by their summary."""

    spans: list[Span]
    """The features; of images rows and columns, counted from 0, and hits."""
    cells: NDArray[np.float64] | None = None
    """The mean of each cell of images (rows, columns)."""
    cell_errors: NDArray[np.float64] | None = None
    """The standard error of each."""


def spans_of(ends: list[tuple[int | str, NDArray[np.float64]]]) -> list[Span]:
    """The spans of a summary that begins with the features of these ends."""
    starts = np.cumsum([0, *(len(each) - 1 for _, each in ends)]).tolist()
    return [Span(feature, start, each) for (feature, each), start in zip(ends, starts, strict=False)]


class Summary(ABC):
    """A vector s(x) of fixed length K for each event; a set of events is summarised by its mean."""

    size: int

    @abstractmethod
    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        """Mean vector of each of so many equal, consecutive pieces of the events: (n, d) -> (pieces, K)."""

    @abstractmethod
    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """weights^T s(x): (n, d), (n, b) -> (b, K)."""

    @abstractmethod
    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """s(x) along a direction (K,), or several (K, r): (n, d) -> (n,), (n, r)."""

    @abstractmethod
    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        """The rough change of each event's vector, as a variance in units of that of an event: (n, d) twice -> (n,)."""

    @abstractmethod
    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        """Covariance of the vectors of events (n, d) -> (K, K)."""

    @abstractmethod
    def view(self, x: NDArray) -> View:
        """What can be shown of events (n, d), which say where the outermost bins end."""

    @abstractmethod
    def alike(self, length: float) -> NDArray[np.float64]:
        """The correlation of parts of the vector that lie close to each other: (K, K), 1 on the diagonal.

        Squared-exponential with `length` as a share of the range of a feature, told in bins; parts of different
        features have nothing in common.
        """


def close(bins: int, length: float) -> NDArray[np.float64]:
    """Squared-exponential correlation of so many bins side by side: (bins, bins)."""
    at = np.arange(bins) / bins
    return np.exp(-0.5 * ((at[:, None] - at) / length) ** 2)


@dataclass(frozen=True)
class Bins(Summary):
    """Which bin of each feature, and of each pair of features, an event falls in.

    `edges` are inner edges, one array a feature: k of them make k + 1 bins, open at both ends. `coarse` are those of
    the pairs; without them there are no pairs.
    """

    edges: tuple[NDArray[np.float64], ...]
    coarse: tuple[NDArray[np.float64], ...] = ()

    @cached_property
    def blocks(self) -> list[tuple[tuple[int, ...], int]]:
        """(features, number of bins) of each block of the vector, in order."""
        single = [((j,), len(e) + 1) for j, e in enumerate(self.edges)]
        pairs = combinations(range(len(self.coarse)), 2)
        return single + [((i, j), (len(self.coarse[i]) + 1) * (len(self.coarse[j]) + 1)) for i, j in pairs]

    @cached_property
    def size(self) -> int:
        return sum(bins for _, bins in self.blocks)

    @cached_property
    def _merged(self) -> list[NDArray[np.float64]]:
        """Edges of both kinds of bins, of each feature, so that each event is looked up once."""
        return [np.union1d(e, c) for e, c in zip_longest(self.edges, self.coarse, fillvalue=())]

    @cached_property
    def _fine(self) -> list[NDArray[np.intp]]:
        """The bin that each bin between merged edges lies in."""
        return [_parts(e, merged) for e, merged in zip(self.edges, self._merged, strict=True)]

    @cached_property
    def _wide(self) -> list[NDArray[np.intp]]:
        """The coarse bin that each bin between merged edges lies in."""
        return [_parts(e, merged) for e, merged in zip(self.coarse, self._merged, strict=False)]

    def indices(self, x: NDArray) -> NDArray[np.int32]:
        """The position of each event's bin in the vector, for every block: (n, d) -> (n, blocks)."""
        merged = [bin_of(column, e) for e, column in zip(self._merged, np.ascontiguousarray(x.T), strict=True)]
        fine = [table[at] for table, at in zip(self._fine, merged, strict=True)]
        wide = [table[at] for table, at in zip(self._wide, merged, strict=False)]
        indices, start = np.empty((len(x), len(self.blocks)), np.int32), 0
        for k, (features, bins) in enumerate(self.blocks):
            a, b = features[0], features[-1]
            inside = fine[a] if len(features) == 1 else wide[a] * (len(self.coarse[b]) + 1) + wide[b]
            indices[:, k] = inside + start
            start += bins
        return indices

    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        n = len(x) // pieces
        cells = self.indices(x) + self.size * np.repeat(np.arange(pieces), n)[:, None]
        return np.bincount(cells.ravel(), minlength=self.size * pieces).reshape(pieces, self.size) / n

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        indices = self.indices(x)
        pointers = np.arange(0, indices.size + 1, indices.shape[1], dtype=np.int32)
        rows = csr_array((np.ones(indices.size), indices.ravel(), pointers), shape=(len(x), self.size))
        return (rows.T @ weights).T

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return direction[self.indices(x)].sum(axis=1)

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        return 2 * (self.indices(before) != self.indices(after)).mean(axis=1)

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        columns, lengths = np.ascontiguousarray(self.indices(x).T), [bins for _, bins in self.blocks]
        starts = np.cumsum([0, *lengths[:-1]])
        second = np.zeros((self.size, self.size))
        for i, j in combinations(range(len(columns)), 2):
            (a, b), (m, n) = (starts[i], starts[j]), (lengths[i], lengths[j])
            cells = np.bincount((columns[i] - a) * n + (columns[j] - b), minlength=m * n)
            second[a : a + m, b : b + n] = cells.reshape(m, n)
        mean = self.mean(x)[0]
        return (second + second.T) / len(x) + np.diag(mean) - np.outer(mean, mean)

    def view(self, x: NDArray) -> View:
        return View(spans_of([(j, closed(inner, x[:, j])) for j, inner in enumerate(self.edges)]))

    def alike(self, length: float) -> NDArray[np.float64]:
        sides = [[bins] if len(f) == 1 else [len(self.coarse[j]) + 1 for j in f] for f, bins in self.blocks]
        return block_diag(*(reduce(np.kron, [close(bins, length) for bins in side]) for side in sides))


def _parts(edges: NDArray[np.float64], merged: NDArray[np.float64]) -> NDArray[np.intp]:
    """The bin between `edges` of each bin between `merged` edges (k,), which have all of `edges`: (k + 1,)."""
    return np.r_[0, np.searchsorted(edges, merged, side="right")]


def bin_of(column: NDArray, edges: NDArray[np.float64]) -> NDArray[np.intp]:
    """The number of inner edges at or below each value: (n,). Whole numbers are looked up in a table."""
    if len(edges) and np.can_cast(column.dtype, np.int64):
        low, high = int(np.ceil(edges[0])) - 1, int(np.floor(edges[-1])) + 1
        if high - low < len(column):
            table = np.searchsorted(edges, np.arange(low, high + 1), side="right")
            return table[np.clip(column.astype(np.int64, copy=False), low, high) - low]
    return np.searchsorted(edges, column, side="right")


def bins_of(x: NDArray, simulated: NDArray) -> Bins:
    """Bins that hold measured and simulated events alike, so that neither a hole nor a peak falls between edges.

    One feature: about 50 bins, 80 of counts. Several: about 12 bins a feature, and 4 x 4 a pair where there are at
    least 2 000 events. In a feature's tails they are finer. Few events make fewer bins. Counts are never split, the
    rare merged.
    """
    n, d = x.shape
    one = np.issubdtype(x.dtype, np.integer) and d == 1
    most = min(max(n // 25, 4), 80 if one else 50) if d == 1 else min(max(n // 100, 4), 12)
    edges = tuple(inner_edges(x[:, j], simulated[:, j], most, growth=2 if d == 1 else 8) for j in range(d))
    coarse = tuple(inner_edges(x[:, j], simulated[:, j], 4) for j in range(d)) if d > 1 and n >= 2000 else ()
    return Bins(edges, coarse)


def inner_edges(x: NDArray, simulated: NDArray, most: int, *, growth: float = np.inf) -> NDArray[np.float64]:
    """Inner edges of at most `most` bins for one feature, from a mixture of both sets in equal parts.

    From the fewest events at both ends, each bin makes what lies outside at most `growth` times as much: what lies
    beyond the bulk tells effects apart though it is rare.
    """
    values = np.concatenate([x, simulated]).astype(float)
    weights = np.concatenate([np.full(len(x), 0.5), np.full(len(simulated), 0.5 * len(x) / len(simulated))])
    unique, inverse = np.unique(values, return_inverse=True)
    cumulated = np.cumsum(np.bincount(inverse, weights))
    total = cumulated[-1]
    need = max(len(x) / most, SUMMARY.least_in_bin) if most < len(unique) else SUMMARY.least_in_bin
    edges, last, at = [], 0.0, -1
    while True:
        more = min((growth - 1) * last, (1 - 1 / growth) * (total - last)) if growth < np.inf else need
        wanted = min(need, max(more, SUMMARY.least_in_bin))
        at = max(int(np.searchsorted(cumulated, last + wanted)), at + 1)
        if at >= len(unique) - 1 or total - cumulated[at] < SUMMARY.least_in_bin:
            return np.array(edges)
        edges.append((unique[at] + unique[at + 1]) / 2)
        last = cumulated[at]


def closed(inner: NDArray[np.float64], values: NDArray) -> NDArray[np.float64]:
    """Edges (k + 2,) with both ends: the outermost values, or as far out as the neighbouring bin is wide.

    The latter where no measured value lies beyond the inner edges (k,), which follow simulated events as well.
    """
    low, high = float(values.min()), float(values.max())
    first, last = (inner[0], inner[-1]) if len(inner) else (high, high)
    width = np.diff(inner) if len(inner) > 1 else np.ones(1)
    low = low if low < first else first - width[0]
    high = high if high > last else last + width[-1]
    return np.concatenate([[low], inner, [high]])
