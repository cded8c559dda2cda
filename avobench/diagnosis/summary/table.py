"""The summary of events by published tables: the values that they give, in the tables' own bins."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from avobench.diagnosis.settings import SUMMARY
from avobench.diagnosis.summary.bins import Summary, View, close, spans_of
from avobench.diagnosis.summary.target import Target
from avobench.tables.comparison import Reduced, whitening
from avobench.tables.table import Tables


@dataclass(frozen=True, eq=False)
class TableSummary(Summary):
    """What an event adds to the values of published tables, so that the mean over events is what they compare with.

    A normalised table is no mean: its values are ratios. Its part of the vector is v + J n, with n the entries of an
    event and J the derivative of the ratios where they are the published v. Its mean is v just where the ratios are v,
    and is close to the ratios nearby.
    """

    tables: Tables
    simulated: NDArray[np.float64]
    """Mean entries of a simulated event (K,): how many a normalised table has in all."""

    @cached_property
    def size(self) -> int:
        return len(self.simulated)

    @cached_property
    def _slopes(self) -> NDArray[np.float64]:
        """What an entry adds: (K, K)."""
        return self.tables.slopes(self.simulated, self.tables.values)

    @cached_property
    def _constant(self) -> NDArray[np.float64]:
        """The values of normalised tables, and 0 of others: (K,)."""
        return np.concatenate([table.values * table.normalised for table in self.tables])

    def _vectors(self, x: NDArray) -> NDArray[np.float64]:
        return self.tables.entries(x) @ self._slopes.T + self._constant

    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        n = len(x) // pieces
        sums = csr_array((np.full(n * pieces, 1 / n), np.arange(n * pieces), np.arange(0, n * pieces + 1, n)))
        return (sums @ self.tables.entries(x)).toarray() @ self._slopes.T + self._constant

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return (self.tables.entries(x).T @ weights).T @ self._slopes.T + np.outer(weights.sum(axis=0), self._constant)

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.tables.entries(x) @ (self._slopes.T @ direction) + self._constant @ direction

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        a, b = self.tables.entries(before), self.tables.entries(after)
        variance = np.diag(Reduced.of(self.tables, before).covariance)
        seen = variance > 0
        return ((a - b)[:, seen] ** 2) @ (1 / variance[seen]) / seen.sum()

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        return self._slopes @ Reduced.of(self.tables, x).covariance @ self._slopes.T

    def view(self, x: NDArray) -> View:
        return View(spans_of([(table.name or table.feature, table.edges) for table in self.tables]))

    def alike(self, length: float) -> NDArray[np.float64]:
        return block_diag(*(close(len(table.values), length) for table in self.tables))


def table_target(tables: Tables, simulated: NDArray) -> Target:
    """The target of published tables, with the bins' scales from simulated events (n, d) near the fit.

    Its covariance is that of the tables, whatever number of events it is said to be of; that number is the one at which
    simulated events would have, on average over what is fitted, the errors of the tables. So noise of simulation, which
    is told in the number of events, comes out right on average. Poisson errors are those of counts that are mostly the
    measured ones and a little the simulated.
    """
    reduced = Reduced.of(tables, simulated)
    expected = (1 - SUMMARY.mixed_in) * tables.values + SUMMARY.mixed_in * tables.predict(reduced.mean)
    cov = tables.covariance_of(expected, reduced.num_events)
    summary = TableSummary(tables, reduced.mean)
    w = whitening(cov)
    one_event = np.einsum("kr,kl,lr->", w, summary.covariance(simulated), w) / w.shape[1]
    num_events = max(int(np.rint(one_event)), 1)
    return Target.of(summary, tables.values, num_events, num_events * cov)
