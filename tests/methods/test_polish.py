"""The polish against answers known in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.methods.polish import Fold, Polished, narrower, polish, polish_closer

EDGE = 4.0


def folds_of(real, synthetic, u):
    """Two, as avo makes them."""
    real, synthetic = real.astype(np.float32), synthetic.astype(np.float32)
    return [Fold(real[half::2], synthetic[half::2], u[half::2]) for half in range(2)]


def polished(real, synthetic, u, start, std=0.3, toward=0.0):
    ones = np.ones(u.shape[1])
    folds = folds_of(real, synthetic, u)
    return polish(folds, start * ones, np.diag(std * ones), (-EDGE * ones, EDGE * ones), toward)


@settings(max_examples=25)
@given(st.integers(0, 2**32), st.floats(-1.5, 1.5), st.floats(-0.3, 0.3))
def test_estimate_and_error_of_a_gaussian_mean(seed, truth, off):
    """x ~ N(u, 1): the best estimate is the observed mean minus that simulated at the same place."""
    rng = np.random.default_rng(seed)
    u = rng.normal(truth + off, 0.3, (20_000, 1))
    real, synthetic = rng.normal(truth, 1, (10_000, 1)), rng.normal(u, 1)
    answer = polished(real, synthetic, u, truth + off)
    assert answer.converged
    assert abs(answer.mean[0] - truth) < 5 * answer.error[0]
    best = np.sqrt(1 / 10_000 + 1 / 20_000)
    assert best < answer.error[0] < 1.4 * best
    assert abs(answer.mean[0] - real.mean()) < 5 * np.sqrt(answer.error[0] ** 2 - 1 / 10_000)


def test_the_width_of_the_proposal_does_not_bias_a_curved_mean():
    """E[x | u] = exp u / 4, where an average over N(u, 0.3^2) would be 4.6 % too large, seven standard errors of u."""
    rng = np.random.default_rng(1)
    u = rng.normal(1.2, 0.3, (200_000, 1))
    real, synthetic = rng.normal(np.exp(1) / 4, 1, (200_000, 1)), rng.normal(np.exp(u) / 4, 1)
    answer = polished(real, synthetic, u, 1.2)
    assert abs(answer.mean[0] - 1) < 3 * answer.error[0]
    assert answer.error[0] < 0.007


def test_a_closer_look_finds_what_a_quadratic_misses_and_else_lets_the_wide_answer_stand():
    """E[x | u] = exp(3 u / 2) over a standard Gaussian of u is no quadratic; E[x | u] = u is one."""
    rng = np.random.default_rng(6)
    u, bounds = rng.normal(size=(60_000, 1)), (np.array([-EDGE]), np.array([EDGE]))
    begin = np.zeros(1), np.eye(1), bounds
    for curve, curved in ((lambda u: np.exp(1.5 * u), True), (lambda u: u, False)):
        real, synthetic = rng.normal(curve(-0.7), 1, (60_000, 1)), rng.normal(curve(u), 1)
        folds = folds_of(real, synthetic, u)
        wide = polish(folds, *begin)
        answer, root = polish_closer(folds, *begin, (0.35, 10.0))
        assert (abs(wide.mean[0] + 0.7) > 5 * wide.error[0]) == curved
        assert not curved or abs(answer.mean[0] + 0.7) < abs(wide.mean[0] + 0.7) / 4
        assert (root[0, 0] < 1) == curved
        assert curved or answer.mean == wide.mean


def test_a_closer_look_tells_errors_that_the_wide_one_does_not():
    """E[x | u] = u + u^3 has a slope of 1 at the answer, where both looks find it, and a larger one around it."""
    rng = np.random.default_rng(8)
    u, n = rng.normal(size=(60_000, 1)), 60_000
    folds = folds_of(rng.normal(size=(n, 1)), rng.normal(u + u**3), u)
    begin = np.zeros(1), np.eye(1), (np.array([-EDGE]), np.array([EDGE])), (0.1, 1.0)
    (wide, _), (close, _) = polish_closer(folds, *begin), polish_closer(folds, *begin, larger=1.5)
    assert abs(wide.mean[0]) < 3 * close.error[0]
    assert wide.error[0] < 0.5 * n**-0.5 < n**-0.5 < close.error[0]


def test_a_closer_look_without_enough_events_tells_nothing():
    rng = np.random.default_rng(7)
    u, bounds = rng.normal(size=(100, 2)), (np.full(2, -EDGE), np.full(2, EDGE))
    folds = folds_of(rng.normal(size=(4000, 2)), u + rng.normal(size=(100, 2)), u)
    wide = polish(folds, np.zeros(2), np.eye(2), bounds)
    answer, root = polish_closer(folds, np.zeros(2), np.eye(2), bounds, (0.001, 1e-9))
    assert answer.mean.tolist() == wide.mean.tolist()
    assert root.tolist() == np.eye(2).tolist()


@pytest.mark.parametrize(("toward", "nearest"), [(0.0, [0.5, 0.5]), (np.array([1.0, 0.2]), [0.9, 0.1])])
def test_the_prior_decides_where_the_events_say_nothing(toward, nearest):
    """x depends on u_1 + u_2 alone, so the answer is the point of that line nearest to the prior's mean, or another."""
    rng = np.random.default_rng(3)
    u = rng.normal([1.2, 0.1], 0.5, (40_000, 2))
    real, synthetic = rng.normal(1.0, 1, (40_000, 1)), rng.normal(u.sum(axis=1, keepdims=True), 1)
    answer = polished(real, synthetic, u, 0.8, std=0.5, toward=toward)
    np.testing.assert_allclose(answer.mean, nearest, atol=0.05)  # the slopes know the line to 0.01
    assert answer.error.min() > 0.5  # of the prior's order


