"""The coverage of quoted errors: how often the truth lies within them, in `avobench figure coverage`.

A method quotes a standard error of its estimate, or a posterior with a mean and a standard deviation; either makes
Gaussian intervals for each parameter. Of intervals of 68 % such a share should hold the true value. The width of a
proposal is no statement about theta, and is left out.
"""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import norm

from avobench.bench.store.frame import labels
from avobench.bench.store.status import ESTIMATED
from avobench.reports.style import FLOOR, METHOD_ORDER, TASK_ORDER, by_task, colours, ordered
from avobench.tasks.errors import StoreError

CURVE = np.linspace(0, 1, 101)
"""The nominal shares at which a curve is drawn."""


def distances(record: dict[str, Any]) -> NDArray[np.float64] | None:
    """The distances of the true parameters from the quoted ones, in quoted standard errors: (p,).

    The result is None if nothing is quoted. A parameter without a finite standard error is infinitely far.
    """
    if record["status"] not in ESTIMATED:
        return None
    if record.get("standard_error") is not None:
        middle, spread = record["theta_hat"], record["standard_error"]
    elif record["spread_of"] == "posterior":
        middle, spread = record["mean"], record["std"]
    else:
        return None
    away = np.abs(np.array(middle, float) - record["theta_true"])
    with np.errstate(divide="ignore", invalid="ignore"):  # 0 / 0 is a point that is right
        return np.nan_to_num(np.where(away == 0, 0, away / np.array(spread, float)), nan=np.inf, posinf=np.inf)


def by_method(records: list[dict[str, Any]]) -> dict[tuple[str, str], NDArray[np.float64]]:
    """The distances of all parameters of all records of a task and method, those with any: (n,) each."""
    parts: dict[tuple[str, str], list[NDArray[np.float64]]] = {}
    for task, method, record in zip(*labels(records), records, strict=True):
        if (away := distances(record)) is not None:
            parts.setdefault((task, method), []).append(away)
    keys = [
        (task, method)
        for task in ordered((task for task, _ in parts), TASK_ORDER)
        for method in ordered((method for of, method in parts if of == task), METHOD_ORDER)
    ]
    return {key: np.concatenate(parts[key]) for key in keys}


def drawn(records: list[dict[str, Any]]) -> tuple[Figure, pd.DataFrame]:
    """The figure has one panel per task, and the table one row per point of a curve.

    Raises StoreError where no record quotes anything.
    """
    pooled = by_method(records)
    if not pooled:
        raise StoreError("no record has a standard error or a posterior, so there is no coverage to draw")
    curves = []
    for (task, method), away in pooled.items():
        held = (away[:, None] <= norm.ppf((1 + CURVE) / 2)).mean(axis=0)
        curves.append(pd.DataFrame({"task": task, "method": method, "nominal": CURVE, "empirical": held}))
    table = pd.concat(curves)
    return by_task(table, table["task"], _panel), table


def _panel(axis: Axes, table: pd.DataFrame, methods: list[str]) -> None:
    axis.plot([0, 1], [0, 1], color=FLOOR, ls="--", lw=1.2)
    for method, curve in table.groupby("method", sort=False):
        axis.plot(CURVE, curve["empirical"], color=colours(methods)[method], label=method, clip_on=False)
    axis.set(xlabel="nominal coverage", ylabel="empirical coverage", xlim=(0, 1), ylim=(0, 1))
