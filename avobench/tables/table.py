"""What is published: values in bins with their covariance, and which simulated events fall into which bin."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import KW_ONLY, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import block_diag
from scipy.sparse import csr_array, hstack

from avobench.tasks.arguments import numbers
from avobench.tasks.errors import UsageError, shown

FAR = 5
"""Errors by which the sum of a table may be larger than its number of events."""
ROUNDING = 1e-8
"""Share of the largest eigenvalue of a correlation matrix below which another one is rounding, of either sign."""
WHOLE = 1e-6
"""A value that is so far from a whole number is no count, however large it is."""
PRINTED = 1e-6
"""So much of the largest count may be the rounding of a density that is printed."""


@dataclass(frozen=True, eq=False)
class Table:
    """One published table: a histogram of counts, or an unfolded density with its errors.

    `edges` (K + 1,) increase, and `values` (K,) stand in the bins between them. A bin holds its lower edge, the last
    one its upper edge too. The first and the last edge may be infinite, but not of a density. A mean, such as that of
    the multiplicity, is a table of one bin with an entry a particle.

    What an event is binned by is its column `feature`, a number or a name in a DataFrame, or what `of` makes of the
    events: a function from n events to one number for each, (n,), or several, (n, k) or a list of n arrays, such as
    the momenta of all its particles. NaN is no entry.

    Without `errors` (K,) and `covariance` (K, K) the values are counts, and scatter as those of as many simulated
    events do, whose entries may go together. `density` says that values are divided by the widths of their bins.
    `num_events` is how many events the values are of: 1, the default where errors are given, if they are entries per
    event. `normalised` says that only the shape is compared: the simulated table is scaled to the sum of the values,
    and one degree of freedom is lost. That is the default for counts, whose `num_events` is not known. `unit` is that
    of the edges, if it is to be compared with what a task says of its feature.

    Raises UsageError for values below zero, for what is no number, for edges that do not increase, and for errors and
    covariances that are of the wrong size, zero or impossible. So it does for more entries than `num_events` where each
    event has one at most.
    """

    edges: NDArray[np.float64]
    values: NDArray[np.float64]
    _: KW_ONLY
    covariance: NDArray[np.float64] | None = None
    errors: NDArray[np.float64] | None = None
    feature: int | str = 0
    of: Callable[[Any], Any] | None = None
    density: bool = False
    normalised: bool = False
    num_events: float | None = None
    unit: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "edges", self._numbers("edges", self.edges, infinite=True))
        put(self, "values", self._numbers("values", self.values))
        if self.edges.ndim != 1 or self.values.shape != (len(self.edges) - 1,) or not len(self.values):
            k, wanted = self.values.size, max(self.edges.size - 1, 1)
            raise self.wrong(f"{self.edges.size} edges make {wanted} bins, but there are {k} values")
        if not (self.edges[:-1] < self.edges[1:]).all():
            raise self.wrong("edges must increase")
        if self.density and not np.isfinite(self.edges).all():
            raise self.wrong("a density has no open bins: give finite edges, or leave these bins out")
        if (self.values < 0).any():
            raise self.wrong(f"values must not be negative, got {self.values.min():g}; merge bins, or leave them out")
        if not self.values.sum() > 0:
            raise self.wrong("all values are zero")
        if self.num_events is not None and not (self.num_events > 0 and np.isfinite(self.num_events)):
            raise self.wrong(f"num_events must be positive, got {self.num_events}")
        if self.normalised and self.num_events is not None:
            raise self.wrong("only the shape of a normalised table is compared: give num_events or normalised")
        if self.errors is not None:
            put(self, "covariance", self._covariance_of_errors())
        elif self.covariance is not None:
            put(self, "covariance", checked_covariance(self.covariance, len(self.values), self.wrong))
        if self.num_events is None:
            put(self, "normalised", self.normalised or self.are_counts)
        if self.covariance is not None or self.are_counts:
            self.check_sum(np.zeros((len(self.values),) * 2) if self.covariance is None else self.covariance)

    def check_sum(self, covariance: NDArray[np.float64]) -> None:
        """Raise UsageError if there are more entries than events that have one each, by far more than errors (K, K)."""
        entries, variance = self.values @ self.widths, self.widths @ covariance @ self.widths
        if self.of is None and not self.normalised and entries > self.scale * (1 + 1e-6) + FAR * np.sqrt(abs(variance)):
            message = f"{entries:g} entries are more than num_events={self.scale:g}"
            raise self.wrong(
                f"{message}: give num_events=, normalised=True to compare the shape alone, or density=True"
            )

    def wrong(self, what: str) -> UsageError:
        """An error that names the table."""
        return UsageError(f"table {self.name or 'without a name'}: {what}")

    def _numbers(self, what: str, given: ArrayLike, **options: bool) -> NDArray[np.float64]:
        return numbers(f"table {self.name or 'without a name'}: {what}", given, **options).astype(float)

    def _covariance_of_errors(self) -> NDArray[np.float64]:
        if self.covariance is not None:
            raise self.wrong("give errors or a covariance, not both")
        errors = self._numbers("errors", self.errors)
        if errors.shape != self.values.shape:
            raise self.wrong(f"{errors.size} errors for {len(self.values)} values")
        if (errors <= 0).any():
            raise self.wrong(f"the error in bin {1 + int(np.argmin(errors))} must be positive, got {errors.min():g}")
        return np.diag(errors**2)

    @property
    def are_counts(self) -> bool:
        """True if the values are whole numbers of entries, and simulated events tell their errors."""
        counts = self.values * self.widths
        rounding = PRINTED * counts.max() if self.density else WHOLE
        return self.covariance is None and bool(np.abs(counts - np.round(counts)).max() <= rounding)

    @property
    def widths(self) -> NDArray[np.float64]:
        """What an entry is divided by in each bin: (K,)."""
        return np.diff(self.edges) if self.density else np.ones(len(self.values))

    @property
    def drawn(self) -> NDArray[np.float64]:
        """The edges (K + 1,), an open bin as wide as its neighbour."""
        finite = self.edges[np.isfinite(self.edges)]
        width = np.diff(finite) if len(finite) > 1 else np.ones(1)
        low, high = (finite[0] - width[0], finite[-1] + width[-1]) if len(finite) else (0.0, 1.0)
        return np.nan_to_num(self.edges, neginf=low, posinf=high)

    @property
    def scale(self) -> float:
        """Entries in all bins of a normalised table; of any other the number of events."""
        return float(self.values @ self.widths) if self.normalised else float(self.num_events or 1)

    def merged(self, starts: NDArray[np.intp]) -> "Table":
        """The table of counts with wider bins, which begin at these bins (k,), the first at 0."""
        if len(starts) == len(self.values):
            return self
        edges = np.append(self.edges[starts], self.edges[-1])
        widths = np.diff(edges) if self.density else 1.0
        return replace(self, edges=edges, values=np.add.reduceat(self.values * self.widths, starts) / widths)

    def entries(self, events: Any) -> csr_array:
        """How many entries each event has in each bin: (n, K). Raises UsageError for what cannot be binned."""
        try:
            n = len(events)
        except TypeError as error:
            raise self.wrong(f"events must be an array or a table, got {shown(events)}") from error
        event, values = self._binned(events, n)
        if values.dtype.kind not in "biuf":
            raise self.wrong(f"what is binned must be numbers, got {values.dtype}")
        values = values.astype(float)
        bins = np.searchsorted(self.edges, values, side="right") - 1
        bins[values == self.edges[-1]] = len(self.values) - 1
        inside = (bins >= 0) & (bins < len(self.values)) & ~np.isnan(values)
        shape = (n, len(self.values))
        return csr_array((np.ones(inside.sum()), (event[inside], bins[inside])), shape=shape)

    def _column(self, events: Any) -> NDArray:
        if isinstance(self.feature, str):
            if self.feature not in getattr(events, "columns", ()):
                raise self.wrong(f"the events have no column '{self.feature}'")
            return events[self.feature].to_numpy()
        try:
            x = np.asarray(events)
        except ValueError as error:
            raise self.wrong("the rows of the events differ in length") from error
        x = x[:, None] if x.ndim == 1 else x
        if x.ndim != 2 or x.dtype == object or not 0 <= self.feature < x.shape[1]:
            raise self.wrong(f"events with a shape of {x.shape} have no feature {self.feature}: give `feature` or `of`")
        return x[:, self.feature]

    def _binned(self, events: Any, n: int) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """The event of each entry, and its value: (m,) twice."""
        entries = self._column(events) if self.of is None else self.of(events)
        if len(entries) != n:
            raise self.wrong(f"`of` must give numbers for each event: {len(entries)} for {n} events")
        if isinstance(entries, np.ndarray) and entries.dtype != object:
            if entries.ndim > 2:
                raise self.wrong(f"`of` must give (n,), (n, k) or a list of arrays, got {entries.shape}")
            values = entries[:, None] if entries.ndim == 1 else entries
            return np.repeat(np.arange(n), values.shape[1]), values.ravel()
        parts = [np.ravel(part) for part in entries]
        values = np.concatenate(parts) if parts else np.empty(0)
        return np.repeat(np.arange(n), [len(part) for part in parts]), values


class Tables:
    """Published tables that are compared together, with their joint `covariance` if it is known.

    That is of all values, table after table, (K, K), in place of the tables' own errors; without it the tables are
    taken as independent. `parts` are where the bins of each table are among all. Raises UsageError if the covariance
    has the wrong size or is not positive, or if a table has neither errors nor counts.
    """

    def __init__(self, tables: Iterable[Table], *, covariance: ArrayLike | None = None) -> None:
        self.tables = tuple(tables)
        if not self.tables:
            raise UsageError("there are no tables: give one at least")
        ends = np.cumsum([0, *(len(table.values) for table in self.tables)]).tolist()
        self.parts = tuple(slice(a, b) for a, b in pairwise(ends))
        self.covariance = None if covariance is None else checked_covariance(covariance, ends[-1], UsageError)
        for table, part in zip(self.tables, self.parts, strict=True):
            if self.covariance is not None:
                table.check_sum(self.covariance[part, part])
            if covariance is None and table.covariance is None and not table.are_counts:
                raise table.wrong(
                    "the values are fractions, so no counts: give their errors=, for sums of weights the root of the "
                    "sum of squared weights, or their covariance="
                )

    @classmethod
    def of(cls, tables: "Table | Tables | Iterable[Table]") -> "Tables":
        """Tables from one, from several, or as they are."""
        if isinstance(tables, Tables):
            return tables
        return cls([tables] if isinstance(tables, Table) else tables)

    def __iter__(self) -> Iterator[Table]:
        return iter(self.tables)

    @property
    def values(self) -> NDArray[np.float64]:
        """All published values: (K,)."""
        return np.concatenate([table.values for table in self.tables])

    @property
    def num_events(self) -> int | None:
        """The number of events, if all tables agree on it; counts without `of` have as many as their bins hold."""
        counts = {
            round(table.values @ table.widths)
            if self.are_counts(table) and not (table.num_events or table.of)
            else table.num_events
            for table in self.tables
        }
        number = counts.pop()
        return None if counts or number is None else round(number)

    def are_counts(self, table: Table) -> bool:
        """Whether the errors of one of the tables are those of counts."""
        return self.covariance is None and table.covariance is None

    def entries(self, events: Any) -> csr_array:
        """How many entries each event has in each bin of all tables: (n, K)."""
        return csr_array(hstack([table.entries(events) for table in self.tables]))

    def predict(self, mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values that belong to mean entries per event: (..., K) -> (..., K).

        Raises UsageError for a normalised table without entries.
        """
        expected = np.empty_like(mean)
        for table, part in zip(self.tables, self.parts, strict=True):
            total = mean[..., part].sum(axis=-1, keepdims=True) if table.normalised else np.ones(1)
            if (total <= 0).any():
                raise table.wrong("no simulated event has an entry in its bins; check `of` and units")
            expected[..., part] = table.scale * mean[..., part] / total / table.widths
        return expected

    def entries_of(self, values: NDArray[np.float64], mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """The mean entries per event that belong to values (K,): (K,).

        In each normalised table they are as many as these mean entries (K,).
        """
        entries = np.maximum(values, 0)
        for table, part in zip(self.tables, self.parts, strict=True):
            entries[part] *= table.widths / table.scale * (mean[part].sum() if table.normalised else 1.0)
        return entries

    def slopes(self, mean: NDArray[np.float64], around: NDArray[np.float64]) -> NDArray[np.float64]:
        """The derivative of the values with respect to the mean entries per event (K,), where the values are `around`.

        (K, K), block by block. Of a normalised table a step along its own values has none.
        """
        blocks = []
        for table, part in zip(self.tables, self.parts, strict=True):
            total = mean[part].sum() if table.normalised else 1.0
            blocks.append(table.scale / total * shape_only(table, around[part]) / table.widths)
        return block_diag(*blocks)


def shape_only(table: Table, around: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a change of a table's values (K,) becomes once they are scaled to their sum `around` (K,): (K, K)."""
    one = np.eye(len(around))
    return one - np.outer(around, table.widths) / table.scale if table.normalised else one


def checked_covariance(covariance: ArrayLike, size: int, wrong: Callable[[str], Exception]) -> NDArray[np.float64]:
    """A covariance (K, K) that is one. Raises `wrong` with what it is not."""
    if np.ma.is_masked(covariance):
        raise wrong("covariance has masked values: mend or drop them")
    cov = np.asarray(covariance, float)
    if cov.shape != (size, size):
        raise wrong(f"covariance must have shape ({size}, {size}), one row per bin, got {cov.shape}")
    if not np.isfinite(cov).all():
        raise wrong("covariance has values that are not finite")
    variances = np.diag(cov)
    if (variances <= 0).any():
        raise wrong(f"covariance gives bin {1 + int(np.argmin(variances))} a variance of {variances.min():g}")
    correlation = cov / np.sqrt(np.outer(variances, variances))
    if not np.allclose(correlation, correlation.T, rtol=1e-6, atol=ROUNDING):
        raise wrong("covariance is not symmetric")
    values = np.linalg.eigvalsh(correlation)
    if values[0] < -ROUNDING * values[-1]:
        raise wrong(f"covariance is not positive: its correlation has an eigenvalue of {values[0]:.3g}")
    return (cov + cov.T) / 2
