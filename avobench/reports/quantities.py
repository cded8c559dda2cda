"""Quantities that figures and pages compute from records."""

from typing import Any

import numpy as np
import pandas as pd

from avobench.bench.plugins import registry
from avobench.bench.store.frame import labels, to_frame
from avobench.bench.store.status import ESTIMATED
from avobench.tasks import Task


def labelled(records: list[dict[str, Any]]) -> pd.DataFrame:
    """One row per cell, with the labels of its task and method in place of their names, and the `record` itself.

    `ratio` is the squared error over the floor. A cell that failed has an infinite squared error.
    """
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    frame["ratio"] = frame["squared_error"] / frame["floor"]
    frame.loc[~frame["status"].isin(ESTIMATED), ["squared_error", "ratio"]] = np.inf
    frame["seconds"] = frame["simulator_seconds"] + frame["method_seconds"]
    frame["record"] = records
    return frame


def comparable(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells whose target every method of their task has; all of a task where no target is in common."""
    parts = []
    for _, of_task in cells.groupby("task", sort=False):
        common = set.intersection(*(set(of_method["target"]) for _, of_method in of_task.groupby("method")))
        parts.append(of_task[of_task["target"].isin(common)] if common else of_task)
    return pd.concat(parts)


def task_of(record: dict[str, Any]) -> Task | None:
    """The task of a record, with its settings; None where it is not registered here, or in another version."""
    if record["task"] not in registry.names("task"):
        return None
    task = registry.build("task", record["task"], record["task_settings"])
    return task if task.version == record["task_version"] else None
