"""What was measured where it is published tables: a random part of what they tell, and the target made of it."""

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.settings import BUDGET, SUMMARY
from avobench.diagnosis.summary.bins import Summary
from avobench.diagnosis.summary.part import Part
from avobench.diagnosis.summary.table import TableSummary
from avobench.diagnosis.summary.target import Target
from avobench.tables.comparison import Reduced
from avobench.tables.table import Table, Tables
from avobench.tasks import Task

MOST_VALUES = 200_000
"""Values of a feature that are drawn from a table, at most: ranges and limits of effects are read off them."""

MOST_DRAWN = 10**9 - 1
"""Events that NumPy draws from without replacement, at most."""

PLAIN = 3
"""Times as many measured entries as fill a bin by themselves: from so many, where few are expected, no chance makes."""


@dataclass(frozen=True, eq=False)
class TablePart(Part):
    """A random part of what published tables tell."""

    tables: Tables
    values: NDArray[np.float64]
    """Those of this part, on the scale of the whole: (K,)."""
    share: float
    """Its share of the information: the covariance of its values is that of the whole, divided by it."""
    reference: NDArray
    """Simulated events over the prior: (n, d)."""

    @classmethod
    def whole(cls, tables: Tables, reference: NDArray) -> "TablePart":
        """All that the tables tell."""
        return cls(tables, tables.values, 1.0, reference)

    def split(self, aside: float, rng: np.random.Generator) -> tuple["TablePart", "TablePart"]:
        """The whole in two parts.

        Counts of events are drawn without replacement, as events are that are kept aside. Of values v with errors of
        covariance C the parts are v + z sqrt(a / (1 - a)) and v - z sqrt((1 - a) / a) with z ~ N(0, C), which have the
        covariances C / (1 - a) and C / a (A. Neufeld et al., J. Mach. Learn. Res. 25 (2024), no. 57). So are those of
        counts of which an event may have several: which of them are of the same event is not published.
        """
        tables, reference = self.tables, self.reference
        entries = tables.entries(reference)
        cov = Reduced.of(tables, reference).errors_of(tables, tables.values)
        scale = np.sqrt(np.maximum(np.diag(cov), np.finfo(float).tiny))  # of tables whose units differ by far
        variances, vectors = np.linalg.eigh(cov / np.outer(scale, scale))
        noise = scale * (vectors @ (np.sqrt(np.maximum(variances, 0)) * rng.standard_normal(len(variances))))
        fitted = tables.values + np.sqrt(aside / (1 - aside)) * noise
        held_out = tables.values - np.sqrt((1 - aside) / aside) * noise
        for table, part in zip(tables, tables.parts, strict=True):
            if tables.are_counts(table) and entries[:, part].sum(axis=1).max() <= 1:
                fitted[part], held_out[part] = _split_counts(table, aside, rng)
        return TablePart(tables, fitted, 1 - aside, reference), TablePart(tables, held_out, aside, reference)

    @cached_property
    def first(self) -> Target:
        """The target beside events over the prior."""
        target = self._target(self.reference)
        tables, near = target.summary.tables, target.summary.simulated
        # Events over the prior scatter most where few were measured. Of how many those that were measured are, is told
        # by the scatter of as many entries as they have.
        entries = tables.entries_of(target.mean, near.mean)
        slopes, one = tables.slopes(entries, tables.predict(entries)), near.scatter(tables, entries)
        summary = replace(target.summary, simulated=replace(near, mean=entries, covariance=one))
        return self._of(target, summary, slopes @ one @ slopes.T)

    def __len__(self) -> int:
        return self.first.num_events

    def seen_by(self, summary: Summary) -> tuple[NDArray[np.float64], int]:
        return self._in_bins_of(summary.tables), max(round(self.share * summary.worth), 1)

    def target(self, simulated: NDArray) -> Target:
        target = self._target(simulated)
        return self._of(target, target.summary, target.summary.covariance(simulated))

    def _of(self, target: Target, summary: TableSummary, scatter: NDArray[np.float64]) -> Target:
        """A target of so many events as scatter like this (K, K), on average over what is fitted, to its errors."""
        of_one = np.einsum("kr,kl,lr->", target.whitening, scatter, target.whitening)
        worth = max(float(of_one) / max(target.rank, 1), 1.0)
        num_events = max(round(self.share * worth), 1)
        return Target.of(replace(summary, worth=worth), target.mean, num_events, worth * target.cov)

    def _target(self, simulated: NDArray) -> Target:
        """What is fitted, with the scales and the bins of simulated events (n, d) near the fit.

        Bins of counts are merged until each is filled. The covariance is that of the tables, with errors of counts that
        are mostly the measured ones and a little the simulated. Noise of simulation is told in a number of events: that
        at which simulated events would have, on average over what is fitted, the errors of the tables. Here it is 1.
        """
        expected = self.tables.predict(Reduced.of(self.tables, simulated).mean)
        # As many entries as are expected, or many more measured ones: what is merged by measured counts that are just
        # enough has too many on average.
        held = self.share * np.stack([expected, self.values / PLAIN])
        starts = [
            _filled(held[:, part] * table.widths) if self.tables.are_counts(table) else np.arange(len(table.values))
            for table, part in zip(self.tables, self.tables.parts, strict=True)
        ]
        tables = Tables(
            (table.merged(at) for table, at in zip(self.tables, starts, strict=True)), covariance=self.tables.covariance
        )
        values, reduced = self._in_bins_of(tables), Reduced.of(tables, simulated)
        expected = (1 - SUMMARY.mixed_in) * values + SUMMARY.mixed_in * tables.predict(reduced.mean)
        cov = reduced.errors_of(tables, expected)
        return Target.of(TableSummary(tables, reduced), values, 1, cov)

    def _in_bins_of(self, tables: Tables) -> NDArray[np.float64]:
        """The values in wider bins, into which those of the tables were merged."""
        merged = []
        for table, part, wide in zip(self.tables, self.tables.parts, tables, strict=True):
            starts = np.searchsorted(table.edges, wide.edges[:-1])
            counts = np.add.reduceat(self.values[part] * table.widths, starts)
            merged.append(self.values[part] if len(starts) == len(table.values) else counts / wide.widths)
        return np.concatenate(merged)

    def as_events(self, task: Task, simulated: NDArray, rng: np.random.Generator) -> NDArray:
        """Within a bin they are distributed as those of simulated events, as are features without a table."""
        m = min(len(self), MOST_VALUES)
        x = simulated[rng.integers(len(simulated), size=m)]
        for table, part in zip(self.tables, self.tables.parts, strict=True):
            if table.of is None:
                column = _drawn(table, np.maximum(self.values[part], 0), simulated[:, table.feature], m, rng)
                count = task.kinds_of_features[table.feature] == "count"
                x[:, table.feature] = np.ceil(column - 0.5) if count else column
        return x


