"""The posterior over the prior box where the events leave a curve open, against one known in closed form.

With v and w uniform in [0, 1] and v w = s known, v has the density 1 / (v log(1/s)) from s to 1, and so has w.
"""

import numpy as np
import pytest
from scipy.stats import norm

from avobench.methods import avo, smm
from avobench.methods.avo import Avo
from avobench.methods.leeway import EDGE, LEAST_POINTS, Leeway, leaves_open, tempered
from avobench.methods.polish import Fold, Polished
from avobench.methods.rank_moments import RankMoments
from avobench.methods.smm import Smm
from avobench.tasks.function import task
from gaussian import GaussianMeans, gaussian_problem, posed, problem_at

S = 0.3
MEAN = (1 - S) / np.log(1 / S)
BEST = np.sqrt(S)
"""Of the curve's points the nearest to the mean, by symmetry."""
ERROR = np.sqrt((1 - S**2) / 2 / np.log(1 / S) - 2 * BEST * MEAN + S)
FEW = {"iterations": 60, "hidden": (16,), "statistic_steps": 50}


def product_folds(rng, num_noise=0, folds=2, n=40_000):
    """x ~ N(4 v w, 1), and features that depend on nothing."""
    v = rng.random((n, 2))
    simulated, observed = rng.normal(4 * v.prod(axis=1)), rng.normal(4 * S, 1, n)
    synthetic, real = (
        np.column_stack([x, rng.normal(size=(n, num_noise))]).astype(np.float32) for x in (simulated, observed)
    )
    u = EDGE * (2 * v - 1)
    return [Fold(real[i::folds], synthetic[i::folds], u[i::folds]) for i in range(folds)]


def in_box(u):
    return (u / EDGE + 1) / 2


@pytest.mark.parametrize("num_noise", [0, 20])
@pytest.mark.parametrize("folds", [1, 2])
def test_mean_best_point_and_error_are_those_of_the_curve(num_noise, folds):
    """Noise of the fits is told apart from what depends on theta: else the mean would be off by a tenth."""
    leeway = Leeway(product_folds(np.random.default_rng(1), num_noise, folds))
    np.testing.assert_allclose(in_box(leeway.weights @ leeway.points), MEAN, atol=0.03)
    best = leeway.best(np.ones(2))
    assert np.prod(in_box(best)) == pytest.approx(S, abs=0.03)
    np.testing.assert_allclose(in_box(best), BEST, atol=0.06)
    np.testing.assert_allclose(leeway.error(EDGE * (2 * np.full(2, BEST) - 1)) / (2 * EDGE), ERROR, rtol=0.1)


def test_features_that_tell_the_same_in_another_way_change_nothing():
    """Their fits' noise would make the posterior a fraction of its width."""
    rng = np.random.default_rng(7)
    v = rng.random((40_000, 2))
    s = v.prod(axis=1)
    simulated = rng.normal(4 * np.stack([s, s**2, s * (1 - s)], axis=1))
    observed = rng.normal(4 * np.array([S, S**2, S * (1 - S)]), 1, (40_000, 3))
    leeway = Leeway([Fold(observed.astype(np.float32), simulated.astype(np.float32), EDGE * (2 * v - 1))])
    np.testing.assert_allclose(in_box(leeway.weights @ leeway.points), MEAN, atol=0.03)
    np.testing.assert_allclose(leeway.error(EDGE * (2 * np.full(2, BEST) - 1)) / (2 * EDGE), ERROR, rtol=0.1)


def test_a_second_feature_rules_out_the_branch_that_the_first_allows():
    """An angle of which the cosine tells more than the sine does, and a parameter of which nothing is told."""
    rng, truth = np.random.default_rng(8), 1.0

    def event(angle, n):
        return rng.normal(np.stack([3 * np.cos(angle), np.sin(angle)], axis=-1), 1, (n, 2)).astype(np.float32)

    u = rng.uniform(-EDGE, EDGE, (40_000, 2))
    leeway = Leeway([Fold(event(truth, 40_000), event(u[:, 0], 40_000), u)])
    assert leeway.weights @ leeway.points == pytest.approx(np.array([truth, 0.0]), abs=0.05)


def test_where_nothing_depends_on_theta_the_posterior_is_the_prior():
    rng = np.random.default_rng(3)
    u = rng.uniform(-EDGE, EDGE, (10_000, 2))
    leeway = Leeway([Fold(*rng.normal(size=(2, 10_000, 3)).astype(np.float32), u)])
    np.testing.assert_allclose(leeway.weights @ leeway.points, 0, atol=0.01)
    np.testing.assert_allclose(leeway.error(np.zeros(2)), 1, rtol=0.01)


