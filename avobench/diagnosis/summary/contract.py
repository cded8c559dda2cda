"""What a summary is: a vector of fixed length for each event, so that a set of events has a mean and a covariance."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray


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
        """About how far each event's vector went, as a variance in units of that of one event: (n, d) twice -> (n,)."""

    @abstractmethod
    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        """Covariance of the vectors of events (n, d) -> (K, K)."""

    @abstractmethod
    def alike(self, length: float) -> NDArray[np.float64]:
        """How alike parts of the vector are that lie close to each other: (K, K), 1 on the diagonal.

        Squared-exponential with `length` as a share of the range of a feature, told in bins; parts of different
        features have nothing in common.
        """


def close(bins: int, length: float) -> NDArray[np.float64]:
    """Squared-exponential correlation of so many bins side by side: (bins, bins)."""
    at = np.arange(bins) / bins
    return np.exp(-0.5 * ((at[:, None] - at) / length) ** 2)
