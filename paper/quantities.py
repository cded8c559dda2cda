"""Measures of the distance of estimates from the best possible ones, for targets, tables and claims."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import wilcoxon
from scipy.stats.qmc import Sobol

from avobench.bench.store.frame import mean_errors
from avobench.reports.quantities import task_of

WORST_RUN = 100.0
"""Squared error over the floor that no run should exceed: beyond it a run went astray, as chance does not."""
RESAMPLES = 2000
"""Resamples of the targets for an interval. The share beyond each end is then 2.5 % to within 0.4 %."""
COVERAGE = 0.95
"""Coverage of an interval."""
MOST_CHANCE = 0.05
"""One method is ahead of another where a paired test says that chance alone would do as much less often than this."""
LARGEST = 1e300
"""Takes the place of the error of a failed run, which is infinite, in a test that takes differences."""


def by_mean(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells scored by the mean of their posterior in place of their estimate; a failure stays one."""
    errors = mean_errors(cells["record"].tolist())
    failed = np.isinf(cells["squared_error"])
    cells = cells.assign(squared_error=np.where(failed, np.inf, errors))
    records = [{**record, "theta_hat": record["mean"]} for record in cells["record"]]
    return cells.assign(ratio=cells["squared_error"] / cells["floor"], record=records)


def still(record: dict[str, Any]) -> float:
    """The share of the trace's steps in which the proposal stands exactly still, its centre and its width."""
    points = [(point["theta"], point["std"]) for point in record["trace"] or ()]
    return sum(before == after for before, after in pairwise(points)) / max(1, len(points) - 1)


@cache
def efficient_median(shares: tuple[float, ...]) -> float:
    """Median of an efficient estimator's squared error over its expectation, the floor.

    That is the median of sum_i share_i z_i^2 with independent Gaussian z_i of unit variance: 0.455 for one parameter.
    """
    z = ndtri((1 + Sobol(len(shares), seed=0).random_base2(16)) / 2)
    return float(np.median(z**2 @ np.array(shares)))


def asymmetry_errors(cells: pd.DataFrame) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared errors of c(theta_hat) and their floors in cells of weinberg: (n,), (n,). A failed cell has infinity."""
    errors, floors = [], []
    for record in cells["record"]:
        task, true = task_of(record), np.array(record["theta_true"])
        floors.append(task.asymmetry_floor(true, record["num_observations"], record["budget"]))
        found = record["theta_hat"]
        thetas = np.array([true, true if found is None else found])
        errors.append(np.inf if found is None else np.diff(task.asymmetry(thetas))[0] ** 2)
    return np.array(errors), np.array(floors)


def ideal_errors(cells: pd.DataFrame) -> NDArray[np.float64]:
    """The squared errors in cells of weinberg of the posterior mean at the true c, the best on average: (n,)."""
    true = np.array([record["theta_true"] for record in cells["record"]])
    task = task_of(cells["record"].iloc[0])
    return ((task.posterior_mean(task.asymmetry(true)) - true) ** 2).sum(axis=1)


def interval(
    values: NDArray[np.float64], targets: pd.Series, statistic: Callable[[NDArray[np.float64]], float]
) -> tuple[float, float]:
    """The 95 % bootstrap interval of a statistic of cells' values (n, ...), over other draws of their targets (n,).

    Whole targets are drawn again, with all of their repetitions: what differs between two is more than chance in a run.
    Without a second target nothing is known of that, and both ends are NaN.
    """
    places = [np.flatnonzero(targets == target) for target in np.unique(targets)]
    if len(places) < 2:
        return np.nan, np.nan
    rng = np.random.default_rng(0)
    found = [
        statistic(values[np.concatenate([places[i] for i in rng.integers(len(places), size=len(places))])])
        for _ in range(RESAMPLES)
    ]
    low, high = np.quantile(found, [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2], method="nearest")
    return float(low), float(high)


def errors_by_target(cells: pd.DataFrame) -> pd.Series:
    """A squared error a target: the median over its repetitions."""
    return cells.groupby("target")["squared_error"].median()


def ahead(cells: pd.DataFrame, rival: pd.DataFrame) -> float:
    """The p-value of Wilcoxon's signed-rank test, one-sided, on the logarithms of errors of a method and a rival."""
    pairs = pd.concat([errors_by_target(cells), errors_by_target(rival)], axis=1, join="inner").to_numpy()
    if not len(pairs):
        return np.nan
    logs = np.log(pairs.clip(1 / LARGEST, LARGEST))
    return float(wilcoxon(logs[:, 0], logs[:, 1], alternative="less").pvalue)


def interval_text(values: NDArray, targets: pd.Series, statistic: Callable[[NDArray], float]) -> str:
    """The result of `interval` as text."""
    return as_text(interval(values, targets, statistic))


def as_text(ends: tuple[float, float]) -> str:
    """An interval as text, and a dash where there is none."""
    low, high = ends
    return "-" if np.isnan(low) else f"[{low:.2g}, {high:.2g}]"


def in_units_of_the_best(cells: pd.DataFrame) -> NDArray[np.float64]:
    """Ratio of squared error to floor, over the median of that ratio for an efficient estimator: (n,)."""
    return cells["ratio"].to_numpy() / efficient_median(task_of(cells["record"].iloc[0]).floor_shares)


def asymmetry_in_units_of_the_best(cells: pd.DataFrame) -> NDArray[np.float64]:
    """The same ratio for the asymmetry c on weinberg, the one quantity that the events determine: (n,)."""
    return np.divide(*asymmetry_errors(cells)) / efficient_median((1.0,))


def beside_ideal(cells: pd.DataFrame) -> NDArray[np.float64]:
    """The squared errors on weinberg, and those of the ideal posterior mean at the same targets: (n, 2)."""
    return np.column_stack([cells["squared_error"], ideal_errors(cells)])


def ratios(cells: pd.DataFrame) -> NDArray[np.float64]:
    """Ratio of squared error to floor: (n,)."""
    return cells["ratio"].to_numpy()


def median(values: NDArray[np.float64]) -> float:
    return float(np.median(values))


def worst(values: NDArray[np.float64]) -> float:
    return float(values.max())


def ratio_of_means(values: NDArray[np.float64]) -> float:
    """The ratio of the mean of the first column to that of the second."""
    return float(values[:, 0].mean() / values[:, 1].mean())


def inefficiency_of(cells: pd.DataFrame) -> float:
    """Median ratio of squared error to floor, over that of an efficient estimator."""
    return median(in_units_of_the_best(cells))


def asymmetry_inefficiency(cells: pd.DataFrame) -> float:
    """The median of `asymmetry_in_units_of_the_best`, for cells of weinberg."""
    return median(asymmetry_in_units_of_the_best(cells))
