"""The summary of a test of binned events: bins of features and of pairs of features, and sums over images."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task


class Bins:
    """What the test sees of events, made from measured ones: bins of each feature and each pair of them.

    Of an image the sums of rows, columns and blocks of 4 x 4, and bins of its total.
    """

    def __init__(self, task: Task, x: NDArray) -> None:
        self.shape = task.event_shape
        features = self._features(x)
        fine = 30 if features.shape[1] == 1 else 12
        self.fine, self.coarse = ([_edges(feature, k) for feature in features.T] for k in (fine, 4))

    def mean(self, x: NDArray) -> NDArray[np.float64]:
        """Share of the events in each bin, after the mean sums: (n, d) -> (k,)."""
        counts = [np.bincount(index, minlength=size) for index, size in self._indices(x)]
        return np.concatenate([self._sums(x).mean(axis=0), *(count / len(x) for count in counts)])

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        """The covariance of the sums and bins of one event: (n, d) -> (k, k)."""
        return np.cov(np.hstack([self._sums(x), *(np.eye(size)[index] for index, size in self._indices(x))]).T)

    def _features(self, x: NDArray) -> NDArray:
        return x.sum(axis=1, keepdims=True) if self.shape else x

    def _sums(self, x: NDArray) -> NDArray[np.float64]:
        if not self.shape:
            return np.empty((len(x), 0))
        rows, columns = self.shape
        image = x.reshape(-1, rows, columns).astype(float)
        blocks = image.reshape(-1, rows // 4, 4, columns // 4, 4).sum(axis=(2, 4))
        return np.hstack([image.sum(axis=2), image.sum(axis=1), blocks.reshape(len(x), -1)])

    def _indices(self, x: NDArray) -> list[tuple[NDArray[np.intp], int]]:
        """The bin of each event, (n,), and the number of bins, for each feature and each pair."""

        def bins(feature: int, edges: list[NDArray]) -> tuple[NDArray[np.intp], int]:
            return np.searchsorted(edges[feature], features[:, feature], side="right"), len(edges[feature]) + 1

        features = self._features(x)
        indices = [bins(i, self.fine) for i in range(features.shape[1])]
        for i, j in combinations(range(features.shape[1]), 2):
            (first, n), (second, m) = bins(i, self.coarse), bins(j, self.coarse)
            indices.append((first * m + second, n * m))
        return indices


def _edges(feature: NDArray, num_bins: int) -> NDArray:
    """The edges of bins with equal shares of the events. If the values are counts, each whole number has a bin."""
    if np.issubdtype(feature.dtype, np.integer):
        low, high = np.quantile(feature, [0.005, 0.995]).round()
        return np.arange(low, high + 2)
    return np.unique(np.quantile(feature, np.arange(1, num_bins) / num_bins))