def test_a_parameter_on_its_bound_leaves_the_others_their_rest():
    """x ~ N(A u, 1) with an observed mean beyond the bound of the second: the best first one within the bounds."""
    rng = np.random.default_rng(9)
    mixing = np.array([[1.0, 0.0], [0.6, 0.8]])
    u = rng.normal([0.3, 3.8], 0.4, (40_000, 2)).clip(-EDGE, EDGE)
    real = np.array([0.0, 4.5]) @ mixing + rng.normal(size=(40_000, 2))
    answer = polished(real, u @ mixing + rng.normal(size=(40_000, 2)), u, np.array([0.3, 3.8]), std=0.4)
    assert answer.converged
    assert answer.mean[1] == EDGE
    assert abs(answer.mean[0] - 0.3) < 4 * answer.error[0]  # 0.6 (4.5 - 4), what the second cannot give


def test_a_constant_feature_and_a_copy_change_nothing():
    rng = np.random.default_rng(5)
    u = rng.normal(0, 0.3, (5000, 1))
    real, synthetic = rng.normal(0.1, 1, (5000, 1)), rng.normal(u, 1)
    alone = polished(real, synthetic, u, 0.0)
    crowded = polished(*(np.hstack([x, x, np.ones_like(x)]) for x in (real, synthetic)), u, 0.0)
    np.testing.assert_allclose(crowded.mean, alone.mean, atol=1e-3 * alone.error[0])


def test_the_next_proposal_does_not_hang_on_rounding():
    """Where all directions are alike their axes are arbitrary, and a proposal turned at random gives other events."""
    root = np.array([[0.5, 0.1], [0.0, 0.3]])
    jitter = 1e-12 * np.array([[0.0, 1.0], [1.0, 0.3]])
    first, again = (
        narrower(root, Polished(np.zeros(2), covariance, 1, converged=True), 0.35, 10.0)
        for covariance in (root @ root.T, root @ root.T + jitter)
    )
    np.testing.assert_allclose(first, root)
    np.testing.assert_allclose(again, root, atol=1e-9)


def test_the_error_covers_two_in_three_and_nearly_all_within_two():
    """200 parameters found from a cube and a square of a Gaussian, whose means are curved in them and long-tailed."""
    rng, pulls = np.random.default_rng(6), []
    for _ in range(100):
        truth = rng.uniform(-0.5, 0.5, 2)
        u = truth + rng.normal(0, 0.1, (4000, 2))
        features = lambda u, n: np.stack([rng.normal(u[:, 0]) ** 3, rng.normal(0, np.exp(u[:, 1] / 2), n) ** 2], 1)  # noqa: E731
        answer = polished(features(np.tile(truth, (4000, 1)), 4000), features(u, 4000), u, truth, std=0.1)
        pulls.append((answer.mean - truth) / answer.error)
    inside = [np.mean(np.abs(pulls) < width) for width in (1, 2)]
    assert 0.55 < inside[0] < 0.8  # 0.683 within 4 standard deviations of 200 trials
    assert inside[1] > 0.89


def test_with_next_to_no_events_near_it_stays_and_says_so():
    """An answer of the prior's centre here would be one that looks like any other."""
    rng = np.random.default_rng(7)
    u = rng.normal(-2, 0.1, (4000, 1))
    answer = polished(rng.normal(1, 1, (4000, 1)), rng.normal(u, 1), u, 1.5, std=0.1)
    assert not answer.converged
    assert answer.mean == [1.5]


def test_parameters_that_leave_no_trace_are_no_error():
    """Ten parameters, a feature that depends on none: once a matrix that could not be factorised."""
    rng = np.random.default_rng(8)
    u = rng.normal(0, 0.5, (8000, 10))
    answer = polished(rng.normal(size=(4000, 1)), rng.normal(size=(8000, 1)), u, 0.0, std=0.5)
    assert np.isfinite(answer.mean).all()
    assert (answer.error > 0.9).sum() >= 9  # of the prior's order
