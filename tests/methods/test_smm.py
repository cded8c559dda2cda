"""The simulated method of moments."""

import numpy as np
import pytest

from avobench.methods.smm import Smm
from avobench.tasks.function import task
from gaussian import posed, problem_at

SHIFT = task(lambda theta, rng: rng.normal(theta[:, 0]), prior={"mean": (-2, 2)}, name="shift")


def inferred(simulator, truth, seed, num_observed=20_000):
    rng = np.random.default_rng(seed)
    return Smm().infer(problem_at(simulator, truth, 20_000, rng, num_observed), rng)


def test_its_standard_error_is_that_of_repeated_answers():
    """The mean of a Gaussian, which is sufficient: pulls of 40 runs have variance 1 to a factor of 2.3 (p = 1e-6)."""
    found = [inferred(SHIFT, [0.7], seed) for seed in range(40)]
    pulls = np.array([(estimate.theta[0] - 0.7) / estimate.error[0] for estimate in found])
    assert 1 / 2.3 < np.mean(pulls**2) < 2.3
    assert found[0].error[0] == pytest.approx(np.sqrt(2 / 20_000), rel=0.3)


def test_where_means_say_nothing_it_says_that_it_does_not_know():
    scale = task(lambda theta, rng: rng.normal(0, np.exp(theta[:, 0])), prior={"scale": (-1, 1)}, name="scale")
    assert inferred(scale, [0.8], 1).error[0] > 0.1


@pytest.mark.parametrize("num_observed", [12, 30])
def test_few_events_of_many_features_tell_no_more_than_they_know(num_observed):
    """The mean of eight Gaussian features: the best error is known, and the covariance of 12 events is mostly noise."""
    means = task(lambda theta, rng: rng.normal(theta, 1.0, (len(theta), 8)), prior={"mean": (-3, 3)}, name="means")
    found = [inferred(means, [0.5], seed, num_observed=num_observed) for seed in range(20)]
    errors = np.array([estimate.error[0] for estimate in found])
    np.testing.assert_allclose(errors, 1 / np.sqrt(8 * num_observed), rtol=0.1)
    pulls = np.array([estimate.theta[0] - 0.5 for estimate in found]) / errors
    assert np.mean(pulls**2) < 2.8  # chi-squared of 20: p = 3e-5


def test_trimmed_moments_lose_little_and_are_moved_less_by_outliers():
    """Of a Gaussian with a tenth Winsorised at either end: the error grows by 3 %."""
    rng = np.random.default_rng(5)
    clean = rng.normal(0.7, 1, (20_000, 1))
    far = np.where(rng.random((20_000, 1)) < 0.05, 6.0, clean)

    def fit(x, **settings):
        return Smm(**settings).infer(posed(SHIFT, x, 20_000, 6), rng)

    right = fit(clean, trim=0.1)
    assert abs(right.theta[0] - 0.7) < 4 * right.error[0]
    assert 1 < right.error[0] / fit(clean).error[0] < 1.08
    assert fit(far).theta[0] - 0.7 > 0.2 > 0.15 > fit(far, trim=0.1).theta[0] - 0.7


def test_where_means_leave_a_combination_of_many_parameters_open_it_is_in_doubt():
    """With more than three parameters no best of many answers is looked for."""
    noise = task(
        lambda theta, rng: theta[:, :3] + np.exp(theta[:, 3:]) * rng.standard_normal((len(theta), 3)),
        prior={name: (-1, 1) for name in ("a", "b", "c", "log_scale")},
        name="noise",
    )
    assert inferred(noise, [0.3, 0.1, -0.4, 0.8], 2).doubt
    assert not inferred(
        task(lambda t, rng: rng.normal(t, 1.0), prior=dict.fromkeys("abcd", (-1, 1))), [0.3] * 4, 2
    ).doubt
