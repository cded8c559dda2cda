import pytest
from scipy.special import softmax

from avobench.diagnosis.settings import SCORE
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
