"""The tables of the studies beyond the paper's: inefficiency against parameters, and coverage on fresh targets."""

import numpy as np
import pandas as pd
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.tasks.errors import StoreError
from paper.figures import dimension
from paper.studies.fresh import TASKS
from paper.tables import fresh


@pytest.fixture(scope="module")
def records():
    """Runs of smm on both families and two numbers of parameters, with few events."""
    return [
        execute(Cell(f"{family}-{p}", {}, "smm", {}, target, 0, 4000, 2000, 0))
        for family in ("warped", "means")
        for p in (5, 2)
        for target in range(2)
    ]


def at(record, ratio, status="ok"):
    """The record with an estimate whose squared error is so many floors, at two of its quoted standard errors."""
    p, error = len(record["theta_true"]), np.sqrt(ratio * record["floor"] / len(record["theta_true"]))
    found = (np.array(record["theta_true"]) + error).tolist()
    own = {"theta_hat": found, "squared_error": ratio * record["floor"], "standard_error": [error / 2] * p}
    return {**record, **own, "status": status}


def test_a_row_has_the_numbers_of_its_family_parameters_and_method(records, tmp_path):
    told = [at(record, 1000 if record["task"] == "warped-5" else 0.5) for record in records]
    told[0]["status"] = "doubtful"
    assert told[0]["task"] == "warped-5"
    rows = dimension.table([*told, {**told[0], "task": "poisson"}]).set_index(["family", "parameters"])
    assert rows.index.tolist() == [("warped", 2), ("warped", 5), ("means", 2), ("means", 5)]
    assert rows["targets"].tolist() == [2] * 4
    assert rows["above 100"].tolist() == [0, 2, 0, 0]
    assert rows["of these ok"].tolist() == [0, 1, 0, 0]
    assert rows.loc[("means", 2), "inefficiency"] == pytest.approx(0.5 / np.log(2), rel=0.01)  # chi2 of 2, its median
    assert rows.loc[("warped", 5), "worst run / floor"] == pytest.approx(1000)
    paths = dimension.draw(told, tmp_path)
    assert pd.read_csv(paths[2])["inefficiency"].to_numpy() == pytest.approx(rows["inefficiency"], rel=1e-5)


def test_the_detector_with_three_parameters_has_a_row_of_its_own(records):
    detector = {**at(records[0], 3.0), "task": "alignment-3", "theta_true": [0.0] * 3}
    rows = dimension.table([at(records[0], 2.0), detector])
    assert rows[["family", "parameters"]].to_numpy().tolist() == [["warped", 5], ["alignment", 3]]
    assert rows["worst run / floor"].tolist() == pytest.approx([2.0, 3.0])


def test_without_a_record_of_the_study_there_is_no_figure(records, tmp_path):
    with pytest.raises(StoreError, match="study dimension"):
        dimension.draw([{**records[0], "task": "poisson"}], tmp_path)


def test_fresh_targets_are_scored_by_their_task_and_a_quoted_error_by_what_it_covers():
    own = [task for task in TASKS if task.of.name in ("poisson", "warped-2", "weinberg")]
    made = [
        execute(Cell(f"paper.studies.fresh:{task.__name__}", {}, "smm", {}, target, 0, 4000, 2000, 0))
        for task in own
        for target in range(2)
    ]
    assert {record["status"] for record in made} <= {"ok", "doubtful"}
    close, far = (at(record, ratio) for record, ratio in zip(made[:2], (0.1, 1e4), strict=True))
    far["standard_error"] = (np.abs(np.subtract(far["theta_hat"], far["theta_true"])) * 2).tolist()
    rows = fresh.table([close, far, *made[2:]]).set_index("task")
    assert rows.index.tolist() == ["poisson", "weinberg", "warped-2"]
    assert rows.loc["poisson", ["astray", "ok of these"]].tolist() == [1, 1]
    assert rows.loc["poisson", ["within 68%", "within 95%"]].tolist() == ["50%", "50%"]
    assert rows.loc["poisson", "mean / floor"] == pytest.approx(
        (0.1 * close["floor"] + 1e4 * far["floor"]) / (close["floor"] + far["floor"])
    )


def test_without_a_quoted_error_there_is_no_coverage(records):
    silent = [{name: value for name, value in records[0].items() if name != "standard_error"}]
    assert fresh.table([{**silent[0], "spread_of": "proposal"}])["within 68%"].tolist() == ["-"]
