import pytest
from scipy.special import softmax

from avobench.diagnosis.settings import SCORE
from paper.tables.decide import column
from paper.tables.decision import FAMILIES, by_others, fitted, told


def test_the_decision_is_the_fit_to_the_committed_records():
    cases = told()
    assert (len(cases), sum(case.kind == "outside" for case in cases)) == SCORE.calibrated
    families = [SCORE.families[name] for name in FAMILIES]
    assert fitted(cases) == pytest.approx([*SCORE.decision, SCORE.outside, SCORE.others, *families], abs=0.01)


def test_each_case_is_told_by_a_fit_to_others():
    """With one simulator alone nothing is left to fit, and the numbers are those of their priors."""
    cases = told()
    one = [case for case in cases if case.simulator == cases[0].simulator]
    [shares] = by_others(one[:1])
    assert shares == pytest.approx(softmax(one[0].marks @ fitted([])))


def test_what_was_said_to_decide_is_counted_by_what_was_found_anew():
    pair = {"true": ["a"], "rival": ["b"], "events": 1000}
    anew = {**pair, "named": ["b"], "best": ["a"], "models": [["a"], ["b"]]}
    asked = [pair | {"events": 0}, pair | {"events": None}, pair, anew, anew | {"named": ["a"], "models": [["a"]]}]
    said = column([{"truth": "a", "num_events": 2000, "asked": asked}])
    counts = {name.strip(): text.split(" (")[0] for name, text in said.items()}
    assert counts["pairs with the hidden family"] == "5"
    assert counts["no number is known"] == counts["enough are measured"] == "1"
    assert counts["the hidden one is first"] == "1 of 1"
    assert counts["times as many events, median"] == "1.5"
    assert [counts[f"{what}"] for what in ("the hidden one is named", "it has more evidence")] == ["1 of 2", "2 of 2"]
    assert counts["it is alone in the 95 % set"] == "1 of 2"