def test_open_is_what_is_nearly_as_uncertain_as_the_prior_has_it():
    def answer(*variances):
        turn = np.linalg.qr(np.random.default_rng(4).normal(size=(len(variances),) * 2))[0]
        return Polished(np.zeros(len(variances)), turn @ np.diag(variances) @ turn.T, 1, converged=True)

    assert leaves_open(answer(1e-4, 0.9))
    assert not leaves_open(answer(1e-4, 0.1))
    assert not leaves_open(answer(1e-4, 1e-4, 0.9, 0.9))  # more than the points of a box can tell


def test_weights_are_tempered_only_where_they_must_be():
    x = np.linspace(-1, 1, 10_001)
    wide, narrow = (tempered(-((x / width) ** 2) / 2) for width in (0.3, 1e-4))
    np.testing.assert_allclose(wide, np.exp(-((x / 0.3) ** 2) / 2) / np.exp(-((x / 0.3) ** 2) / 2).sum())
    assert narrow.sum() == pytest.approx(1)
    assert 1 / (narrow**2).sum() == pytest.approx(LEAST_POINTS, rel=0.01)


@pytest.mark.parametrize("method", [Avo(**FEW), Smm(), RankMoments()], ids=lambda method: method.name)
def test_the_estimate_is_the_best_point_of_an_open_curve(method):
    rng = np.random.default_rng(5)
    product = task(lambda theta, rng: rng.normal(4 * theta.prod(axis=1)), prior={"v": (0, 1), "w": (0, 1)}, name="vw")
    estimate = method.infer(problem_at(product, [0.9, S / 0.9], 40_000, rng, num_observed=40_000), rng)
    assert np.prod(estimate.theta) == pytest.approx(S, abs=4 * np.sqrt(2 / 40_000) / 4 * 2)
    np.testing.assert_allclose(estimate.theta, BEST, atol=0.08)
    np.testing.assert_allclose(estimate.error, ERROR, rtol=0.2)


@pytest.mark.parametrize(("module", "method"), [(avo, Avo(**FEW)), (smm, Smm())], ids=["avo", "smm"])
def test_where_nothing_is_open_the_estimate_is_what_it_was_to_the_last_bit(module, method, monkeypatch):
    def infer():
        given = gaussian_problem(GaussianMeans(), 3000, np.array([1.0, 12.5]))
        return method.infer(given, np.random.default_rng(6))

    now = infer()
    monkeypatch.setattr(module, "leaves_open", lambda answer, prior: False)
    assert infer().theta.tolist() == now.theta.tolist()
    assert infer().error.tolist() == now.error.tolist()


def test_where_the_points_that_agree_are_few_the_posterior_is_wide_and_not_lost():
    """Three parameters told to a thousandth: the tube of points that agree is narrower than the points lie apart."""
    rng = np.random.default_rng(3)
    u = EDGE * (2 * rng.random((30_000, 3)) - 1)
    simulated, observed = (rng.normal(1000 * at).astype(np.float32) for at in (u, np.full((30_000, 3), 0.4)))
    leeway = Leeway([Fold(observed, simulated, u)])
    assert leeway.weights.sum() == pytest.approx(1)
    np.testing.assert_allclose(leeway.best(np.ones(3)), 0.4, atol=0.2)


def test_more_open_parameters_than_can_be_searched_are_doubtful():
    """Four of five parameters change nothing: where they were begun with is no answer."""
    prior, rng = dict.fromkeys("abcde", (-1, 1)), np.random.default_rng(0)
    blind = task(lambda theta, rng: rng.normal(theta[:, :1], 1), prior=prior, name="blind")
    estimate = Avo(**FEW).infer(problem_at(blind, np.zeros(5), 20_000, rng, num_observed=5000), rng)
    assert estimate.doubt == "the events determine almost nothing about one combination of the parameters"


@pytest.mark.parametrize("half", [0.05, 0.5])
def test_a_prior_that_is_narrow_beside_the_error_leaves_the_posterior_within_it(half):
    """Thirty events tell the mean of a Gaussian to 0.18. Estimate and error are those of the truncated posterior."""
    narrow = task(lambda theta, rng: rng.normal(theta[:, 0], 1), prior={"mu": (1 - half, 1 + half)}, name="narrow")
    off, exact = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        x = rng.normal(mu := rng.uniform(1 - half, 1 + half), 1, (30, 1))
        found = RankMoments().infer(posed(narrow, x, 8000, rng), rng)
        off.append((found.theta[0] - mu) / found.error[0])
        at = np.linspace(1 - half, 1 + half, 1001)
        weight = norm.pdf(at, x.mean(), 1 / np.sqrt(30))
        exact.append(np.sqrt(np.average((at - np.average(at, weights=weight)) ** 2, weights=weight)) / found.error[0])
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.mean(exact) == pytest.approx(1, abs=0.3)
