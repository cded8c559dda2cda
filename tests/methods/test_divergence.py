"""The minimiser of the Jensen-Shannon divergence, against answers that are known without it."""

import numpy as np
import pytest

from avobench.methods.avo import Avo
from avobench.methods.divergence import Contrast, minimise
from avobench.tasks.function import task
from gaussian import posed

FEW = {"iterations": 80, "hidden": (32, 32), "statistic_steps": 100}
BOUNDS = np.array([-4.0]), np.array([4.0])


def solved(real, seed, around=0.0, start=0.1, n=40_000):
    """The minimiser for x ~ N(u, 1) and its divergence, with x as the statistic and a discriminator of splines in x.

    Of the simulated events two thirds are at `around`, the others far about it.
    """
    rng = np.random.default_rng(seed)
    u = rng.normal(around + 0.01, np.where(np.arange(n) % 3, 0.01, 0.5))[:, None]
    synthetic = rng.normal(u, 1)

    def half(features, i):
        return features(real[i::2]), features(synthetic[i::2])

    def splines(x):
        return np.hstack([x, np.maximum(x - np.linspace(-3, 7, 21), 0)])

    contrasts = [
        Contrast(half(lambda x: x, i), half(splines, i), half(splines, 1 - i), u[i::2], u[1 - i :: 2]) for i in range(2)
    ]
    return minimise(contrasts, np.array([around + start]), np.array([[0.1]]), BOUNDS, 0.0)


def test_the_score_of_a_gaussian_is_found_among_features_that_saturate():
    """For x ~ N(u1, exp(u2)) at u = 0 it is (x, x^2 - 1), however far around the events were simulated."""
    rng = np.random.default_rng(0)
    u = rng.normal(0, 0.3, (100_000, 2))
    x = rng.normal(u[:, 0], np.exp(u[:, 1]))[:, None]
    phi = np.hstack([x, x**2, np.tanh(x), np.tanh(x**2 / 3)]).astype(np.float32)
    weights = Contrast((phi, phi), (phi, phi), (phi, phi), u, u).score(np.zeros(2), 0.3 * np.eye(2)).weights
    at = np.random.default_rng(1).standard_normal(len(x))
    found = np.stack([at, at**2, np.tanh(at), np.tanh(at**2 / 3)], axis=1) @ weights
    for of, exact in zip(found.T, (at, at**2 - 1), strict=True):
        assert np.corrcoef(of, exact)[0, 1] > 0.98  # the regression of u on phi has 0.97


def outliers(rng, n, share, at):
    return np.where(rng.random((n, 1)) < share, rng.normal(at, 0.5, (n, 1)), rng.normal(size=(n, 1)))


def test_where_the_simulator_is_right_it_is_the_match_of_means_with_the_same_error():
    rng = np.random.default_rng(1)
    real = rng.normal(size=(40_000, 1))
    found = solved(real, 2)
    assert found.answer.converged
    assert abs(found.answer.mean[0]) < 4 * found.answer.error[0]
    assert found.answer.error[0] < 1.1 * np.sqrt(1 / 40_000 + 1 / (40_000 * 2 / 3))
    assert abs(found.divergence) < 0.002


@pytest.mark.parametrize(("share", "at", "minimiser"), [(0.2, 6.0, 0.0), (0.05, -6.0, 0.0), (0.2, 2.64, 0.3225)])
def test_outliers_leave_it_at_the_minimiser_of_the_divergence(share, at, minimiser):
    """Far outliers do not move it. Near ones do, to a minimum found by quadrature."""
    rng = np.random.default_rng(3)
    found = solved(outliers(rng, 40_000, share, at), 4, around=minimiser)
    assert found.answer.converged
    assert abs(found.answer.mean[0] - minimiser) < 3 * found.answer.error[0]
    assert found.answer.error[0] < 0.05
    assert found.divergence > 0.005


def test_its_error_is_that_of_repeated_answers():
    """The mean square of 20 pulls is below 1/3 in one case of 400 by chance, and above 3 in one of 100 000."""
    pulls = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        answer = solved(outliers(rng, 5000, 0.1, 6.0), 100 + seed, n=5000).answer
        pulls.append(answer.mean[0] / answer.error[0])
    assert 1 / 3 < np.mean(np.square(pulls)) < 3


def test_without_events_nearby_it_says_that_it_did_not_converge():
    found = solved(np.zeros((100, 1)) + np.random.default_rng(5).normal(size=(100, 1)), 6, start=3.9)
    assert not found.answer.converged
    assert found.divergence == np.inf


def test_avo_recovers_a_contaminated_gaussian_mean_and_a_seed_repeats_it():
    shift = task(lambda theta, rng: rng.normal(theta[:, 0]), prior={"mean": (-2, 2)}, name="shift")
    x = outliers(np.random.default_rng(7), 10_000, 0.05, 6.0)

    def estimate():
        return Avo(**FEW, matched="divergence").infer(posed(shift, x.copy(), 15_000, 8), np.random.default_rng(9))

    first, again = estimate(), estimate()
    assert abs(first.theta[0]) < 3 * first.error[0] < 0.15
    assert "the polish converged" in first.message
    assert first.theta.tolist() == again.theta.tolist()
