"""What is fitted: the mean summary of the measured events, in coordinates where its covariance is 1."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.settings import SUMMARY
from avobench.diagnosis.summary.bins import Summary, bins_of
from avobench.diagnosis.summary.pixels import pixels_of
from avobench.tasks import Task


class Vectors(Protocol):
    """A vector s(x) for each event, of which a surrogate gives the mean."""

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """weights^T s(x): (n, d), (n, b) -> (b, K)."""

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        """The change of each event's vector, as a variance in units of that of one event: (n, d) twice -> (n,)."""


@dataclass(frozen=True)
class Target:
    """What is fitted: the mean summary of N events, in coordinates where its covariance is 1."""

    summary: Summary
    mean: NDArray[np.float64]
    """(K,)"""
    num_events: int
    cov: NDArray[np.float64]
    """The covariance of the summary of one event (K, K)."""
    whitening: NDArray[np.float64]
    """(K, r), whitening^T cov whitening = 1."""

    @classmethod
    def of(cls, summary: Summary, mean: NDArray[np.float64], num_events: int, cov: NDArray[np.float64]) -> "Target":
        return cls(summary, mean, num_events, cov, whitening(cov))

    @property
    def rank(self) -> int:
        return self.whitening.shape[1]

    def whiten(self, mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """A mean in standard errors of the measured one: (..., K) -> (..., r)."""
        return np.sqrt(self.num_events) * (mean @ self.whitening)

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """weights^T s(x): (n, d), (n, b) -> (b, K)."""
        return self.summary.moments(x, weights)

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        """How far each event's vector went, as a variance in units of that of one event: (n, d) twice -> (n,).

        The summary says which events change; how much that is where its covariance is 1 is taken from some of them.
        """
        share = self.summary.moved(before, after)
        went = np.flatnonzero(share)
        some = went[:: max(len(went) // SUMMARY.compared_moves, 1)]
        if not len(some) or self.rank == 0:
            return share
        before, after = (self.summary.project(x[some], self.whitening) for x in (before, after))
        return share * ((before - after) ** 2).sum() / (self.rank * share[some].sum())


def whitening(cov: NDArray[np.float64]) -> NDArray[np.float64]:
    """W (K, r) with W^T cov W = 1, r the rank of cov: one less for each block of bins that sums to one."""
    filled = np.flatnonzero(np.diag(cov) > 0)  # a cell of a pair may be empty
    scale = np.sqrt(np.diag(cov)[filled])
    values, vectors = np.linalg.eigh(cov[np.ix_(filled, filled)] / np.outer(scale, scale))
    w = np.zeros((len(cov), len(filled)))
    w[filled] = vectors / scale[:, None]
    kept = values > SUMMARY.rank_tolerance * values.max(initial=0)  # what is less is rounding
    return w[:, kept] / np.sqrt(values[kept])


def summary_of(task: Task, x: NDArray, simulated: NDArray) -> Summary:
    """The summary that suits these measured and simulated events."""
    return pixels_of(x, simulated, task.event_shape) if task.event_shape else bins_of(x, simulated)


def target_of(x: NDArray, summary: Summary, simulated: NDArray) -> Target:
    """The target of measured events x (N, d), whitened with their covariance and a little of the simulated."""
    cov = (1 - SUMMARY.mixed_in) * summary.covariance(x) + SUMMARY.mixed_in * summary.covariance(simulated)
    return Target.of(summary, summary.mean(x)[0], len(x), cov)
