"""How far each published table is from the simulator, before and after."""

from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.schema import TableGap
from avobench.diagnosis.summary.table import TableSummary
from avobench.diagnosis.summary.target import Target
from avobench.tables.comparison import Comparison


def table_gaps(target: Target, before: Fit, after: Fit | None) -> list[TableGap]:
    """Chi-squared of each published table, with theta fitted, without effects and with them; none for events."""
    summary = target.summary
    if not isinstance(summary, TableSummary):
        return []

    def compared(fit: Fit) -> Comparison:
        noise = fit.noise * target.cov / target.num_events
        return Comparison.of(summary.tables, fit.predicted, noise, fit.num_events)

    rows = compared(before).rows
    others = compared(after).rows if after else [None] * len(rows)
    return [
        TableGap(
            name=row.table.name,
            dof=row.dof,
            chi_squared_before=row.chi_squared,
            chi_squared_after=None if other is None else other.chi_squared,
        )
        for row, other in zip(rows, others, strict=True)
    ]
