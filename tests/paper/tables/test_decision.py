import pytest

from avobench.diagnosis.settings import SCORE
from paper.tables.decision import fitted, of_challenge, of_sealed


def test_the_decision_is_the_fit_to_the_committed_records():
    cases = [*of_challenge(), *of_sealed()]
    assert (len(cases), sum(case.kind == "outside" for case in cases)) == SCORE.calibrated
    assert fitted(cases) == pytest.approx([SCORE.sharpness, SCORE.several, SCORE.others, *SCORE.outside], abs=0.01)
