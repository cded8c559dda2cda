"""One self-contained page of a results folder: figures, tables, and what stands behind each number."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from avobench.bench.store.frame import labels, to_frame
from avobench.bench.store.status import ESTIMATED
from avobench.bench.store.store import Store
from avobench.reports import html
from avobench.reports.benchmark import numbers
from avobench.reports.figures import drawn
from avobench.reports.quantities import comparable
from avobench.reports.style import csv, image

CAPTIONS = {
    "benchmark": "Squared error of each method on each task. Boxes show quartiles, whiskers the "
    "extremes, points the cells; the dashed line is the median floor over the targets, the band spans their floors.",
    "efficiency": "Squared error of the estimate after so many simulations: median and quartiles over the cells, from "
    "where all of them have an estimate. The dashed line is the floor with as many simulations.",
    "coverage": "The share of true parameters that lie within the central intervals a method quotes, from its standard "
    "error or its posterior, against the share that these intervals promise; on the dashed line the two agree.",
}
MOST_CELLS = 2000
"""Rows of the table of cells: a browser sorts and filters so many at once, and the page stays below some megabytes."""


def render(results: Path) -> str:
    """The page on the records in the folder `results`.

    What cannot be made is a sentence in its place. Raises UsageError or StoreError when the folder cannot be read.
    """
    store = Store(results)
    records = store.read_all()
    frame = to_frame(records)
    facts = {"cells": len(records), "failed": int((~frame["status"].isin(ESTIMATED)).sum())}
    facts |= {"tasks": frame["task"].nunique(), "methods": frame["method"].nunique()}
    frame["task"], frame["method"] = labels(records)
    tables: dict[str, Callable[[], html.Table]] = {"summary": partial(_summary, frame), "cells": partial(_cells, frame)}
    tables["settings"] = partial(_settings, records)
    if sweeps := store.sweeps():
        tables["commands"] = partial(_commands, sweeps)
    return html.page(
        "page.html.jinja",
        title=f"records in {results}",
        facts=facts,
        lead="Squared errors are in the parameters' raw units; the floor is what the best estimator could expect.",
        figures=[html.made(name, partial(_picture, name, records)) for name in CAPTIONS],
        tables=[html.made(name, make) for name, make in tables.items()],
    )


def _picture(name: str, records: list[dict[str, Any]]) -> html.Picture:
    figure, table = drawn(name, records)
    return html.Picture(name, CAPTIONS[name], image(figure, "png"), html.address("text/csv", csv(table)))


def _summary(frame: pd.DataFrame) -> html.Table:
    text = "Over the targets that all methods of a task have; what the box plots show."
    return _table("summary", "Summary", text, numbers(comparable(frame)))


def _cells(frame: pd.DataFrame) -> html.Table:
    columns = ["task", "method", "target", "repetition", "status", "squared_error", "floor", "simulations_used"]
    columns += ["simulator_seconds", "method_seconds", "started", "message", "id"]
    if len(frame) <= MOST_CELLS:
        return _table("cells", "Cells", "One row per inference; the download has every field.", frame[columns], frame)
    text = f"One row per inference: {MOST_CELLS} of {len(frame)}, first those that failed, then those with the largest "
    text += (
        "squared error above their floor. The summary counts all; the download has the rows shown, `avobench export` "
    )
    text += "writes every row and field."
    failed, above = ~frame["status"].isin(ESTIMATED), frame["squared_error"] / frame["floor"]
    shown = frame.assign(failed=failed, above=above).sort_values(["failed", "above"], ascending=False, kind="stable")
    return _table("cells", "Cells", text, shown[columns].head(MOST_CELLS))


def _settings(records: list[dict[str, Any]]) -> html.Table:
    text = "What made the cells of each task and method: every combination that occurs."
    return _table("settings", "Settings, versions and commits", text, provenance(records))


def _commands(sweeps: list[dict[str, Any]]) -> html.Table:
    frame = pd.DataFrame(sweeps)
    frame["versions"] = frame["versions"].map(lambda versions: json.dumps(versions, sort_keys=True))
    return _table("commands", "Commands", "The runs that made the records, oldest first.", frame)


def provenance(records: list[dict[str, Any]]) -> pd.DataFrame:
    names = ["task", "task_version", "task_settings", "method", "method_version", "method_settings"]
    names += ["num_observations", "budget", "seed"]
    frame = to_frame(records)[names]
    frame["commit"] = [record["versions"]["commit"] for record in records]
    others = [{name: value for name, value in record["versions"].items() if name != "commit"} for record in records]
    frame["versions"] = [json.dumps(versions, sort_keys=True) for versions in others]
    return frame.value_counts(dropna=False, sort=False).rename("cells").reset_index()


def _table(id: str, title: str, text: str, frame: pd.DataFrame, full: pd.DataFrame | None = None) -> html.Table:
    """A table of the page with the content of `frame`; its download holds `full`, where that is more."""
    content = (frame if full is None else full).to_csv(index=False).encode()
    shown = frame.assign(
        **{name: frame[name].map(plain, na_action="ignore") for name, plain in PLAIN.items() if name in frame}
    )
    columns = {name: html.column(shown[name]) for name in shown}
    return html.Table.of(id, title, text, columns, html.address("text/csv", content))


def _pairs(settings: str) -> str:
    """Settings or versions, kept as JSON, as a person writes them: `radius=3.2, response="hit"`."""
    return ", ".join(f"{name}={json.dumps(value)}" for name, value in json.loads(settings).items())


def _moment(started: str) -> str:
    """The time at which a record was begun, in UTC, to the minute: `2026-11-21 20:40`."""
    return started[: len("2026-11-21T20:40")].replace("T", " ")


PLAIN = {"task_settings": _pairs, "method_settings": _pairs, "versions": _pairs, "started": _moment}
"""Functions that make the text shown of columns of these names; the download has them as they are in the records."""
