"""The table of rivals: a row an answer, on its own targets, tested on those in common."""

import pytest

from paper.tables.rivals import table


def test_each_answer_has_a_row_on_its_own_targets_and_a_test_on_those_in_common(benchmark):
    chosen = [record for record in benchmark if not (record["method"] == "bolfi" and record["target"] >= 5)]
    exact = [{**r, "mean": r["theta_true"]} if r["method"] == "bolfi" else r for r in chosen]
    rows = table(exact).set_index(["task", "method", "answer"])
    assert rows.loc[("carl", "bolfi", "estimate"), "targets"] == 5
    assert rows.loc[("carl", "bolfi", "estimate"), "avo ahead"] == "p = 0.031"  # five of five: 1 / 2^5
    assert rows.loc[("carl", "abc-smc", "estimate"), "avo ahead"] == "p = 0.016"
    assert rows.loc[("carl", "bolfi", "mean"), "inefficiency"] == 0
    assert rows.loc[("carl", "bolfi", "mean"), "avo ahead"] == "p = 1"
    assert ("carl", "abc-smc", "mean") not in rows.index  # which is the estimate
    own = rows.loc[("carl", "avo", "estimate")]
    assert rows.loc[("carl", "bolfi", "estimate"), "inefficiency"] == pytest.approx(100 * own["inefficiency"], rel=0.5)
    assert own["avo ahead"] == "-"


def test_a_failed_run_counts_and_a_foreign_task_does_not(benchmark):
    mine = [{**record, "task": "mine"} for record in benchmark[:4]]
    nothing = {"status": "method_error", "theta_hat": None, "mean": None, "how": None, "spread_of": None}
    lost = [{**record, **nothing} if record["target"] else record for record in benchmark]
    rows = table([*lost, *mine]).set_index(["task", "method", "answer"])
    assert "mine" not in rows.index.get_level_values("task")
    assert rows.loc[("poisson", "avo", "estimate"), "worst run / floor"] == float("inf")
