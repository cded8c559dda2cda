"""The summary of events by published tables: the values that they give, in the tables' own bins."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from avobench.diagnosis.summary.bins import Shown, Span, Summary, View
from avobench.tables.comparison import Reduced
from avobench.tables.table import Table, Tables

EMPTY = 1e-3
"""Entries in a normalised table, as a share of those of the reference, below which nothing is known of its shape."""


@dataclass(frozen=True, eq=False)
class TableSummary(Summary):
    """The entries of an event in the bins of published tables, of whose mean the values are a function.

    Those of a normalised table are ratios, so that the mean over events is compared by `mean`, and an expansion of it
    by `linear`.
    """

    tables: Tables
    simulated: Reduced
    """The entries of a simulated event near the fit."""
    worth: float = 1.0
    """Simulated events that would have, on average over what is fitted, the errors of the tables."""

    @cached_property
    def size(self) -> int:
        return len(self.simulated.mean)

    def values(self, entries: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values that mean entries give: (..., K) -> (..., K)."""
        return self.tables.predict(self._filled(entries))

    def linear(self, terms: NDArray[np.float64]) -> NDArray[np.float64]:
        here = self._filled(terms[0])
        values = self.tables.predict(here)
        return np.vstack([values, terms[1:] @ self.tables.slopes(here, values).T])

    def _filled(self, entries: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean entries (..., K) with some more in all bins of a normalised table that has hardly any."""
        filled = entries.copy()
        for table, part in self._each:
            if table.normalised:
                lacking = EMPTY * self.simulated.mean[part].sum() - entries[..., part].sum(axis=-1, keepdims=True)
                filled[..., part] += np.maximum(lacking, 0) / len(table.values)
        return filled

    @property
    def _each(self) -> Iterator[tuple[Table, slice]]:
        return zip(self.tables, self.tables.parts, strict=True)

    @cached_property
    def _near(self) -> NDArray[np.float64]:
        """What an entry adds to the values near the fit: (K, K)."""
        return self.tables.slopes(self.simulated.mean, self.values(self.simulated.mean))

    def mean(self, x: NDArray, pieces: int = 1) -> NDArray[np.float64]:
        n = len(x) // pieces
        sums = csr_array((np.full(n * pieces, 1 / n), np.arange(n * pieces), np.arange(0, n * pieces + 1, n)))
        return self.values((sums @ self.tables.entries(x)).toarray())

    def moments(self, x: NDArray, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return (self.tables.entries(x).T @ weights).T

    def project(self, x: NDArray, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.tables.entries(x) @ (self._near.T @ direction)

    def moved(self, before: NDArray, after: NDArray) -> NDArray[np.float64]:
        a, b = self.tables.entries(before), self.tables.entries(after)
        variance = np.diag(Reduced.of(self.tables, before).covariance)
        varying = variance > 0
        return ((a - b)[:, varying] ** 2) @ (1 / variance[varying]) / max(varying.sum(), 1)

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        return self._near @ Reduced.of(self.tables, x).covariance @ self._near.T

    def model_covariance(self, x: NDArray, num_events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """That of the tables, whose errors are as published; counts scatter as the model expects."""
        return self.worth * Reduced.of(self.tables, x).errors_of(self.tables), np.zeros(self.size)

    def chi_squared_variance(self, rank: int, num_events: int) -> float:
        """The variance of a chi-squared of so many degrees of freedom, more than a Gaussian's where counts are few."""
        counts = [np.maximum(t.values * t.widths, 1) for t in self.tables if t.covariance is None]
        return 2 * rank + sum(float((self.worth / num_events / each).sum()) for each in counts)

    def view(self, x: NDArray) -> View:
        spans, unit = [], []
        for table, part in self._each:
            spans.append(
                Span(table.name if table.of else table.feature, part.start, table.drawn, table.name, table.unit)
            )
            unit.append(table.widths / table.scale)
        values, scale = self.tables.values, np.concatenate(unit)
        at_least_one = np.maximum(values, np.concatenate([1 / table.widths for table in self.tables]))
        errors = np.sqrt(np.diag(self.simulated.errors_of(self.tables, at_least_one)))
        return View(spans, shown=Shown(values * scale, errors * scale, scale))
