"""The tables of the experiments compare like with like, from records whose errors are known."""

from pathlib import Path

import numpy as np
import pytest

from avobench.bench.cells.trial import blank_record
from avobench.bench.store.status import Status
from paper.experiments import BUDGETS, EXPERIMENTS, Runs, records_of
from paper.quantities import efficient_median
from paper.tables import experiments as tables

EFFICIENT = efficient_median((0.1, 0.9))
"""Median of an efficient estimator's squared error over the floor, for carl's two parameters."""
LOST = {"bump", "slcp"}
"""The tasks on which `avo` stays far from the floor, however many events it simulates."""


def made(cell, ratio, **more):
    record = blank_record(cell, Status.OK, "") | {"squared_error": ratio, "floor": 1.0, "trace": []}
    record |= {"theta_hat": record["theta_true"], "simulator_seconds": 1.0, "method_seconds": 2.0}
    return record | more


def test_a_target_that_lacks_a_record_of_any_row_is_in_none():
    runs = [Runs("avo as it is", "avo", {}, ("carl",)), *EXPERIMENTS["ablation"].runs]
    own = [run for run in runs if "carl" in run.tasks]
    records = [
        made(cell, 1 + i if cell.target == 0 else 1000.0)
        for i, run in enumerate(own)
        for cell in run.cells("carl")[:2]
        if cell.target == 0 or run.label != "fresh events only"
    ]
    shown = tables.ablation(records)
    column = shown["carl, 1 targets"]
    for i, run in enumerate(own):
        inefficiency, worst = column[run.label].split(" ")
        assert float(inefficiency) == pytest.approx((1 + i) / EFFICIENT, rel=0.05)
        assert worst == f"({1 + i:.2g})"
    assert column["images not summed"] == ""
    assert (shown["poisson, 0 targets"] == "").all()


def test_a_candidate_has_its_worst_stillness_and_no_row_without_all_its_records():
    runs, seed = EXPERIMENTS["sensitivity"].runs[:2], EXPERIMENTS["sensitivity"].seed
    moving = [{"simulations": n, "theta": [float(n)], "std": [1.0]} for n in range(5)]
    standing = moving[:3] + [moving[2]] * 2
    cells = [(task, cell) for run in runs for task in run.tasks for cell in run.cells(task, seed)]
    records = [made(cell, 10.0, trace=standing if "Carl" in task else moving) for task, cell in cells]
    assert tables.sensitivity(records[:-1])["settings"].tolist() == [runs[0].label]
    rows = tables.sensitivity(records)
    assert rows["still"].tolist() == ["50%", "50%"]
    assert rows["seconds"].tolist() == [3.0, 3.0]
    assert rows["geometric mean"].tolist() == pytest.approx(np.sqrt(rows["poisson"] * rows["carl"]).tolist())
    records[-1] |= {"status": Status.METHOD_ERROR, "theta_hat": None}
    assert np.isinf(tables.sensitivity(records)["carl"].iloc[1])


def test_each_answer_has_a_row_on_its_own_targets_and_a_test_on_those_in_common(benchmark):
    chosen = [record for record in benchmark if not (record["method"] == "bolfi" and record["target"] >= 5)]
    exact = [{**r, "mean": r["theta_true"]} if r["method"] == "bolfi" else r for r in chosen]
    mine = [{**record, "task": "mine"} for record in benchmark[:4]]
    rows = tables.rivals([*exact, *mine]).set_index(["task", "method", "answer"])
    assert "mine" not in rows.index.get_level_values("task")
    rows = rows.loc["carl"]
    bolfi, mean, own = (rows.loc[of] for of in (("bolfi", "estimate"), ("bolfi", "mean"), ("avo", "estimate")))
    assert (bolfi["targets"], bolfi["avo ahead"]) == (5, "p = 0.031")  # five of five: 1 / 2^5
    assert rows.loc[("abc-smc", "estimate"), "avo ahead"] == "p = 0.016"
    assert (mean["inefficiency"], mean["avo ahead"]) == (0, "p = 1")
    assert ("abc-smc", "mean") not in rows.index  # which is the estimate
    assert bolfi["inefficiency"] == pytest.approx(100 * own["inefficiency"], rel=0.5)
    assert own["avo ahead"] == "-"


def test_errors_that_fall_as_the_floor_does_stay_in_units_of_it(benchmark):
    own = [record for record in benchmark if (record["task"], record["method"]) == ("carl", "avo")]
    larger = [
        r | {"budget": 10 * r["budget"]} | {name: r[name] / 4 for name in ("floor", "squared_error")} for r in own
    ]
    [row] = tables.growth([*own, *larger]).to_dict("records")
    few, many = (value for name, value in row.items() if name.endswith("events"))
    assert few == pytest.approx(many) == pytest.approx(np.median([r["squared_error"] / r["floor"] for r in own]))
    assert row["worst"] >= many
    assert row["targets"] == len({record["target"] for record in own})


def test_with_a_million_events_the_errors_of_avo_are_a_few_floors_but_on_the_named_tasks():
    """The floor itself falls with the simulated events, so the errors fall too. docs/methods.md names the tasks."""
    folder = Path(__file__).parents[3] / EXPERIMENTS["growth"].folder
    rows = tables.growth(list(records_of([folder]).values()))
    own = rows[rows["method"] == "avo"].set_index("task")
    assert (own["targets"] == 4).all()
    assert own[f"{BUDGETS[-1]} events"].notna().all()
    ratios = own[f"{BUDGETS[-1]} events"].drop(list(LOST))
    assert len(ratios) == 14
    assert ratios.pop("gaussian-mixture") < 8
    assert (ratios < 4).all()
