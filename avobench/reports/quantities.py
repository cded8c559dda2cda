"""What figures, targets and pages compute from records."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import chi2
from scipy.stats.qmc import Sobol

from avobench.bench import registry
from avobench.bench.status import ESTIMATED
from avobench.bench.table import labels, to_frame
from avobench.tasks import Task


def labelled(records: list[dict[str, Any]]) -> pd.DataFrame:
    """One row a cell, with the labels of its task and method in place of their names, and the `record` itself.

    `ratio` is the squared error over the floor. A cell that failed has an infinite squared error: it is as far from the
    truth as can be, and no median leaves it out. A doubtful one has the error that it has.
    """
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    frame["ratio"] = frame["squared_error"] / frame["floor"]
    frame.loc[~frame["status"].isin(ESTIMATED), ["squared_error", "ratio"]] = np.inf
    frame["seconds"] = frame["simulator_seconds"] + frame["method_seconds"]
    frame["record"] = records
    return frame


def comparable(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells of a task whose target every method has; all of them where no target is in common."""
    common = set.intersection(*(set(own["target"]) for _, own in cells.groupby("method")))
    return cells[cells["target"].isin(common)] if common else cells


def task_of(record: dict[str, Any]) -> Task | None:
    """The task of a record, with its settings; None where it is not registered here, or in another version."""
    if record["task"] not in registry.names("task"):
        return None
    task = registry.build("task", record["task"], record["task_settings"])
    return task if task.version == record["task_version"] else None


def efficient_median(shares: tuple[float, ...]) -> float:
    """Median of an efficient estimator's squared error over its expectation, the floor.

    That is the median of sum_i share_i z_i^2 with independent Gaussian z_i of unit variance: 0.455 for one parameter.
    """
    z_squared = chi2.ppf(Sobol(len(shares), seed=0).random_base2(16), 1)
    return float(np.median(z_squared @ np.array(shares)))


def inefficiency(ratios: pd.Series, shares: tuple[float, ...]) -> float:
    """Median ratio of squared error to floor, over what it is for an efficient estimator: 1 is the best there is."""
    return float(ratios.median() / efficient_median(shares))


def asymmetry_errors(cells: pd.DataFrame) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of cells of weinberg, the squared error of c(theta_hat) and its floor: (n,), (n,). A failure's is infinite."""
    errors, floors = [], []
    for record in cells["record"]:
        task, true = task_of(record), np.array(record["theta_true"])
        floors.append(task.asymmetry_floor(true, record["num_observations"], record["budget"]))
        found = record["theta_hat"]
        thetas = np.array([true, true if found is None else found])
        errors.append(np.inf if found is None else np.diff(task.asymmetry(thetas))[0] ** 2)
    return np.array(errors), np.array(floors)


def ideal_errors(cells: pd.DataFrame) -> NDArray[np.float64]:
    """Of cells of weinberg, the squared error of the posterior mean at the true c, the best on average: (n,)."""
    true = np.array([record["theta_true"] for record in cells["record"]])
    task = task_of(cells["record"].iloc[0])
    return ((task.posterior_mean(task.asymmetry(true)) - true) ** 2).sum(axis=1)
