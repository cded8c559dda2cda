"""The table of the ablation compares like with like."""

import math

import pytest

from avobench.bench.cells.trial import blank_record
from avobench.bench.store.status import Status
from avobench.bench.store.store import Store
from paper.studies.paper import ABLATION_TASKS, ABLATIONS, ablation, cells
from paper.tables.ablation import table


def test_every_difference_makes_other_cells_on_the_same_targets():
    for settings, tasks in ABLATIONS.values():
        for task in tasks:
            own, plain = ablation(task, settings), ablation(task, {})
            assert not {cell.id for cell in own} & {cell.id for cell in plain}
            assert [(c.target, c.repetition, c.seed) for c in own] == [(c.target, c.repetition, c.seed) for c in plain]
    ids = [cell.id for cell in cells("ablation")]
    assert len(ids) == len(set(ids))
    assert {cell.task for cell in cells("ablation")} == set(ABLATION_TASKS)


def test_a_target_that_lacks_a_record_of_any_row_is_in_none(tmp_path):
    store = Store(tmp_path, create=True)
    rows = {"avo as it is": {}} | {label: settings for label, (settings, tasks) in ABLATIONS.items() if "carl" in tasks}
    for i, (label, settings) in enumerate(rows.items()):
        for cell in ablation("carl", settings):
            ratio = 1 + i if cell.target == 0 else 1000
            true = cell.identity["theta_true"]
            found = [true[0] + math.sqrt(1e-4 * ratio), true[1]]
            scored = {"squared_error": (found[0] - true[0]) ** 2, "floor": 1e-4, "theta_hat": found}
            scored |= {"how": "", "spread_of": "proposal", "mean": found, "std": [1.0, 1.0]}
            scored |= {f"simulations_{what}": 0 for what in ("requested", "used", "discarded", "refused")}
            if cell.target == 0 or (cell.target == 1 and label != "fresh events only"):
                store.write({**blank_record(cell, Status.OK, ""), **scored})
    shown = table((tmp_path,))
    column = shown["carl, 1 targets"]
    efficient = 0.53  # median of an efficient estimator's squared error over the floor, for carl's two parameters
    for i, label in enumerate(rows):
        inefficiency, worst = column[label].split(" ")
        assert float(inefficiency) == pytest.approx((1 + i) / efficient, rel=0.05)
        assert worst == f"({1 + i:.2g})"
    assert column["images not summed"] == ""
    assert (shown["poisson, 0 targets"] == "").all()
