"""Records as a table: one row per cell, unlike ones apart."""

import io

import numpy as np
import pandas as pd
import pytest

from avobench.bench.cells.trial import execute
from avobench.bench.store.frame import as_csv, labels, to_frame
from avobench.bench.sweep.plan import plan


def records(budget=400, settings=()):
    cells = plan(["toys:Normal"], ["toys:Moment"], "0-1", 1, budget, 100, 0, list(settings))
    return [execute(cell) for cell in cells]


def test_the_table_has_a_row_a_cell_and_the_promised_columns():
    frame = to_frame([*records(), *records(settings=["moment.fault=raises"])])
    assert len(frame) == 4
    promised = "task method target repetition seed status message theta_true_0 theta_hat_0 squared_error floor"
    promised += " num_observations budget simulations_used simulator_seconds method_seconds"
    assert set(promised.split()) <= set(frame)
    assert frame.loc[frame["status"] != "ok", ["theta_hat_0", "squared_error"]].isna().all(axis=None)


def test_standard_errors_are_a_column_for_each_parameter_as_the_estimates_are():
    first, second = records()
    assert not any(name.startswith("standard_error") for name in to_frame([first, second]))
    frame = to_frame([{**first, "standard_error": [0.5]}, second])
    assert "standard_error" not in frame
    np.testing.assert_array_equal(frame["standard_error_0"], [0.5, np.nan])


def test_like_named_methods_of_other_settings_are_never_pooled():
    mixed = [*records(), *records(settings=["moment.steps=2"]), *records(budget=800)]
    tasks, methods = labels(mixed)
    assert methods == ["moment steps=4"] * 2 + ["moment steps=2"] * 2 + ["moment steps=4"] * 2
    assert tasks == ["normal budget=400"] * 4 + ["normal budget=800"] * 2
    assert labels(records()) == (["normal"] * 2, ["moment"] * 2)


def test_of_a_method_of_this_package_the_settings_are_told_that_are_not_its_defaults():
    made = []
    for settings in [], ["smm.rounds=4"], ["smm.rounds=4", "smm.shrink=0.3"]:
        made += [dict(cell.identity) for cell in plan(["poisson"], ["smm"], "0", 1, 400, 100, 0, settings)]
    assert labels(made)[1] == ["smm", "smm rounds=4", "smm rounds=4 shrink=0.3"]
    assert labels(made[1:])[1] == ["smm", "smm shrink=0.3"]  # what all have is not told


def test_nor_are_those_of_which_some_leave_a_setting_out_at_its_default():
    plain = records()
    other = [record | {"method_settings": record["method_settings"] | {"added_later": 2}} for record in plain]
    assert labels([*plain, *other])[1] == ["moment"] * 2 + ["moment added_later=2"] * 2


@pytest.mark.parametrize("text", ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "x\r=1"])
def test_no_text_of_a_csv_is_a_formula_and_all_else_is_as_it_was(text):
    frame = to_frame(records())
    plain = frame.assign(message=["-1.5", "a=b"])
    assert as_csv(plain) == plain.to_csv(index=False).encode()
    read = pd.read_csv(io.BytesIO(as_csv(frame.assign(message=text))))
    assert read["message"].tolist() == [f"'{text}" if text[0] != "x" else "x\n=1"] * 2
