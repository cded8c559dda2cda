"""The summary of events with features: shares of bins whose edges follow the data, and how features go together."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from avobench.diagnosis.settings import SUMMARY, TEST
from avobench.tasks.errors import UsageError

MANY = 3
"""Features from which it is asked what all have in common: two have no more than their product."""


@dataclass(frozen=True)
class Span:
    """Bins of a summary that lie side by side."""

    feature: int | str
    """The column that they are of; of images rows, columns or hits."""
    start: int
    """The position of the first one in the summary."""
    ends: NDArray[np.float64]
    """The ends of the bins, one more than there are."""
    name: str = ""
    """What a published table is called, whose bins they are."""
    unit: str = ""
    """Of its edges."""

    @property
    def of_missing(self) -> bool:
        """Whether it is the one bin of events that lack the feature, whose ends are NaN."""
        return bool(np.isnan(self.ends[0]))


class Shown(NamedTuple):
    """What a figure shows of the measurement in place of the shares of bins that were fitted."""

    values: NDArray[np.float64]
    """(K,), as the next one."""
    errors: NDArray[np.float64]
    unit: NDArray[np.float64]
    """What the numbers of the summary are multiplied by to be entries per event (K,), as the values are."""


@dataclass(frozen=True)
class View:
    """What can be shown of events by their summary."""

    spans: list[Span]
    """The features; of images rows and columns, counted from 0, and hits."""
    cells: NDArray[np.float64] | None = None
    """The mean of each cell of images (rows, columns)."""
    cell_errors: NDArray[np.float64] | None = None
    """The standard error of each."""
    shown: Shown | None = None


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

    def linear(self, terms: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is compared, by a linear expansion of the mean vector: terms (b, K), the constant first -> (b, K).

        The vector itself, unless a summary compares a function of its mean.
        """
        return terms

    def model_covariance(self, x: NDArray, num_events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The covariance that a model predicts for one event of so many measured, from events x (n, d) of it: (K, K).

        Where it makes none, but some were measured, they scatter as if it were to make one; what that adds to each
        variance is the second return value (K,).
        """
        cov = self.covariance(x)
        lacking = np.maximum(1 / num_events - np.diag(cov), 0)
        return cov + np.diag(lacking), lacking

    @abstractmethod
    def view(self, x: NDArray) -> View:
        """What can be shown of events (n, d), which say where the outermost bins end."""


@dataclass(frozen=True)
class Bins(Summary):
    """Which bin of each feature, and of some pairs of features, an event falls in, and how its features go together.

    `edges` are inner edges, one array a feature: k of them make k + 1 bins, open at both ends. The last edge of a
    feature that may be missing is infinite: NaN, which is sorted behind it, has a bin of its own. `coarse` are those of
    the `pairs`. Each bin of a feature has a score, its rank in units of their standard deviation. The mean product of
    two features' scores is their rank correlation (C. Spearman, Am. J. Psychol. 15 (1904) 72); those of the pairs in
    `products` follow the bins. With three features or more two numbers are last that tell what all have in common: the
    square of the sum of the scores, and that of the sum of their squares. The first is left out where all pairs have a
    product, which say it already.
    """

    edges: tuple[NDArray[np.float64], ...]
    coarse: tuple[NDArray[np.float64], ...] = ()
    pairs: tuple[tuple[int, int], ...] = ()
    scores: tuple[NDArray[np.float64], ...] = ()
    products: tuple[tuple[int, int], ...] = ()

    @cached_property
    def blocks(self) -> list[tuple[tuple[int, ...], int]]:
        """(features, number of bins) of each block of bins of the vector, in order."""
        single = [((j,), len(e) + 1) for j, e in enumerate(self.edges)]
        return single + [((i, j), (len(self.coarse[i]) + 1) * (len(self.coarse[j]) + 1)) for i, j in self.pairs]

    @cached_property
    def num_bins(self) -> int:
        """Bins in the vector; what tells how features go together follows them."""
        return sum(bins for _, bins in self.blocks)

    @property
    def left_out(self) -> int:
        """Pairs of features that vary and have no product."""
        varies = sum(len(e) > 0 for e in self.edges)
        return varies * (varies - 1) // 2 - len(self.products) if self.scores else 0

    @cached_property
    def size(self) -> int:
        return self.num_bins + len(self.products) + len(self._common)

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
        n, indices = len(x) // pieces, self.indices(x)
        cells = indices + self.size * np.repeat(np.arange(pieces), n)[:, None]
        mean = np.bincount(cells.ravel(), minlength=self.size * pieces).reshape(pieces, self.size) / n
        if self.size > self.num_bins:
            scores = self._scores_of(indices).reshape(pieces, n, -1)
            first, second = self._sides
            end = self.num_bins + len(first)
            mean[:, self.num_bins : end] = (scores.transpose(0, 2, 1) @ scores)[:, first, second] / n
            for k, square in enumerate(self._common, end):
                mean[:, k] = square(scores).mean(axis=1)
        return mean

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        indices = self.indices(x)
        sums = np.zeros((weights.shape[1], self.size))
        sums[:, : self.num_bins] = (self._rows(indices).T @ weights).T
        for some, together in self._together(indices):
            sums[:, self.num_bins :] += weights[some].T @ together
        return sums

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        indices = self.indices(x)
        along = self._rows(indices) @ direction[: self.num_bins]
        for some, together in self._together(indices):
            along[some] += together @ direction[self.num_bins :]
        return along

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        return 2 * (self.indices(before) != self.indices(after)).mean(axis=1)

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        indices, b = self.indices(x), self.num_bins
        columns, lengths = np.ascontiguousarray(indices.T), [bins for _, bins in self.blocks]
        starts = np.cumsum([0, *lengths[:-1]])
        second = np.zeros((self.size, self.size))
        for i, j in combinations(range(len(columns)), 2):
            (a, c), (m, n) = (starts[i], starts[j]), (lengths[i], lengths[j])
            cells = np.bincount((columns[i] - a) * n + (columns[j] - c), minlength=m * n)
            second[a : a + m, c : c + n] = cells.reshape(m, n)
        for some, together in self._together(indices):
            second[:b, b:] += self._rows(indices[some]).T @ together
            second[b:, b:] += np.triu(together.T @ together)
        mean = self.mean(x)[0]
        second[range(b), range(b)] = len(x) * mean[:b]
        second += np.triu(second, 1).T
        second /= len(x)
        second -= np.outer(mean, mean)
        return second

    def directions(self) -> list[tuple[tuple[int, ...], NDArray[np.float64]]]:
        """Combinations (K,) of the vector that tell how features go together, and which features each is of.

        The product of each pair and, with three features or more, four of all of them: the sum of the scores, that of
        their squares, and the square of each. A gain that all share moves or spreads every feature by little, or both
        by another amount in every event, and the sum shows it.
        """
        directions = []
        for k, pair in enumerate(self.products, self.num_bins):
            directions.append((pair, np.eye(1, self.size, k)[0]))
        if len(self.edges) < MANY or not self.scores:
            return directions
        everything, scores = tuple(range(len(self.edges))), np.concatenate(self.scores)
        for weights in (scores, scores**2):
            directions.append((everything, np.r_[weights, np.zeros(self.size - len(weights))]))
        fluctuating = np.eye(2, self.size, self.size - 2)
        if len(self._common) == 1:  # the square of a sum is the sum of the squares and of twice the products
            products = np.arange(self.size)[self.num_bins : self.num_bins + len(self.products)]
            fluctuating[0, self.size - 2] = 0
            fluctuating[0, products], fluctuating[0, : len(scores)] = 2, scores**2
        return directions + [(everything, row) for row in fluctuating]

    @cached_property
    def _sides(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The first and the second feature of each product."""
        first, second = np.array(self.products, int).reshape(-1, 2).T
        return first, second

    @cached_property
    def _common(self) -> list[Callable[[NDArray[np.float64]], NDArray[np.float64]]]:
        """What all features have in common, of scores (..., d) -> (...)."""
        d = len(self.edges)
        if d < MANY or not self.scores:
            return []
        spread = [lambda s: ((s**2).sum(axis=-1) - d) ** 2 / (2 * d)]
        return spread if len(self.products) == d * (d - 1) // 2 else [lambda s: s.sum(axis=-1) ** 2 / d, *spread]

    def _scores_of(self, indices: NDArray[np.int32]) -> NDArray[np.float64]:
        """The scores of events by the positions of their bins: (n, blocks) -> (n, d)."""
        return np.concatenate(self.scores)[indices[:, : len(self.edges)]]

    def _together(self, indices: NDArray[np.int32]) -> Iterator[tuple[slice, NDArray[np.float64]]]:
        """The part of the vectors that follows the bins, of some events at a time: their rows, and (m, K - bins)."""
        if self.size == self.num_bins:
            return
        step = max(SUMMARY.numbers_at_once // (self.size - self.num_bins), 1)
        first, second = self._sides
        for start in range(0, len(indices), step):
            some = slice(start, start + step)
            scores = self._scores_of(indices[some])
            common = [square(scores)[:, None] for square in self._common]
            yield some, np.hstack([scores[:, first] * scores[:, second], *common])

    def _rows(self, indices: NDArray[np.int32]) -> csr_array:
        """The bins of the vectors: (n, blocks) -> (n, bins)."""
        pointers = np.arange(0, indices.size + 1, indices.shape[1], dtype=np.int32)
        return csr_array((np.ones(indices.size), indices.ravel(), pointers), shape=(len(indices), self.num_bins))

    def view(self, x: NDArray) -> View:
        ends: list[tuple[int | str, NDArray[np.float64]]] = []
        for j, edges in enumerate(self.edges):
            inner = edges[np.isfinite(edges)]
            ends.append((j, closed(inner, x[~np.isnan(x[:, j]), j])))
            if len(inner) < len(edges):
                ends.append((j, np.full(2, np.nan)))
        return View(spans_of(ends))


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

    One feature: about 50 bins, 80 of counts, and one for each value where there are few counts. Several: about 12 bins
    a feature, the rank correlation of each pair, and 4 x 4 bins a pair where there are at least 2 000 events. In a
    feature's tails they are finer. Few events make fewer bins. Counts are never split, the rare merged.

    Several features have one number for `SUMMARY.events_a_number` events at most, since of fewer events a covariance of
    them tells nothing; and `SUMMARY.most_numbers`, since it has the square of as many. Of many features, correlations
    and then bins are left to pairs that are close in the order of the features, as sensors side by side are, and which
    effects of the catalogue act on. To keep the pairs that differ most would find a difference where there is none.
    Raises UsageError where there are too many features for that.
    """
    n, d = x.shape
    if 8 * d > SUMMARY.most_numbers:  # four bins of each take half of them
        raise UsageError(
            f"a diagnosis compares at most {SUMMARY.most_numbers // 8} features, the events have {d}: leave some out"
        )
    numbers = min(n // SUMMARY.events_a_number, SUMMARY.most_numbers)
    if d > 1 and 4 * d > numbers:
        least = int(np.ceil(4 * d * SUMMARY.events_a_number / (1 - TEST.held_out_share)))
        raise UsageError(
            f"a diagnosis of {d} features needs about {least} events: leave features out, or measure more events"
        )
    one = np.issubdtype(x.dtype, np.integer) and d == 1
    most = min(max(n // 25, 4), 80 if one else 50) if d == 1 else min(max(n // 100, 4), 12, max(numbers // (2 * d), 4))
    if one and len(np.unique(x)) <= SUMMARY.few_counts:
        return Bins((inner_edges(x[:, 0], simulated[:, 0], len(x), least=SUMMARY.least_of_few),))
    edges = tuple(inner_edges(x[:, j], simulated[:, j], most, growth=2 if d == 1 else 8) for j in range(d))
    if d == 1:
        return Bins(edges)
    if sum(len(e) + 2 for e in edges) > numbers:  # no room for fine tails beside the product of each with the next
        edges = tuple(inner_edges(x[:, j], simulated[:, j], most) for j in range(d))
    scores = tuple(ranks(x[:, j], simulated[:, j], e) for j, e in enumerate(edges))
    varies = [j for j in range(d) if len(edges[j])]
    near = sorted(combinations(varies, 2), key=lambda pair: (pair[1] - pair[0], pair))
    room = numbers - sum(len(e) + 1 for e in edges) - 2  # what all have in common
    products = tuple(near[: max(room, 0)])
    coarse = tuple(inner_edges(x[:, j], simulated[:, j], 4) for j in range(d)) if n >= SUMMARY.paired else ()
    pairs = []
    room -= len(products)
    for i, j in near if coarse else ():
        room -= (len(coarse[i]) + 1) * (len(coarse[j]) + 1)
        if room < 0:
            break
        pairs.append((i, j))
    return Bins(edges, coarse, tuple(sorted(pairs)), scores, tuple(sorted(products)))


def ranks(x: NDArray, simulated: NDArray, edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean rank of the events in each bin of a feature, both sets in equal parts: (k + 1,).

    It is scaled to a mean of 0 and a variance of 1, and 0 where there is but one bin.
    """
    share = sum(np.bincount(bin_of(each, edges), minlength=len(edges) + 1) / len(each) for each in (x, simulated)) / 2
    rank = np.cumsum(share) - share / 2
    rank -= share @ rank
    spread = np.sqrt(share @ rank**2)
    return rank / spread if len(edges) else 0 * rank


def inner_edges(
    x: NDArray, simulated: NDArray, most: int, *, growth: float = np.inf, least: int = SUMMARY.least_in_bin
) -> NDArray[np.float64]:
    """Inner edges of at most `most` bins for one feature, from a mixture of both sets in equal parts.

    From the `least` events at both ends, each bin makes what lies outside at most `growth` times as much: what lies
    beyond the bulk tells effects apart though it is rare. A last edge at infinity sets apart what is missing.
    """
    if np.isnan(x).any() or np.isnan(simulated).any():
        recorded = [each[~np.isnan(each)] for each in (x, simulated)]
        return np.append(inner_edges(*recorded, most, growth=growth, least=least), np.inf)
    values = np.concatenate([x, simulated]).astype(float)
    weights = np.concatenate([np.full(len(x), 0.5), np.full(len(simulated), 0.5 * len(x) / max(len(simulated), 1))])
    unique, inverse = np.unique(values, return_inverse=True)
    cumulated = np.cumsum(np.bincount(inverse, weights))
    total = cumulated[-1]
    need = max(len(x) / most, least) if most < len(unique) else least
    edges, last, at = [], 0.0, -1
    while True:
        more = min((growth - 1) * last, (1 - 1 / growth) * (total - last)) if growth < np.inf else need
        wanted = min(need, max(more, least))
        at = max(int(np.searchsorted(cumulated, last + wanted)), at + 1)
        if at >= len(unique) - 1 or total - cumulated[at] < least:
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
