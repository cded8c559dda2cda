"""The simulated method of moments on polynomials of ranks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import avobench
from avobench.methods.rank_moments import MOST_POLYNOMIALS, Polynomials, RankMoments
from avobench.tasks.function import task
from gaussian import posed, problem_at

N = 20_000


SHIFT = task(lambda theta, rng: rng.normal(theta[:, 0]), prior={"mean": (-2, 2)}, name="shift")


def inferred(simulator, truth, seed, budget=20_000, num_observed=N):
    rng = np.random.default_rng(seed)
    return RankMoments().infer(problem_at(simulator, truth, budget, rng, num_observed), rng)


def cauchy(theta, rng):
    return theta[:, 0] + rng.standard_cauchy(len(theta))


def correlated(theta, rng):
    a, b = rng.standard_normal((2, len(theta)))
    return np.column_stack([a, theta[:, 0] * a + np.sqrt(1 - theta[:, 0] ** 2) * b])


def scaled(theta, rng):
    return rng.normal(0, np.exp(theta[:, 0]))


@pytest.mark.parametrize(
    ("function", "truth", "information"),
    [(cauchy, 0.7, 0.5), (scaled, -0.4, 2.0), (correlated, 0.4, (1 + 0.4**2) / (1 - 0.4**2) ** 2)],
)
def test_its_error_is_that_of_repeated_answers_and_near_the_best(function, truth, information):
    """The centre of a Cauchy, a scale and a correlation, of which the mean says nothing; pulls of 30 runs."""
    simulator = task(function, prior={"theta": (-0.9, 0.9)})
    found = [inferred(simulator, [truth], seed) for seed in range(30)]
    pulls = np.array([(estimate.theta[0] - truth) / estimate.error[0] for estimate in found])
    assert 0.35 < np.mean(pulls**2) < 2.5  # chi-squared of 30: p = 1e-5
    best = np.sqrt((1 / N + 1 / 20_000) / information)
    assert 0.8 < np.median([estimate.error[0] for estimate in found]) / best < 1.4
    assert sum(estimate.doubt != "" for estimate in found) <= 4


def test_a_change_of_scale_that_keeps_the_order_changes_nothing():
    bent = task(lambda theta, rng: np.exp(rng.normal(theta[:, 0])), prior={"mean": (-2, 2)}, name="bent")
    first, second = (inferred(simulator, [0.7], 0) for simulator in (SHIFT, bent))
    assert first.theta == pytest.approx(second.theta, abs=0.05 * first.error[0])


def test_few_outliers_move_it_little():
    """Of outliers at a distance of 1000 a mean would move by 10, and a median by 0.013."""
    rng = np.random.default_rng(0)
    x = np.where(rng.random((N, 1)) < 0.01, 1000.0, rng.normal(0.7, 1, (N, 1)))
    estimate = RankMoments().infer(posed(SHIFT, x, 20_000, rng), rng)
    assert estimate.theta[0] == pytest.approx(0.7, abs=0.06)
    assert "differ from the observed" in estimate.doubt


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32), d=st.integers(1, 60), degree=st.integers(1, 12))
def test_the_polynomials_of_independent_features_are_orthonormal(seed, d, degree):
    x = np.random.default_rng(seed).uniform(-1, 1, (3000, d)).astype(np.float32)
    polynomials = Polynomials(x, degree)
    values = polynomials(x)
    assert values.shape[1] <= max(MOST_POLYNOMIALS, d)
    assert np.abs(values.mean(axis=0)).max() < 0.15
    covariance = np.cov(values, rowvar=False).reshape(values.shape[1], -1)
    assert np.abs(covariance - np.eye(len(covariance))).max() < 0.25
    np.testing.assert_array_equal(np.concatenate(list(polynomials.parts(np.tile(x, (4, 1))))), np.tile(values, (4, 1)))


def test_of_a_rare_yes_or_no_the_error_is_binomial():
    rare = task(lambda theta, rng: rng.random(len(theta)) < theta[:, 0], prior={"p": (0, 1)}, name="rare")
    estimate = inferred(rare, [0.01], 0, num_observed=1000)
    assert estimate.error[0] == pytest.approx(np.sqrt(0.01 * 0.99 / 1000), rel=0.3)
    assert estimate.theta[0] == pytest.approx(0.01, abs=3 * estimate.error[0])


def test_ten_means_are_told_as_well_as_one():
    """Each is the mean of a feature; fewer simulated events than observed ones tell how the means move with theta."""
    means = task(lambda theta, rng: rng.normal(theta), prior={f"mu{k}": (-3, 3) for k in range(10)}, name="means")
    truth = np.linspace(-1, 1, 10)
    estimate = inferred(means, truth, 0, budget=40_000, num_observed=100_000)
    best = np.sqrt(1 / 100_000 + 1 / 40_000)
    assert estimate.doubt == ""
    assert (0.8 * best < estimate.error).all()
    assert (estimate.error < 2.5 * best).all()
    assert np.mean(((estimate.theta - truth) / estimate.error) ** 2) < 3  # chi-squared of 10: p = 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_where_it_misses_a_straight_line_it_is_in_doubt(seed):
    def line(theta, rng):
        x = rng.uniform(0, 10, len(theta))
        return np.column_stack([x, theta[:, 0] + theta[:, 1] * x + rng.normal(0, 1, len(theta))])

    straight = avobench.task(line, prior={"a": (-10, 10), "b": (-5, 5)}, features=["x", "y"], name="line")
    x = line(np.tile([1.0, 2.0], (2000, 1)), np.random.default_rng(1000 + seed))
    found = avobench.infer(straight, x, "rank-moments", seed=seed, budget=20_000)
    off = np.abs(np.array(list(found.theta.values())) - [1, 2]) / list(found.std.values())
    assert found.estimate.doubt or (off < 4).all()
