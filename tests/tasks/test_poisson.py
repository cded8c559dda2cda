"""Counts against the exact Poisson distribution, the summary, and the floor."""

import numpy as np
import pytest
from scipy import stats

from avobench.tasks.poisson import Poisson

TASK = Poisson()


def p_value(x: np.ndarray, theta: float) -> float:
    """Chi-square of counts (n,) against the exact probabilities, with bins of at least 5 expected events."""
    rate = np.exp(theta)
    inner = stats.poisson.ppf([10 / len(x), 1 - 10 / len(x)], rate).astype(int)
    edges = np.arange(inner[0], inner[1] + 1)
    expected = np.diff(stats.poisson.cdf([-1, *edges, np.inf], rate)) * len(x)
    observed = np.histogram(x, [-np.inf, *(edges + 0.5), np.inf])[0]
    return stats.chisquare(observed, expected).pvalue


@pytest.mark.parametrize("theta", [0.0, 1.9, 4.0])
def test_counts_follow_the_exact_distribution(theta):
    x = TASK.simulate(np.full((40_000, 1), theta), np.random.default_rng(0))[:, 0]
    assert p_value(x, theta) > 1e-4


def test_the_summary_has_a_bin_for_each_count_and_one_above():
    x = np.array([[0], [0], [99], [100], [22_026]])
    summary = TASK.summary(x)
    assert summary.shape == (101,)
    assert summary[[0, 99, 100]].tolist() == [0.4, 0.2, 0.4]
    assert Poisson(num_bins=1).summary(x).tolist() == [0.4, 0.6]
    with pytest.raises(ValueError, match="negative"):
        TASK.summary(np.array([[-1]]))


@pytest.mark.parametrize("num_simulations", [None, 160])
def test_the_floor_is_the_error_that_the_best_estimator_makes(num_simulations):
    """The maximum-likelihood estimate of theta, less the error of n simulated events where they are all one has."""
    theta, num_observations, repetitions = 2.0, 100, 4_000
    rng = np.random.default_rng(3)

    def log_mean(n: int) -> np.ndarray:
        x = TASK.simulate(np.full((repetitions * n, 1), theta), rng)
        return np.log(x.reshape(repetitions, n).mean(axis=1))

    error = log_mean(num_observations) - (log_mean(num_simulations) if num_simulations else theta)
    floor = TASK.floor(np.array([theta]), num_observations, num_simulations)
    assert np.mean(error**2) == pytest.approx(floor, rel=0.1)
    assert TASK.floor(np.array([theta]), 100_000, None) == pytest.approx(1e-5 * np.exp(-2))
