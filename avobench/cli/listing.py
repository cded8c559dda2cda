"""Tables that the command line prints."""

import dataclasses
from typing import Any

import pandas as pd

from avobench.bench import registry
from avobench.bench.status import Status
from avobench.bench.table import labels, to_frame


def tasks_and_methods() -> str:
    """Every registered task and method, with what a user needs to run it."""
    lines = ["tasks"]
    for name in registry.names("task"):
        task = registry.build("task", name, {})
        lines.append(f"  {name}: {task.num_features} feature{'s' * (task.num_features > 1)} an event")
        for parameter, unit, low, high in zip(
            task.parameter_names, task.parameter_units, task.prior.low, task.prior.high, strict=True
        ):
            lines.append(f"    {parameter} ~ U({low:g}, {high:g}){'' if unit == '1' else ' ' + unit}")
        lines += _settings(task)
    lines.append("methods")
    for name in registry.names("method"):
        method = registry.build("method", name, {})
        lines.append(f"  {name}: {method.source}")
        lines += _settings(method)
    lines.append("settings are changed with --set NAME.SETTING=VALUE")
    return "\n".join(lines)


def status_table(records: list[dict[str, Any]]) -> str:
    """One line a task and method: cells, failures, median squared error, its ratio to the floor, seconds a cell."""
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    frame["ok"] = frame["status"] == Status.OK
    frame["ratio"] = frame["squared_error"] / frame["floor"]
    frame["seconds"] = frame["simulator_seconds"] + frame["method_seconds"]
    groups = frame.groupby(["task", "method"], sort=True)
    table = pd.DataFrame(
        {
            "targets": groups["target"].nunique(),
            "cells": groups.size(),
            "ok": groups["ok"].sum(),
            "median squared error": groups["squared_error"].median(),
            "median error / floor": groups["ratio"].median(),
            "simulations": groups["simulations_used"].max(),
            "seconds a cell": groups["seconds"].mean().round(1),
        }
    ).reset_index()
    return table.to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")


def _settings(instance: object) -> list[str]:
    if not dataclasses.is_dataclass(instance):
        return []
    settings = [f"{f.name}={getattr(instance, f.name)}" for f in dataclasses.fields(instance) if f.init]
    return [f"    settings: {', '.join(settings)}"] if settings else []
