"""Measures of the distance of estimates from the best possible ones, for targets, tables and claims."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.reports.quantities import asymmetry_errors, efficient_median, ideal_errors, interval, task_of

WORST_RUN = 100.0
"""Squared error over the floor that no run should exceed: beyond it a run went astray, as chance does not."""


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
