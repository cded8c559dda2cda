"""The unmixed events against their exact distributions, component by component, the summary, and the floor."""

import numpy as np
import pytest
from scipy import stats

from avobench.tasks.carl import MIXING, Carl

TASK = Carl()


def components(theta: np.ndarray, seed: int) -> np.ndarray:
    """z = R^-1 x (n, 5), one event per row of theta."""
    return np.linalg.solve(MIXING, TASK.simulate(theta, np.random.default_rng(seed)).T).T


def test_the_mixing_matrix_is_symmetric_invertible_and_cannot_be_changed():
    np.testing.assert_array_equal(MIXING, MIXING.T)
    assert np.linalg.cond(MIXING) < 20
    with pytest.raises(ValueError, match="read-only"):
        MIXING[0, 0] = 1


@pytest.mark.parametrize("theta", [(-2.0, 2.0), (0.7, -1.1)])
def test_unmixed_events_follow_the_exact_distributions(theta):
    cdfs = (
        stats.norm(theta[0], 1).cdf,
        stats.norm(theta[1], 3).cdf,
        lambda z: (stats.norm(-2, 1).cdf(z) + stats.norm(2, 0.5).cdf(z)) / 2,
        stats.expon(scale=1 / 3).cdf,
        stats.expon(scale=2).cdf,
    )
    for z, cdf in zip(components(np.tile(theta, (40_000, 1)), 0).T, cdfs, strict=True):
        assert stats.kstest(z, cdf).pvalue > 1e-4


def test_components_are_independent_of_one_another():
    z = components(np.zeros((40_000, 2)), 1)
    for w in (z, (z - z.mean(axis=0)) ** 2):
        assert np.abs(np.corrcoef(w.T) - np.eye(5)).max() < 5 / np.sqrt(len(z))


def test_the_summary_counts_what_is_out_of_range():
    x = np.array([[-15.0, 15.0, 0, 0, 0], [-15.1, 15.1, 0, 0, 0], [-1e9, 1e9, 0.5, 0, 0], [14.5, 14.5, 0.9, 0, 0]])
    shares = TASK.summary(x).reshape(5, 32)
    assert shares[0, [0, 1, 30, 31]].tolist() == [0.5, 0.25, 0.25, 0]
    assert shares[1, [0, 30, 31]].tolist() == [0, 0.25, 0.75]
    assert shares[2, 16] == 1  # bins are one wide, [0, 1) is the sixteenth


def test_the_summary_follows_its_settings():
    shares = Carl(num_bins=2, bin_limit=1.0).summary(np.array([[-2.0, -0.5, 0.0, 0.5, 2.0]])).reshape(5, 4)
    assert shares.argmax(axis=1).tolist() == [0, 1, 2, 2, 3]


def test_the_floor_is_the_error_that_the_best_estimator_makes():
    """The means of z0 and z1, against their exact values and against those of n simulated events."""
    repetitions, num_observations, num_simulations = 2_000, 20, 32
    observed, simulated = (
        components(np.zeros((repetitions * n, 2)), seed)[:, :2].reshape(repetitions, n, 2).mean(axis=1)
        for seed, n in ((3, num_observations), (4, num_simulations))
    )
    for error, n in ((observed, None), (observed - simulated, num_simulations)):
        floor = TASK.floor(np.zeros(2), num_observations, n)
        assert (error**2).sum(axis=1).mean() == pytest.approx(floor, rel=0.1)
    assert TASK.floor(np.zeros(2), 100_000, 160_000) == pytest.approx(1.625e-4)
