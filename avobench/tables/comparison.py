"""How far simulated events are from published tables: chi-squared of each table and of all, and the bins that pull."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.stats import chi2

from avobench.tables.table import ROUNDING, Table, Tables, shape_only
from avobench.tasks.arguments import checked
from avobench.tasks.errors import UsageError


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is kept of simulated events: the entries that one event has in the bins of all tables."""

    mean: NDArray[np.float64]
    """(K,)"""
    covariance: NDArray[np.float64]
    """The covariance of the entries of one event: (K, K)."""
    num_events: int

    @classmethod
    def of(cls, tables: Tables, events: Any) -> "Reduced":
        """Reduce n events. Raises UsageError for events that the tables cannot bin."""
        entries = tables.entries(events)
        n = entries.shape[0]
        if n < 2:
            raise UsageError(f"tables are compared with simulated events, got {n}")
        mean = np.asarray(entries.sum(axis=0)) / n
        return cls(mean, (entries.T @ entries).toarray() / n - np.outer(mean, mean), n)

    @classmethod
    def together(cls, parts: "list[Reduced]") -> "Reduced":
        """What several sets of events of one theta give together."""
        n = np.array([part.num_events for part in parts])
        mean = np.average([part.mean for part in parts], axis=0, weights=n)
        second = np.average([part.covariance + np.outer(part.mean, part.mean) for part in parts], axis=0, weights=n)
        return cls(mean, second - np.outer(mean, mean), int(n.sum()))

    def predicted(self, tables: Tables) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The values that the events give (K,), and their covariance by simulation (K, K)."""
        expected = tables.predict(self.mean)
        slopes = tables.slopes(self.mean, expected)
        return expected, slopes @ self.covariance @ slopes.T / self.num_events

    def noise(self, tables: Tables, around: NDArray[np.float64]) -> NDArray[np.float64]:
        """The covariance by simulation (K, K) of the values that so many events give, if these are right (K,)."""
        mean = tables.entries_of(around, self.mean)
        slopes = tables.slopes(mean, around)
        return slopes @ self.scatter(tables, mean) @ slopes.T / self.num_events

    def pooled(self, tables: Tables) -> NDArray[np.float64]:
        """The mean of the measured and simulated values (K,), in each bin weighted by the events that either is worth.

        Where few were simulated, no bin is then taken to be as empty or as full as theirs.
        """
        per_value = tables.entries_of(np.ones_like(self.mean), self.mean)
        measured = per_value * tables.values
        one, weights = np.diag(self.scatter(tables, measured)), np.empty_like(measured)
        for table, part in zip(tables, tables.parts, strict=True):
            cov = table.covariance if tables.covariance is None else tables.covariance[part, part]
            counts = table.widths / per_value[part]  # the number of events
            weights[part] = counts if cov is None else one[part] / (np.diag(cov) * per_value[part] ** 2)
        return tables.predict((weights * measured + self.num_events * self.mean) / (weights + self.num_events))

    def scatter(self, tables: Tables, mean: NDArray[np.float64]) -> NDArray[np.float64]:
        """What each event adds to the covariance of the entries of all (K, K), where its mean entries are others (K,).

        In a normalised table the number of events scatters too, as Poisson says; else it is known. How entries go
        together is as it is in these events. A bin with less than one entry in all of them is taken to have one.
        """
        rare, size = 1 / self.num_events, len(mean)
        free = np.repeat([table.normalised for table in tables], [len(table.values) for table in tables])
        cov, second = self.covariance.copy(), self.covariance + np.outer(self.mean, self.mean)
        inside, least_outside = np.empty((0, size)), []
        for table, part in zip(tables, tables.parts, strict=True):
            measured, simulated = table.values @ table.widths / table.scale, self.mean[part]
            same = np.isclose(measured, simulated.sum(), rtol=1e-9, atol=0)
            if not table.normalised and np.allclose(second[part, part], np.diag(simulated)):
                # An event is in one bin or outside. This is one more bin, whose number scatters too, until it is known.
                free[part] = True
                inside = np.vstack([inside, np.isin(np.arange(size), np.arange(size)[part])])
                least_outside.append(0 if same else rare)
            # If all events have the same number of entries, but had another one where it was measured: then one in all
            # simulated events is taken to have none.
            elif table.num_events and not same:
                cov[part, part] += rare * np.outer(simulated, simulated)
        every, least = np.vstack([np.eye(size), -inside]), np.append(np.full(size, rare), least_outside)
        old, new = (np.append(m, 1 - inside @ m) for m in (self.mean, mean))
        free = np.append(free, np.ones(len(inside)))
        one = every @ cov @ every.T + np.outer(old * free, old * free)
        # With a known number of events one of them makes a variance of rare (1 - rare).
        one += np.diag(np.maximum(least * (1 - rare * (1 - free)) - np.diag(one), 0))
        new = np.maximum(new, least)
        root = np.sqrt(new / np.maximum(old, rare))
        fixed = np.eye(size, len(one))
        for row, outside in zip(inside, np.eye(len(one))[size:], strict=True):
            of_table = np.append(row, outside[size:])
            fixed -= np.outer(new[:size] * row, of_table) / (new @ of_table)
        return fixed @ (one * np.outer(root, root)) @ fixed.T

    def errors_of(self, tables: Tables, around: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """The covariance of the published values (K, K), if these are right (K,), or those that the events give.

        Errors are as published. Counts scatter as the entries of simulated events do, of which one may have several.
        """
        mean = self.mean if around is None else tables.entries_of(around, self.mean)
        one, mean, blocks = self.scatter(tables, mean), np.maximum(mean, 1 / self.num_events), []
        for table, part in zip(tables, tables.parts, strict=True):
            values, cov = table.values, table.covariance
            if tables.covariance is not None:
                cov = tables.covariance[part, part]
            elif cov is None:
                num_events = table.scale / mean[part].sum() if table.normalised else table.scale
                values = num_events * mean[part] / table.widths
                cov = num_events * one[part, part] / np.outer(table.widths, table.widths)
            blocks.append((cov, shape_only(table, values)))
        shape = block_diag(*(shape for _, shape in blocks))
        cov = block_diag(*(cov for cov, _ in blocks)) if tables.covariance is None else tables.covariance
        return shape @ cov @ shape.T


@dataclass(frozen=True, eq=False)
class TableRow:
    """How far one table is from the simulator."""

    table: Table
    expected: NDArray[np.float64]
    """What the simulator gives for the values: (K,)."""
    pulls: NDArray[np.float64]
    """Expected minus published, in standard errors of their difference: (K,)."""
    chi_squared: float
    dof: int

    @property
    def p_value(self) -> float:
        """The probability of a larger chi-squared, if the simulator is right."""
        return float(chi2.sf(self.chi_squared, self.dof)) if self.dof else 1.0

    @property
    def furthest(self) -> tuple[float, float, float]:
        """The bin that pulls most: its edges, and its pull."""
        i = int(np.abs(self.pulls).argmax())
        return float(self.table.edges[i]), float(self.table.edges[i + 1]), float(self.pulls[i])


@dataclass(frozen=True, eq=False)
class Comparison:
    """How far simulated events are from published tables. Degrees of freedom are the rank of the covariance."""

    rows: list[TableRow]
    """One a table."""
    chi_squared: float
    """The distance from all tables together, with what they have in common."""
    dof: int
    num_simulations: int
    """Simulated events that it rests on."""

    @classmethod
    def of(
        cls, tables: Tables, expected: NDArray[np.float64], cov: NDArray[np.float64], num_simulations: int
    ) -> "Comparison":
        """Compare what a simulator gives for all values (K,). The covariance of the difference is `cov` (K, K)."""
        away = expected - tables.values
        pulls = away / np.sqrt(np.diag(cov))
        rows = [
            TableRow(table, expected[part], pulls[part], *distance(away[part], cov[part, part]))
            for table, part in zip(tables, tables.parts, strict=True)
        ]
        return cls(rows, *distance(away, cov), num_simulations)

    @property
    def p_value(self) -> float:
        """The probability of a larger chi-squared of all tables, if the simulator is right."""
        return float(chi2.sf(self.chi_squared, self.dof)) if self.dof else 1.0

    def __str__(self) -> str:
        width = max(len(name) for name in ("all tables", *(row.table.name for row in self.rows)))
        lines = [f"{'table':{width}}  chi-squared  dof  furthest bin"]
        for row in self.rows:
            low, high, pull = row.furthest
            where = f"{low:g} to {high:g}: {pull:+.1f} standard errors"
            lines.append(f"{row.table.name:{width}}  {row.chi_squared:11.1f}  {row.dof:3d}  {where}")
        return "\n".join([*lines, f"{'all tables':{width}}  {self.chi_squared:11.1f}  {self.dof:3d}"])


@checked
def compare_tables(tables: Table | Tables | list[Table], events: Any) -> Comparison:
    """Compare published tables with simulated events, and no further simulator call.

    `events` are what the tables' `of` takes, or an array (n, d), or a `Reduced`. The covariance of the difference is
    that of the tables plus that of the simulated means, if the simulator is right: both are taken where measured and
    simulated events together have their mean. Raises UsageError for what does not fit together.
    """
    tables = Tables.of(tables)
    reduced = events if isinstance(events, Reduced) else Reduced.of(tables, events)
    expected, around = tables.predict(reduced.mean), reduced.pooled(tables)
    cov = reduced.errors_of(tables, around) + reduced.noise(tables, around)
    return Comparison.of(tables, expected, cov, reduced.num_events)


def whitening(cov: NDArray[np.float64]) -> NDArray[np.float64]:
    """W (K, r) with W^T cov W = 1, r the rank of cov (K, K): 1 less for each table of which only the shape is known."""
    scale = np.sqrt(np.diag(cov))
    values, vectors = np.linalg.eigh(cov / np.outer(scale, scale))
    kept = values > ROUNDING * values[-1]
    return vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None]


def distance(away: NDArray[np.float64], cov: NDArray[np.float64]) -> tuple[float, int]:
    """Chi-squared of a difference (K,) with this covariance (K, K), and its degrees of freedom."""
    w = whitening(cov)
    return float(((away @ w) ** 2).sum()), w.shape[1]
