"""Records as a table, for pandas, and the labels that keep unlike records apart in it."""

import json
from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.bench.plugins import registry
from avobench.tasks.errors import UsageError

FORMULA = ("=", "+", "-", "@")
"""A spreadsheet carries out a text that begins with one of these."""


def to_frame(records: Iterable[dict[str, Any]]) -> pd.DataFrame:
    """One row per cell; lists over parameters become columns `theta_true_0`, `theta_true_1`, ...; no trace.

    There are columns of `standard_error` only where a record has one.
    """
    rows, once = [], {}  # many records have the same settings: each text is kept once
    for record in records:
        row = dict(record)
        for name in ("theta_true", "theta_hat", "mean", "std"):
            values = row.pop(name) or [None] * len(record["theta_true"])
            row |= {f"{name}_{i}": value for i, value in enumerate(values)}
        row |= {f"standard_error_{i}": value for i, value in enumerate(row.pop("standard_error", None) or [])}
        for name in ("task_settings", "method_settings", "versions"):
            text = json.dumps(row[name], sort_keys=True)
            row[name] = once.setdefault(text, text)
        row["parameter_names"] = " ".join(row["parameter_names"])
        row.pop("trace", None)  # a sweep keeps none
        rows.append(row)
    frame = pd.DataFrame(rows)
    per_parameter = frame.columns[frame.columns.str.fullmatch(r"(theta_true|theta_hat|mean|std|standard_error)_\d+")]
    numbers = [*per_parameter, "squared_error", "floor", "floor_likelihood", "peak_memory_mib"]
    frame[numbers] = frame[numbers].astype(float)
    counts = [f"simulations_{what}" for what in ("requested", "used", "discarded", "refused")]
    frame[counts] = frame[counts].astype("Int64")
    leading = ["task", "method", "target", "repetition", "seed", "status", "message", *sorted(per_parameter)]
    leading += ["squared_error", "floor", "num_observations", "budget", "simulations_used"]
    leading += ["simulator_seconds", "method_seconds"]
    return frame[leading + [name for name in frame.columns if name not in leading]].copy()  # in one piece


def as_csv(frame: pd.DataFrame) -> bytes:
    """A table as CSV. A text that a spreadsheet would take for a formula begins with an apostrophe; numbers stay."""
    texts = frame.select_dtypes(exclude="number")
    return frame.assign(**texts.map(_cell)).to_csv(index=False).encode()


def _cell(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    text = "\n".join(value.splitlines())  # pandas does not quote a carriage return, which ends a row for others
    try:
        float(text)
    except ValueError:
        return f"'{text}" if text.lstrip().startswith(FORMULA) else text
    return text


def mean_errors(records: list[dict[str, Any]]) -> NDArray[np.float64]:
    """The squared error of the mean of each record's posterior (n,); NaN where it is not known."""
    errors = []
    for record in records:
        has_mean = record["spread_of"] == "posterior" and None not in record["mean"]
        shift = np.subtract(record["mean"], record["theta_true"]) if has_mean else np.nan
        errors.append(np.sum(np.square(shift)))
    return np.array(errors)


def labels(records: list[dict[str, Any]]) -> tuple[list[str], list[str]]:
    """A label for the task and for the method of each record: its name, and whatever else tells like-named ones apart.

    So records of two settings, versions, budgets or numbers of observations are never pooled. Settings and versions
    are told where they differ within a method, budget and observations where they differ within a task. A setting that
    has its default now is not told.
    """
    common = ("budget", "num_observations")
    tasks = _labels(records, "task", lambda record: record["task"], common)
    return tasks, _labels(records, "method", lambda record: (record["task"], record["method"]), ())


@cache
def _defaults(kind: str, name: str) -> dict[str, Any]:
    """The settings of a task or method of this package; none where it is not one, or is not to be had here."""
    if name not in registry.names(kind) or registry.runs_theirs(kind, name):
        return {}
    try:
        return json.loads(json.dumps(registry.settings_of(registry.build(kind, name, {}))))
    except UsageError:
        return {}


def _labels(
    records: list[dict[str, Any]], kind: str, group: Callable[[dict[str, Any]], Any], common: tuple[str, ...]
) -> list[str]:
    parts = [
        {"version": record[f"{kind}_version"], "source": record.get(f"{kind}_source_sha256", "built-in")[:8]}
        | {name: record[name] for name in common}
        | record[f"{kind}_settings"]
        for record in records
    ]
    alike: dict[Any, list[dict[str, str]]] = {}
    for record, part in zip(records, parts, strict=True):
        alike.setdefault(group(record), []).append({name: json.dumps(value) for name, value in part.items()})
    differ = {  # from one that lacks a setting, too: it may be left out at its default
        key: {name for name in set().union(*texts) if len({text.get(name) for text in texts}) > 1}
        for key, texts in alike.items()
    }
    result = []
    for record, part in zip(records, parts, strict=True):
        names = differ[group(record)]
        usual = _defaults(kind, record[kind]) if names else {}
        settings = {name: value for name, value in part.items() if name in names and usual.get(name, ...) != value}
        extra = [f"{name}={value}".replace(" ", "") for name, value in settings.items()]
        result.append(" ".join([record[kind], *extra]))
    return result