def _split_counts(
    table: Table, aside: float, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The values of both parts of a table of counts, of which each event has one at most: (K,) twice."""
    counts = np.rint(table.values * table.widths).astype(np.int64)
    outside = 0 if table.normalised else max(round(min(table.scale, MOST_DRAWN)) - counts.sum(), 0)
    every = np.append(counts, outside)
    number = round(aside * every.sum())
    drawn = rng.multivariate_hypergeometric(every, number, method="marginals")[:-1]
    aside = number / every.sum()
    return (counts - drawn) / (1 - aside) / table.widths, drawn / aside / table.widths


def _filled(counts: NDArray[np.float64]) -> NDArray[np.intp]:
    """Where wider bins begin, each with enough counts of one kind (2, K): (k,)."""
    starts, held = [0], np.zeros(2)
    for k in range(1, counts.shape[1]):
        held += counts[:, k - 1]
        if min(held.max(), counts[:, k:].sum(axis=1).max()) >= SUMMARY.least_in_bin:
            starts.append(k)
            held[:] = 0
    return np.array(starts)


def _drawn(
    table: Table, values: NDArray[np.float64], simulated: NDArray, m: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """So many numbers of a table with these values (K,), in each bin as simulated ones (n,) are: (m,)."""
    share = np.cumsum(values * table.widths)
    bins = np.searchsorted(share / share[-1], (np.arange(m) + 0.5) / m)
    numbers = np.empty(m)
    for k, (low, high) in enumerate(zip(table.edges, table.edges[1:], strict=False)):
        here, inside = bins == k, np.sort(simulated[(simulated >= low) & (simulated < high)])
        at = inside if len(inside) else np.array([end for end in (low, high) if np.isfinite(end)])
        numbers[here] = np.interp(rng.random(here.sum()), np.linspace(0, 1, len(at)), at)
    return rng.permutation(numbers)


def tables_of(task: Task, tables: Tables) -> Tables:
    """The tables with a name each, and features by their numbers.

    Raises UsageError for a feature or a unit that the task does not have, and for tables of too few counts.
    """
    named: list[Table] = []
    occurrences: Counter[str] = Counter()
    for table in tables:
        changed = _of_feature(task, table) if table.of is None else {"name": table.name or "table"}
        occurrences[changed["name"]] += 1
        if (number := occurrences[changed["name"]]) > 1:
            changed["name"] += f" ({number})"
        count = round(table.values @ table.widths)
        if tables.are_counts(table) and count < BUDGET.least_events:
            raise table.wrong(f"{count} entries are too few, at least {BUDGET.least_events} are needed")
        named.append(replace(table, errors=None, **changed))
    return Tables(named, covariance=tables.covariance)


def _of_feature(task: Task, table: Table) -> dict[str, Any]:
    """The number of the feature of a task that a table is of, its unit, and a name."""
    labels, feature = list(task.labels), table.feature
    if feature not in labels and feature not in range(len(labels)):
        raise table.wrong(f"{task.name} has no feature {feature}; it has: {', '.join(labels)}")
    at = labels.index(feature) if isinstance(feature, str) else feature
    unit = task.feature_units[at] if task.feature_units else ""
    if table.unit and unit and table.unit not in (unit, unit.upper()):  # old tables of HEPData have capitals alone
        raise table.wrong(f"its edges are in {table.unit}, and {task.name} makes {labels[at]} in {unit}")
    return {"feature": at, "unit": unit or table.unit, "name": table.name or labels[at]}
