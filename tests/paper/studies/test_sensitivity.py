"""The table of plain Algorithm 1, and the preset that is chosen from it."""

import json

import numpy as np
import pytest

from avobench.bench.cells.trial import blank_record
from avobench.bench.plugins import registry
from avobench.bench.store.status import Status
from avobench.methods.avo_paper import AvoPlain
from paper.studies.sensitivity import CANDIDATES, TASKS, candidate, cells
from paper.tables.sensitivity import table


def test_no_candidate_is_another_s_double():
    ids = [cell.id for cell in cells()]
    assert len(ids) == len(set(ids))
    assert {cell.identity["method"] for cell in cells()} == {"avo-paper"}


def test_the_preset_is_one_of_the_candidates():
    settings = registry.identity("method", "avo-plain", AvoPlain())["method_settings"]
    assert json.loads(json.dumps(settings)) in [cell.identity["method_settings"] for cell in cells()]


def made(cell, ratio, trace):
    record = blank_record(cell, Status.OK, "") | {"squared_error": ratio, "floor": 1.0, "trace": trace}
    return record | {"theta_hat": record["theta_true"], "simulator_seconds": 1.0, "method_seconds": 2.0}


def test_a_row_has_the_worst_stillness_and_is_left_out_without_all_its_records():
    labels = list(CANDIDATES)[:2]
    moving = [{"simulations": n, "theta": [float(n)], "std": [1.0]} for n in range(5)]
    standing = moving[:3] + [moving[2]] * 2
    records = {}
    for label in labels:
        for task in TASKS:
            for cell in candidate(label, task):
                records[cell.id] = made(cell, 10.0, standing if task == "carl" else moving)
    last = candidate(labels[1], "carl")[-1].id
    rows = table({id: record for id, record in records.items() if id != last})
    assert rows["settings"].tolist() == [labels[0]]
    rows = table(records).set_index("settings")
    assert rows["still"].tolist() == ["50%", "50%"]
    assert rows["seconds"].tolist() == [3.0, 3.0]
    assert rows["geometric mean"].tolist() == pytest.approx(np.sqrt(rows["poisson"] * rows["carl"]).tolist())
    records[last] |= {"status": Status.METHOD_ERROR, "theta_hat": None, "trace": []}
    assert np.isinf(table(records)["carl"].iloc[1])
