"""Evidence against exact marginal likelihoods."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from avobench.diagnosis.search.evidence import evidence_of, prior


def linear(fit, residual, jacobian):
    """A fit of a model that is linear, known without noise."""
    p = fit.model.dim
    return replace(fit, residual=residual, jacobian=jacobian, jacobian_noise=np.zeros((p, p)), noise=0.0)


@given(st.integers(0, 1000))
def test_the_evidence_of_a_linear_model_is_its_marginal_likelihood(counter, seed):
    rng, r = np.random.default_rng(seed), 6
    fit = replace(counter.weak, point=np.full(counter.weak.model.dim, 0.5))
    jacobian, residual = rng.normal(0, 10, (r, fit.model.dim)), rng.normal(0, 0.3, r)  # no end of the range is near
    fit = linear(fit, residual, jacobian)
    precision, scale = prior(fit)
    steps = jacobian * scale
    cov = np.eye(r) + steps @ np.diag(1 / precision) @ steps.T
    exact = multivariate_normal(np.zeros(r), cov).logpdf(residual) + r / 2 * np.log(2 * np.pi)
    assert evidence_of(fit).value == pytest.approx(exact, rel=1e-8)


@given(st.integers(0, 1000))
def test_what_would_be_explained_beyond_the_end_of_a_range_is_no_evidence(counter, seed):
    rng = np.random.default_rng(seed)
    slope = rng.normal(0, 30, 6)
    ends = [replace(counter.null, point=np.array([end])) for end in (0.0, 1.0, 0.5)]
    below, above, inside = (evidence_of(linear(fit, 0.3 * slope, slope[:, None])).value for fit in ends)
    none = evidence_of(linear(counter.null, 0.3 * slope, np.zeros((6, 1)))).value
    assert above <= none + 1e-6
    assert inside > none
    assert below > none


def test_noise_of_the_simulation_is_taken_out_on_average(counter):
    rng, fit, r, noise = np.random.default_rng(0), counter.null, 40, 0.5
    jacobian = np.zeros((r, 1))
    clean = [evidence_of(linear(fit, rng.standard_normal(r), jacobian)).value for _ in range(2000)]
    noisy = [replace(linear(fit, np.sqrt(1 + noise) * rng.standard_normal(r), jacobian), noise=noise) for _ in clean]
    noisy = [evidence_of(each).value for each in noisy]
    assert np.mean(noisy) == pytest.approx(np.mean(clean), abs=0.5)
