import pytest

from avobench.diagnosis.settings import SCORE
from paper.tables.outside import FOLDER, detected, regression


def test_the_probability_of_what_is_outside_is_the_regression_on_the_committed_records():
    _, out, model = regression(detected(FOLDER))
    assert (len(out), out.sum()) == SCORE.calibrated
    assert (model.intercept_[0], *model.coef_[0]) == pytest.approx(SCORE.outside, abs=0.01)
