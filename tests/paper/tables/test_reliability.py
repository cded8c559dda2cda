"""Probabilities of a diagnosis against what was hidden."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.challenge.case import Case
from avobench.tasks.errors import UsageError
from avobench.tasks.poisson import Poisson
from paper.figures.reliability_diagram import draw
from paper.tables.reliability import by_chance, calibration_error, table


def case(probabilities, outside, hidden="dead_time", kind="foreign", series=3):
    answer = {"case": "0000", "kind": kind, "theta": [1.0]}
    answer["effects"] = [{"name": hidden, "feature": None, "series": series, "power": 1.0}]
    told = [{"name": name, "feature": None, "probability": p} for name, p in probabilities.items()]
    models = [{"effects": [{"name": name, "feature": None}], "probability": p} for name, p in probabilities.items()]
    diagnosis = {"verdict": "missing effect named", "probabilities": told, "outside": outside, "models": models}
    diagnosis |= {"alpha": 0.05, "p_value_after": 0.5}
    return Case(Poisson(), answer, {**diagnosis, "effects": []})


def test_one_right_and_one_wrong_case_give_their_scores():
    right = case({"dead_time": 0.8, "pile_up": 0.2}, 0.0)
    wrong = case({"dead_time": 0.1, "pile_up": 0.9}, 0.0)
    row, every = table([("series 3", right), ("series 3", wrong)]).to_dict("records")
    assert {**every, "hidden": "series 3"} == row
    assert row["most probable right"] == row["wrong, yet agrees"] == 0.5
    assert row["P(truth)"] == pytest.approx(0.45)
    assert row["Brier"] == pytest.approx((2 * 0.2**2 + 2 * 0.9**2) / 2)
    assert row["log score"] == pytest.approx(np.log(0.8 * 0.1) / 2)
    assert row["in the 95 % set"] == 1


def test_of_a_withheld_effect_the_truth_is_outside():
    row, _ = table([("withheld", case({"pile_up": 0.3}, 0.7, kind="withheld"))]).to_dict("records")
    assert row["P(truth)"] == row["P(outside)"] == pytest.approx(0.7)
    assert row["P(first name)"] == pytest.approx(0.3)
    assert row["in the 95 % set"] == 1


@given(st.integers(0, 100))
def test_probabilities_that_hold_have_next_to_no_calibration_error(seed):
    rng = np.random.default_rng(seed)
    told = rng.random(40_000)
    hit = rng.random(40_000) < told
    assert calibration_error(told, hit) < 0.02
    assert calibration_error(told, ~hit) > 0.4


def test_of_few_cases_chance_alone_gives_a_calibration_error():
    """Ten bins of two names of 50 %: of two coins the share of heads is 0.25 from a half on average."""
    assert by_chance(np.full(20, 0.5)) == pytest.approx(0.25, abs=0.02)
    assert by_chance(np.repeat([0.0, 1.0], 50)) == 0


def test_the_diagram_has_a_bin_of_what_came_true(tmp_path):
    cases = [case({"dead_time": 0.8}, 0.2)] * 8 + [case({"pile_up": 0.8}, 0.2)] * 2
    table = pd.read_csv(draw(cases, tmp_path)[2])
    assert table.names.sum() == 20
    likely = table[table.told > 0.5]
    assert np.average(likely.true, weights=likely.names) == pytest.approx(0.8)
    assert ((table.low <= table.true) & (table.true <= table.high)).all()
    with pytest.raises(UsageError, match="no case tells probabilities"):
        draw([], tmp_path)
