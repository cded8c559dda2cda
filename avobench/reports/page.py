"""One self-contained page of a results folder: figures, tables, and what stands behind each number."""

import base64
import json
import math
import tempfile
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, FileSystemLoader

from avobench.bench.status import Status
from avobench.bench.store import Store
from avobench.bench.table import labels, to_frame
from avobench.reports.benchmark import numbers
from avobench.reports.benchmark_claims import PRESETS
from avobench.reports.draw import STUDY_FIGURES, draw, records_for
from avobench.reports.quantities import comparable
from avobench.reports.reproduction import CLAIMS, gather
from avobench.reports.style import TASK_ORDER
from avobench.reports.targets import METHOD, RIVALS
from avobench.reports.targets import table as targets_table
from avobench.studies.paper import DETECTOR_FILE

CAPTIONS = {
    "benchmark": "Squared error of each method on each task (the paper's Figure 4). Boxes show quartiles, whiskers the "
    "extremes, points the cells; the dashed line is the median floor over the targets, the band spans their floors.",
    "weinberg": "Weinberg (the paper's Figure 5): the observed events, as points, and the density at each method's "
    "estimate, as lines, for the first targets.",
    "efficiency": "Squared error of the estimate after so many simulations: median and quartiles over the cells, from "
    "where all of them have an estimate. The dashed line is the floor with as many simulations.",
    "cost": "Wall time that a cell takes, simulator and method together, against its squared error. Small "
    "marks are cells, large ones medians; the dashed line is the median floor.",
    "poisson": "The paper's Figure 1: an unknown Poisson mean with and without a penalty on the proposal's entropy; "
    "each line is a run.",
    "alignment": "The paper's Figure 3: the detector's offset at 1 mm, found by avo-paper; each line is a run.",
    "detector": "The paper's Figure 2: average response of the detector and single events, at offsets of 0 and 1 mm.",
}


def render(results: Path, studies: Path | None) -> str:
    """The page on the records in the folder `results`, and in `studies` where that is given.

    Raises UsageError or StoreError when a folder cannot be read.
    """
    store = Store(results)
    records = store.read_all()
    frame = to_frame(records)
    figures = list(_figures(store, None if studies is None else Store(studies)))
    failed = int((frame["status"] != Status.OK).sum())
    template = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True, lstrip_blocks=True
    ).get_template("page.html.jinja")
    return template.render(
        title=f"records in {results}",
        lead=f"{len(records)} cells, {failed} failed; {frame['task'].nunique()} tasks, "
        f"{frame['method'].nunique()} methods. Squared errors are in the parameters' raw units; the floor is what the "
        "best estimator could expect. Click a column's name to sort by it.",
        figures=figures,
        tables=list(_tables(store, records, studies)),
    )


def _figures(store: Store, studies: Store | None) -> Iterator[dict[str, str]]:
    """The figures that the records allow."""
    has_weinberg = any((record["task"], record["status"]) == ("weinberg", Status.OK) for record in store.read_all())
    names = [name for name in CAPTIONS if name not in STUDY_FIGURES and (name != "weinberg" or has_weinberg)]
    sources = [(name, store) for name in names]
    if studies is not None:
        tasks = {record["task"] for record in studies.read_sound()}
        made = {name: f"{name}-example" in tasks for name in ("poisson", "alignment")}
        made["detector"] = (studies.path / DETECTOR_FILE).exists()
        sources += [(name, studies) for name in STUDY_FIGURES if made[name]]
    for name, source in sources:
        with tempfile.TemporaryDirectory() as folder:
            _, png, csv = draw(name, records_for(name, source), Path(folder))
            image, table = _data("image/png", png.read_bytes()), _data("text/csv", csv.read_bytes())
        yield {"name": name, "caption": CAPTIONS[name], "image": image, "csv": table}


def _tables(store: Store, records: list[dict[str, Any]], studies: Path | None) -> Iterator[dict[str, Any]]:
    frame = to_frame(records)
    frame["task"], frame["method"] = labels(records)
    compared = pd.concat([comparable(cells) for _, cells in frame.groupby("task", sort=False)])
    text = "Over the targets that all methods of a task have; what the box plots show."
    yield _table("summary", "Summary", text, numbers(compared))
    if METHOD in set(frame["method"]):
        text = "What avo should reach, beside what was measured of every method. Inefficiency is the median ratio of "
        text += "squared error to floor over that of an efficient estimator: 1 is the best possible."
        yield _table("targets", "Targets of avo", text, targets_table(records))
    wanted = product(TASK_ORDER, (PRESETS[0], *RIVALS))
    if studies is not None and {*wanted} <= {*zip(frame["task"], frame["method"], strict=True)}:
        evidence = gather(store.path, studies)
        found = [(claim.title, claim.where, claim.find(evidence)) for claim in CLAIMS]
        rows = [(title, where, finding.verdict, finding.reading) for title, where, finding in found]
        text = "What holds of the paper; docs/reproduction.md has the numbers."
        yield _table("claims", "Claims", text, pd.DataFrame(rows, columns=["claim", "where", "verdict", "criterion"]))
    columns = ["task", "method", "target", "repetition", "status", "squared_error", "floor", "simulations_used"]
    columns += ["simulator_seconds", "method_seconds", "started", "message", "id"]
    yield _table("cells", "Cells", "A row an inference; the download has every field.", frame[columns], frame)
    yield _table(
        "settings",
        "Settings, versions and commits",
        "What made the cells of each task and method: every combination that occurs.",
        provenance(records),
    )
    sweeps = pd.DataFrame(store.sweeps())
    if len(sweeps):
        sweeps["versions"] = sweeps["versions"].map(lambda versions: json.dumps(versions, sort_keys=True))
        yield _table("commands", "Commands", "The runs that made the records, oldest first.", sweeps)


def provenance(records: list[dict[str, Any]]) -> pd.DataFrame:
    """A row a task, method and combination of settings, commit and versions, with the number of its cells."""
    names = ["task", "task_version", "task_settings", "method", "method_version", "method_settings"]
    names += ["num_observations", "budget", "seed"]
    frame = to_frame(records)[names]
    frame["commit"] = [record["versions"]["commit"] for record in records]
    others = [{name: value for name, value in record["versions"].items() if name != "commit"} for record in records]
    frame["versions"] = [json.dumps(versions, sort_keys=True) for versions in others]
    return frame.value_counts(dropna=False, sort=False).rename("cells").reset_index()


def _table(id: str, title: str, text: str, frame: pd.DataFrame, full: pd.DataFrame | None = None) -> dict[str, Any]:
    """What the template shows of `frame`; its download holds `full`, where that is more."""
    rows = [[_cell(value) for value in row] for row in frame.itertuples(index=False)]
    content = (frame if full is None else full).to_csv(index=False).encode()
    return {
        "id": id,
        "title": title,
        "text": text,
        "columns": list(frame.columns),
        "rows": rows,
        "csv": _data("text/csv", content),
    }


def _cell(value: Any) -> dict[str, Any]:
    """A table's cell: the text shown, and the value by which it is sorted, empty where there is none."""
    if pd.isna(value):
        return {"text": "-", "value": "", "number": True}
    if isinstance(value, str):
        return {"text": value, "value": value, "number": False}
    shown = f"{value:.3g}" if isinstance(value, float) and math.isfinite(value) else str(value)
    return {"text": shown, "value": str(value).replace("inf", "Infinity"), "number": True}


def _data(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
