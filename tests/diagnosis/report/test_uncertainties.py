import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.fit.fit import fit_at
from avobench.diagnosis.fit.surrogate import Design, surrogate
from avobench.diagnosis.report.uncertainties import Move, QuotedFit, ambiguity, covering


def test_theta_s_error_covers_another_solution_that_the_data_allow(counter):
    weak, strong = counter.weak, counter.strong
    assert strong.params[0] - weak.params[0] > 1.5
    some = [ambiguity(weak, weak, [strong], counter.target, np.random.default_rng(s), 300_000) for s in range(5)]
    moves = sorted(some, key=lambda moves: abs(moves[0].theta[0]))[2]  # the way is told by events, which scatter
    (before,), (after,) = QuotedFit(weak).theta.values(), QuotedFit(weak, moves).theta.values()
    assert before.value == after.value
    assert abs(counter.truth.strong[0] - before.value) > 2 * before.std
    assert abs(counter.truth.strong[0] - after.value) < 2 * after.std
    (known,) = QuotedFit(weak, moves).identified
    width = weak.model.high[0] - weak.model.low[0]
    assert known.std * width == pytest.approx(after.std)
    assert known.coefficients["log_rate"] == pytest.approx(1 / width)


def test_a_shape_that_the_data_exclude_does_not_widen_the_error(counter):
    model, target = counter.strong.model, counter.target
    unit = model.to_cube(np.array([1.0, 0.9]))
    s = surrogate(model, target, Design.box(unit, np.full(2, 0.01)), 20_000, np.random.default_rng(0))
    excluded = fit_at(model, s, target, unit)
    assert excluded.noiseless_q > counter.strong.noiseless_q + 100
    assert ambiguity(counter.strong, counter.strong, [excluded], target, np.random.default_rng(0), 20_000) == []


@given(st.floats(0.01, 2), st.floats(-3, 3), st.floats(0, 3.99), st.floats(0, 0.25))
def test_errors_only_grow_and_reach_every_allowed_value(std, shift, worse, own):
    move = Move(np.array([shift]), worse, np.array([[own**2]]))
    (covered,) = covering(np.array([std]), np.eye(1), [move])
    assert covered >= std
    assert 2 * covered >= abs(shift)
    assert 2 * covered <= max(2 * std, abs(shift) + 2 * own) + 1e-9
