"""The preset avo on problems whose best answer is known; see test_polish.py for its last stage."""

import numpy as np
import pytest

from avobench.methods.avo_replay import Avo, geometric
from gaussian import GaussianMean, GaussianMeans, gaussian_problem

FEW = {"iterations": 250, "hidden": (32, 32)}


def test_estimate_is_as_good_as_the_observed_mean():
    given = gaussian_problem(GaussianMean(), 30_000)
    estimate = Avo(**FEW).infer(given, np.random.default_rng(1))
    assert given.simulate.used == 30_000
    simulated = np.sqrt(2 / 30_000)  # twice the variance of all simulated events at the right place
    assert abs(estimate.theta[0] - given.x_observed.mean()) < 4 * simulated
    assert estimate.how == "mean of the proposal after the polish"
    assert "the polish converged" in estimate.message


def test_without_the_polish_it_still_moves_to_the_observed_means():
    given = gaussian_problem(GaussianMeans(), 30_000, np.array([1.0, 12.5]))
    estimate = Avo(**FEW, polish=False).infer(given, np.random.default_rng(2))
    np.testing.assert_allclose(estimate.theta, given.x_observed.mean(axis=0), atol=0.2)
    assert estimate.how == "mean of the proposal over the last quarter"


def test_trace_counts_every_event_and_ends_with_the_estimate():
    given = gaussian_problem(GaussianMean(), 1001)
    estimate = Avo(**FEW).infer(given, np.random.default_rng(3))
    used = [point.simulations for point in estimate.trace]
    assert used[0] == 0
    assert used[-2:] == [1001, 1001]  # before and after the polish
    assert used == sorted(used)
    np.testing.assert_array_equal(estimate.trace[-1].theta, estimate.theta)
    assert (estimate.trace[-1].std < estimate.trace[0].std).all()


@pytest.mark.parametrize(
    "settings",
    [
        {"iterations": 0},
        {"hidden": ()},
        {"learning_rate": (1e-3, 0.0)},
        {"max_std": 2.0},
        {"min_std": 0.0},
        {"r1": -1.0},
        {"entropy": -1.0},
    ],
)
def test_settings_that_make_no_sense_are_refused(settings):
    with pytest.raises(ValueError, match=r"must|need"):
        Avo(**settings)


def test_schedule_goes_from_one_end_to_the_other():
    assert [geometric((0.1, 0.001), progress) for progress in (0, 0.5, 1)] == pytest.approx([0.1, 0.01, 0.001])
