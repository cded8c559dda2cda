"""The targets of `avo`, each with what was measured: `python -m paper.tables targets`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.reports.numbers import p_equals
from avobench.reports.quantities import comparable, labelled, task_of
from avobench.reports.style import METHOD_ORDER, ordered
from paper.quantities import (
    MOST_CHANCE,
    WORST_RUN,
    ahead,
    as_text,
    asymmetry_in_units_of_the_best,
    beside_ideal,
    by_mean,
    in_units_of_the_best,
    interval,
    median,
    ratio_of_means,
    ratios,
    worst,
)

METHOD = "avo"
RIVALS = ("abc-smc", "bolfi")
MOST_INEFFICIENT = {"poisson": 2.0, "carl": 2.0, "alignment": 2.5}
MOST_ASYMMETRY = 3.0
"""Inefficiency in c on weinberg that is wanted at most."""
MOST_OVER_IDEAL = 2.0
"""Mean squared error on weinberg over that of the ideal posterior mean on the same targets that is wanted at most."""


@dataclass(frozen=True)
class Target:
    """A quantity of a task's cells that `avo` is to keep small."""

    task: str
    what: str
    values: Callable[[pd.DataFrame], NDArray[np.float64]]
    """Function from the cells of one method on the task to values (n,), or (n, 2)."""
    statistic: Callable[[NDArray[np.float64]], float]
    """Function from these values to the quantity."""
    most: float | None
    """None where it is to be below what each rival has, by a paired test."""

    def measure(self, cells: pd.DataFrame) -> float:
        return self.statistic(self.values(cells))

    def interval(self, cells: pd.DataFrame) -> tuple[float, float]:
        """Where the quantity may lie for other targets: NaN for a largest value, which has no such interval."""
        if self.statistic is worst:
            return np.nan, np.nan
        return interval(self.values(cells), cells["target"], self.statistic)


BEST = in_units_of_the_best, median
TARGETS = (
    *(Target(task, "inefficiency", *BEST, most) for task, most in MOST_INEFFICIENT.items()),
    Target("weinberg", "inefficiency in c", asymmetry_in_units_of_the_best, median, MOST_ASYMMETRY),
    Target("weinberg", "mean error / ideal", beside_ideal, ratio_of_means, MOST_OVER_IDEAL),
    *(Target(task, "worst run / floor", ratios, worst, WORST_RUN) for task in (*MOST_INEFFICIENT, "weinberg")),
    *(Target(task, "against the rivals", *BEST, None) for task in MOST_INEFFICIENT),
)


def table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """One row per target: what was measured of each method, what is wanted of `avo`, and whether that is met.

    A task is measured on the targets that all of its methods have; a run that failed has an infinite error. Beside what
    was measured of `avo` stands its 95 % interval, over other draws of the targets. Where what is wanted lies within
    it, 15 targets do not decide, and the verdict is "not excluded". `avo` is ahead of a rival where a
    paired test over the targets says so of both its answers, and the largest p-value stands with the verdict.
    """
    frame = labelled(records)
    methods = ordered(frame["method"], METHOD_ORDER)
    known = frame[[task_of(record) is not None for record in records]]
    shown = {task: comparable(cells) for task, cells in known.groupby("task")}
    columns = [column for method in methods if method != METHOD for column in _columns(method)]
    rows = []
    for target in TARGETS:
        cells = shown.get(target.task, frame[:0])
        by_method = dict(iter(cells.groupby("method")))
        by_method |= {f"{rival} mean": by_mean(by_method[rival]) for rival in RIVALS if rival in by_method}
        values = {method: target.measure(own) for method, own in by_method.items()}
        own = by_method.get(METHOD)
        rows.append(
            {
                "task": target.task,
                "quantity": target.what,
                "targets": cells["target"].nunique(),
                METHOD: values.get(METHOD, np.nan),
                "95 %": "-" if own is None else as_text(target.interval(own)),
                **{column: values.get(column, np.nan) for column in columns},
                "wanted": "ahead of all" if target.most is None else f"at most {target.most:g}",
                "verdict": _verdict(target, by_method, values),
            }
        )
    return pd.DataFrame(rows)


def _columns(method: str) -> tuple[str, ...]:
    """A rival has two answers, its estimate and the mean of its posterior: both are shown."""
    return (method, f"{method} mean") if method in RIVALS else (method,)


def _verdict(target: Target, by_method: dict[str, pd.DataFrame], values: dict[str, float]) -> str:
    wanted = RIVALS if target.most is None else ()
    if not {METHOD, *wanted} <= by_method.keys():
        return "no records"
    if target.most is not None:
        low, high = target.interval(by_method[METHOD])
        if low <= target.most < high:
            return "not excluded" if values[METHOD] <= target.most else "not met, not excluded"
        return "met" if values[METHOD] <= target.most else "not met"
    p = max(ahead(by_method[METHOD], by_method[column]) for rival in RIVALS for column in _columns(rival))
    return f"met, {p_equals(p)}" if p < MOST_CHANCE else f"not met, {p_equals(p)}"
