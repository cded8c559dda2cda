"""The preset avo on problems whose best answer is known; see test_polish.py for its last stage."""

import numpy as np
import pytest

from avobench.methods.avo import Avo, geometric
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
    assert used[-4:] == [400, 600, 800, 1000]  # the first polish and the local rounds; both halves get as many events
    assert used == sorted(used)
    np.testing.assert_array_equal(estimate.trace[-1].theta, estimate.theta)
    assert (estimate.trace[-1].std < estimate.trace[0].std).all()


def test_local_stage_brings_the_standard_error_near_that_of_all_events_at_the_right_place():
    quoted = {}
    for share in (0.0, 0.6):
        estimate = Avo(**FEW, local_share=share).infer(
            gaussian_problem(GaussianMeans(), 30_000, np.array([1.0, 12.5])), np.random.default_rng(4)
        )
        quoted[share] = np.array([float(e) for e in estimate.message.rpartition("error of ")[2].split(", ")])
    best = np.sqrt(1 / 10_000 + 1 / 30_000)
    assert (quoted[0.6] < 1.2 * best).all()
    assert (quoted[0.6] < quoted[0.0]).all()


def test_problems_solved_together_are_solved_as_each_by_itself():
    means = [np.array([1.0, 12.5]), np.array([-1.0, 8.0])]
    method = Avo(iterations=30, hidden=(16,))

    def problems():
        return [gaussian_problem(GaussianMeans(), 3000, mean) for mean in means]

    alone = [method.infer(given, np.random.default_rng(i)) for i, given in enumerate(problems())]
    together = method.infer_together(problems(), [np.random.default_rng(i) for i in range(2)])
    for a, b in zip(alone, together, strict=True):
        np.testing.assert_allclose(b.theta, a.theta, rtol=1e-4)
        assert [point.simulations for point in b.trace] == [point.simulations for point in a.trace]


@pytest.mark.parametrize(
    "settings",
    [
        {"iterations": 0},
        {"hidden": ()},
        {"learning_rate": (1e-3, 0.0)},
        {"max_std": 2.0},
        {"min_std": 0.0},
        {"r1": -1.0},
        {"local_share": 1.0},
        {"replay": 1},
        {"entropy": -1.0},
    ],
)
def test_settings_that_make_no_sense_are_refused(settings):
    with pytest.raises(ValueError, match=r"must|need"):
        Avo(**settings)


def test_schedule_goes_from_one_end_to_the_other():
    assert [geometric((0.1, 0.001), progress) for progress in (0, 0.5, 1)] == pytest.approx([0.1, 0.01, 0.001])
