"""How far each table, or each of several data sets, is from the simulator, before and after."""

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import TableGap
from avobench.diagnosis.summary.bins import Summary
from avobench.diagnosis.summary.joint import StackedSummary
from avobench.diagnosis.summary.table import TableSummary
from avobench.diagnosis.summary.target import Target, whitening
from avobench.tables.comparison import Comparison


def table_gaps(target: Target, before: Fit, after: Fit | None) -> list[TableGap]:
    """Chi-squared of each table, and of each of several data sets, with theta fitted, without effects and with them.

    Of a table it is that of the whole, as it is published. None for one sample of events.
    """
    if isinstance(target.summary, StackedSummary):
        sets = zip(target.summary.names, target.summary.summaries, target.summary.parts, strict=True)
        return [
            replaced for name, summary, part in sets for replaced in _of_set(name, summary, part, target, before, after)
        ]
    if isinstance(target.summary, TableSummary):
        return _of_set("", target.summary, slice(None), target, before, after)
    return []


def _of_set(name: str, summary: Summary, part: slice, target: Target, before: Fit, after: Fit | None) -> list[TableGap]:
    """Of the tables of one set, or of its events."""
    cov, directions = (target.cov / target.num_events)[part, part], whitening(target.cov[part, part])

    def compared(fit: Fit) -> list[tuple[str, float, int]]:
        predicted: NDArray[np.float64] = fit.predicted[part]
        if isinstance(summary, TableSummary):
            errors = summary.simulated.errors_of(summary.tables, predicted)
            rows = Comparison.of(summary.tables, predicted, errors + fit.noise * cov, fit.num_events).rows
            return [(table.name, row.chi_squared, row.dof) for table, row in zip(summary.tables, rows, strict=True)]
        residual = np.sqrt(target.num_events) * (target.mean[part] - predicted) @ directions
        return [("", float(residual @ residual) / (1 + fit.noise), len(residual))]

    first = compared(before)
    then = [q for _, q, _ in compared(after)] if after else [None] * len(first)
    return [
        TableGap(
            name=": ".join(filter(None, (name, label))),
            kind="table" if isinstance(summary, TableSummary) else "events",
            dof=dof,
            chi_squared_before=q,
            chi_squared_after=later,
        )
        for (label, q, dof), later in zip(first, then, strict=True)
    ]
