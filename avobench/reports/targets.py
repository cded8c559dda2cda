"""The targets of `avo`, each with what was measured: `avobench status --targets`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from avobench.reports.quantities import (
    asymmetry_errors,
    comparable,
    efficient_median,
    ideal_errors,
    inefficiency,
    labelled,
    task_of,
)
from avobench.reports.style import METHOD_ORDER, ordered

METHOD = "avo"
RIVALS = ("abc-smc", "bolfi")
MOST_INEFFICIENT = {"poisson": 2.0, "carl": 2.0, "alignment": 2.5}
MOST_ASYMMETRY = 3.0
"""Inefficiency in c on weinberg that is wanted at most."""
MOST_OVER_IDEAL = 2.0
"""Mean squared error on weinberg over that of the ideal posterior mean on the same targets that is wanted at most."""
WORST_RUN = 100.0
"""Squared error over the floor that no run should exceed: beyond it a run went astray, as chance does not."""


@dataclass(frozen=True)
class Target:
    """A quantity of a task's cells that `avo` is to keep small."""

    task: str
    what: str
    measure: Callable[[pd.DataFrame], float]
    """Of the cells of one method on the task."""
    most: float | None
    """None where it is to be below what each rival has."""


def inefficiency_of(cells: pd.DataFrame) -> float:
    """Median ratio of squared error to floor, over that of an efficient estimator."""
    return inefficiency(cells["ratio"], task_of(cells["record"].iloc[0]).floor_shares)


def asymmetry_inefficiency(cells: pd.DataFrame) -> float:
    """On weinberg, the same for the asymmetry c, the one quantity that the events determine."""
    errors, floors = asymmetry_errors(cells)
    return float(np.median(errors / floors) / efficient_median((1.0,)))


def over_ideal(cells: pd.DataFrame) -> float:
    """On weinberg, the mean squared error over that of the ideal posterior mean on the same targets."""
    return float(cells["squared_error"].mean() / ideal_errors(cells).mean())


def worst_run(cells: pd.DataFrame) -> float:
    """The largest ratio of squared error to floor."""
    return float(cells["ratio"].max())


TARGETS = (
    *(Target(task, "inefficiency", inefficiency_of, most) for task, most in MOST_INEFFICIENT.items()),
    Target("weinberg", "inefficiency in c", asymmetry_inefficiency, MOST_ASYMMETRY),
    Target("weinberg", "mean error / ideal", over_ideal, MOST_OVER_IDEAL),
    *(Target(task, "worst run / floor", worst_run, WORST_RUN) for task in (*MOST_INEFFICIENT, "weinberg")),
    *(Target(task, "against the rivals", inefficiency_of, None) for task in MOST_INEFFICIENT),
)


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a target: what was measured of each method, what is wanted of `avo`, and whether that is met.

    A task is measured on the targets that all of its methods have; a run that failed has an infinite error.
    """
    frame = labelled(records)
    methods = ordered(frame["method"], METHOD_ORDER)
    known = frame[[task_of(record) is not None for record in records]]
    shown = {task: comparable(cells) for task, cells in known.groupby("task")}
    rows = []
    for target in TARGETS:
        cells = shown.get(target.task, frame[:0])
        values = {method: target.measure(own) for method, own in cells.groupby("method")}
        rivals = [values.get(rival, np.nan) for rival in RIVALS]
        most = min(rivals) if target.most is None else target.most
        own = values.get(METHOD, np.nan)
        met = own < most if target.most is None else own <= most
        rows.append(
            {
                "task": target.task,
                "quantity": target.what,
                "targets": cells["target"].nunique(),
                METHOD: own,
                **{method: values.get(method, np.nan) for method in methods if method != METHOD},
                "wanted": "ahead of both" if target.most is None else f"at most {most:g}",
                "verdict": "no records" if np.isnan([own, most]).any() else "met" if met else "not met",
            }
        )
    return pd.DataFrame(rows)


def format_table(records: list[dict[str, Any]]) -> str:
    """`table`, to be read."""
    return table(records).to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")
