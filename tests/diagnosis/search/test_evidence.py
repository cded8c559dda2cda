"""Evidence against exact marginal likelihoods, and what something unknown may and may not do."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from avobench.diagnosis.search.evidence import Unknown, evidence_of, marginal, prior


def linear(fit, residual, jacobian):
    """A fit of a model that is linear, known without noise."""
    p = fit.model.dim
    return replace(fit, residual=residual, jacobian=jacobian, jacobian_noise=np.zeros((p, p)), noise=0.0)


@given(st.integers(0, 1000), st.floats(0, 30))
def test_the_evidence_of_a_linear_model_is_its_marginal_likelihood(counter, seed, spread):
    rng, fit = np.random.default_rng(seed), counter.weak
    r = 6
    jacobian, residual = rng.normal(0, 10, (r, fit.model.dim)), rng.normal(0, 3, r)
    variances = 1 + spread * rng.random(r)
    vectors, _ = np.linalg.qr(rng.normal(size=(r, r)))
    fit = linear(fit, residual, jacobian)
    precision, scale = prior(fit)
    steps = jacobian * scale
    cov = vectors @ np.diag(variances) @ vectors.T + steps @ np.diag(1 / precision) @ steps.T
    exact = multivariate_normal(np.zeros(r), cov).logpdf(residual) + r / 2 * np.log(2 * np.pi)
    assert marginal(fit, variances, vectors).value == pytest.approx(exact, rel=1e-8)


def test_noise_of_the_simulation_is_taken_out_on_average(counter):
    rng, fit, r, noise = np.random.default_rng(0), counter.null, 40, 0.5
    jacobian = np.zeros((r, 1))
    clean = [marginal(linear(fit, rng.standard_normal(r), jacobian), np.ones(r), None).value for _ in range(2000)]
    noisy = [replace(linear(fit, np.sqrt(1 + noise) * rng.standard_normal(r), jacobian), noise=noise) for _ in clean]
    noisy = [marginal(each, np.ones(r), None).value for each in noisy]
    assert np.mean(noisy) == pytest.approx(np.mean(clean), abs=0.5)


def test_a_wrong_share_of_a_change_moves_no_event_from_nowhere(counter):
    """The covariance is that of distortions after which the shares of all bins still sum to one."""
    target, rng = counter.target, np.random.default_rng(0)
    mean = counter.null.predicted
    alike = target.summary.alike(1 / 8)
    found = Unknown(target).whitened(mean, alike, mean)
    draws = mean * rng.multivariate_normal(np.zeros(len(mean)), alike, 20_000, method="svd")
    draws -= draws.sum(axis=1, keepdims=True) * mean
    whitened = target.whiten(draws)
    np.testing.assert_allclose(found, np.cov(whitened, rowvar=False), atol=0.05 * np.abs(found).max())


def test_a_smooth_distortion_is_outside_and_noise_is_not(counter):
    target, null = counter.target, counter.null
    unknown, rng = Unknown(target), np.random.default_rng(0)
    mean = np.maximum(null.predicted, 0)
    wave = mean * np.sin(np.linspace(0, 6, len(mean)))
    bent = target.whiten(0.3 * (wave - wave.sum() * mean))
    for left, outside in ((rng.standard_normal(target.rank), False), (bent, True)):
        fit = replace(null, residual=left + 0 * null.residual)
        assert (unknown.evidence(fit) > evidence_of(fit).value) == outside
