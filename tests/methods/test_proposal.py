"""The truncated Gaussian against scipy.stats.truncnorm and against finite differences."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import kstest, truncnorm

from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks import Box

PRIOR, SUPPORT = Box((0.0, 43.0), (4.0, 47.0)), Box((-10.0, 42.8), (10.0, 47.2))
PROPOSAL = TruncatedGaussian(PRIOR, SUPPORT)
psis = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-4, 1.5), st.floats(-4, 1.5)).map(
    lambda v: np.array(v).reshape(2, 2)
)


def reference(psi):
    std = np.exp(psi[1])
    return truncnorm((PROPOSAL.low - psi[0]) / std, (PROPOSAL.high - psi[0]) / std, loc=psi[0], scale=std)


def entropy(psi):
    """-E[log q] per parameter by the trapezoidal rule (truncnorm.entropy of SciPy is wrong far in a tail): (p,)."""
    mean, std = PROPOSAL.mean_and_std(psi)
    u = np.linspace(np.maximum(PROPOSAL.low, mean - 30 * std), np.minimum(PROPOSAL.high, mean + 30 * std), 20_001)
    log_q = PROPOSAL.log_density(psi, u)
    return -np.trapezoid(np.exp(log_q) * log_q, u, axis=0)


def gradient(function, psi, step=1e-5):
    """Central differences of a scalar function of psi (2, p)."""
    result = np.zeros_like(psi)
    for index in np.ndindex(psi.shape):
        shift = np.zeros_like(psi)
        shift[index] = step
        result[index] = (function(psi + shift) - function(psi - shift)) / (2 * step)
    return result


def test_prior_box_becomes_the_moments_of_the_prior():
    theta = PRIOR.sample(200_000, np.random.default_rng(0))
    u = PROPOSAL.to_standard(theta)
    np.testing.assert_allclose(u.mean(axis=0), 0, atol=0.01)
    np.testing.assert_allclose(u.std(axis=0), 1, atol=0.01)
    np.testing.assert_allclose(PROPOSAL.to_raw(u), theta, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("psi", [[[0.0, 0.0], [0.0, 0.0]], [[1.0, 5.0], [-2.0, 0.5]], [[-2.0, -9.0], [1.0, -0.5]]])
def test_draws_follow_the_truncated_density(psi):
    u = PROPOSAL.sample(np.array(psi), 20_000, np.random.default_rng(1))
    shares = reference(np.array(psi)).cdf(u)
    assert all(kstest(shares[:, i], "uniform").pvalue > 1e-4 for i in range(2))
    assert SUPPORT.contains(PROPOSAL.to_raw(u)).all()


@given(psi=psis, seed=st.integers(0, 2**32 - 1))
@example(psi=np.array([[0.0, 3.0], [0.0, -4.0]]), seed=0)  # 60 standard deviations outside: Z underflows
@settings(max_examples=50)
def test_density_moments_and_gradients_agree_with_scipy(psi, seed):
    u = PROPOSAL.sample(psi, 5, np.random.default_rng(seed))
    assert SUPPORT.contains(PROPOSAL.to_raw(u)).all()
    expected = reference(psi)
    np.testing.assert_allclose(PROPOSAL.log_density(psi, u), expected.logpdf(u), rtol=1e-8, atol=1e-8)
    mean, std = PROPOSAL.mean_and_std(psi)
    np.testing.assert_allclose(mean, expected.mean(), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(std, expected.std(), rtol=1e-4, atol=1e-8)
    for row, score in zip(u, PROPOSAL.score(psi, u), strict=True):
        numeric = gradient(lambda at, row=row: PROPOSAL.log_density(at, row[None]).sum(), psi)
        np.testing.assert_allclose(score, numeric, rtol=1e-4, atol=1e-5 * max(1, abs(score).max()))
    numeric = gradient(lambda at: entropy(at).sum(), psi)
    np.testing.assert_allclose(PROPOSAL.entropy_gradient(psi), numeric, rtol=1e-3, atol=1e-4)


def test_mode_beyond_the_support_is_its_edge():
    mode = PROPOSAL.mode(np.array([[0.5, 7.0], [0.0, 0.0]]))
    np.testing.assert_allclose(mode, [0.5, PROPOSAL.high[1]])
    assert SUPPORT.contains(PROPOSAL.to_raw(mode))[0]
