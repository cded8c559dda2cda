"""Met and not met, from records whose errors are known."""

import numpy as np
import pytest

from paper.quantities import efficient_median
from paper.tables.targets import table


def measured(records):
    return table(records).set_index(["task", "quantity"])


def test_numbers_and_verdicts_follow_from_the_records(benchmark):
    rows = measured(benchmark)
    ratios = [record["squared_error"] / record["floor"] for record in benchmark if record["task"] == "carl"][:6]
    own = rows.loc[("carl", "inefficiency")]
    assert own["avo"] == pytest.approx(np.median(ratios) / efficient_median((0.1, 0.9)))
    assert own["verdict"] == "met"
    assert own["bolfi"] == pytest.approx(own["avo"] * 100)  # ten times the offset
    assert rows.loc[("carl", "worst run / floor"), "avo"] == pytest.approx(max(ratios))
    won = rows.loc[[("carl", "against the rivals"), ("poisson", "against the rivals")], "verdict"]
    assert (won == "met, p = 0.0156").all()  # six of six targets: 1 / 2^6
    low, high = (float(end) for end in own["95 %"].strip("[]").split(", "))
    assert low <= own["avo"] * 1.01
    assert own["avo"] <= high * 1.01
    assert own["bolfi mean"] == pytest.approx(own["bolfi"])  # the mean of these records is their estimate


def test_a_limit_counts_on_both_sides(make_record):
    floor = make_record("alignment", "avo", 0, 0.0)["floor"]
    for inefficiency, verdict in ((2.49, "met"), (2.51, "not met")):
        offset = np.sqrt(inefficiency * efficient_median((1.0,)) * floor)
        row = measured([make_record("alignment", "avo", 0, offset)]).loc[("alignment", "inefficiency")]
        assert (row["avo"], row["verdict"]) == (pytest.approx(inefficiency), verdict)
