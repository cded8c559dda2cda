"""The cosine against its exact density, the asymmetry, and the posterior along the curves that it leaves degenerate."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from avobench.tasks.weinberg import Weinberg, sample_cosine

TASK = Weinberg()
PRIOR_DRAWS = TASK.prior.sample(1_000_000, np.random.default_rng(99))
ASYMMETRIES = TASK.asymmetry(PRIOR_DRAWS)


def p_value(x: np.ndarray, c: float) -> float:
    """Kolmogorov-Smirnov against the integral of 3/8 (1 + x^2 + c x) from -1."""
    return stats.kstest(x, lambda t: 3 / 8 * (t + t**3 / 3 + c * t**2 / 2 + 4 / 3 - c / 2)).pvalue


@pytest.mark.parametrize("theta", [(45.0, 1.3), (47.0, 2.0), (43.5, 1.0), (46.0, 0.4)])
def test_the_cosine_follows_the_exact_density(theta):
    c = 2 * np.tanh((2 * theta[0] - 90) / 90 * 10) * theta[1]
    assert p_value(TASK.simulate(np.tile(theta, (40_000, 1)), np.random.default_rng(0))[:, 0], c) > 1e-4
    x = np.linspace(-1, 1, 9)
    np.testing.assert_allclose(TASK.density(x, np.array(theta)), 3 / 8 * (1 + x**2 + c * x))


@pytest.mark.parametrize("c", [-2.0, -1.0, 0.0, 1e-9, 1.995, 2.0])
def test_the_density_is_exact_up_to_the_largest_asymmetry(c):
    x = sample_cosine(np.full(40_000, c), np.random.default_rng(1))
    assert p_value(x, c) > 1e-4
    assert p_value(x, c - 0.1) < 1e-4  # the check sees an asymmetry that is wrong by a tenth


@given(st.lists(st.floats(-2, 2) | st.sampled_from([-2.0, 2.0, 0.0, 5e-324]), min_size=1), st.integers(0))
def test_the_cosine_never_leaves_its_range(c, seed):
    x = sample_cosine(np.array(c), np.random.default_rng(seed))
    assert x.shape == (len(c),)
    assert (np.abs(x) <= 1).all()


def test_the_largest_uniform_draws_stay_in_range():
    extreme = SimpleNamespace(random=lambda n: np.full(n, np.nextafter(1, 0)))
    assert np.abs(sample_cosine(np.array([-2.0, 0.0, 2.0]), extreme)).max() <= 1


@pytest.mark.parametrize("c", [2.0000001, -3.0, np.nan])
def test_an_asymmetry_beyond_two_is_refused(c):
    with pytest.raises(ValueError, match=r"density is negative where \|c\| > 2"):
        sample_cosine(np.array([0.0, c]), np.random.default_rng(0))


def test_the_asymmetry_is_within_its_stated_bounds():
    assert 1.66 < np.abs(ASYMMETRIES).max() < 1.67
    corners = np.array([(e, g) for e in (42.8, 47.2) for g in (-0.2, 2.2)])
    assert TASK.support.contains(corners).all()
    assert 1.99 < np.abs(TASK.asymmetry(corners)).max() < 1.995


def test_the_summary_has_equal_bins_and_leaves_out_what_is_out_of_range():
    summary = TASK.summary(np.array([[-1.0], [-0.95], [0.0], [1.0]]))
    assert summary.shape == (20,)
    assert summary[[0, 10, 19]].tolist() == [0.5, 0.25, 0.25]
    assert TASK.summary(np.array([[-1.1], [0.0], [0.0], [1.1]])).sum() == 0.5
    assert Weinberg(num_bins=2).summary(np.array([[-0.5], [0.5]])).tolist() == [0.5, 0.5]


@pytest.mark.parametrize(("c", "width"), [(-1.0, 0.01), (0.5, 0.01), (-0.1, 0.002), (0.01, 5e-4), (1.5, 0.005)])
def test_the_posterior_is_that_of_prior_draws_of_the_same_asymmetry(c, width):
    """Independent of the formula: draws of the prior whose asymmetry falls in a narrow bin around c."""
    theta = PRIOR_DRAWS[np.abs(ASYMMETRIES - c) < width]
    error = np.sqrt(theta.var(axis=0) / len(theta))
    assert (np.abs(TASK.posterior_mean(c) - theta.mean(axis=0)) < 4 * error + width).all()
    at_c = np.array([46.5 if c > 0 else 43.5, c / (2 * np.tanh((46.5 - 45) / 4.5)) * np.sign(c)])
    assert TASK.asymmetry(at_c[None])[0] == pytest.approx(c)
    assert TASK.floor(at_c, 100_000, None) == pytest.approx(theta.var(axis=0).sum(), rel=0.06)


def test_the_floor_is_what_the_posterior_mean_attains_on_average_over_the_prior():
    theta = PRIOR_DRAWS[:200_000]
    error = ((TASK.posterior_mean(ASYMMETRIES[:200_000]) - theta) ** 2).sum(axis=1)
    assert error.mean() == pytest.approx(0.366, abs=0.004)
    assert np.median(error) == pytest.approx(0.18, abs=0.005)
    # an even number of midpoints, none of them at E_beam = 45, where c and the floor are 0
    grid = (np.mgrid[0:24, 0:24].reshape(2, -1).T + 0.5) / 24 * TASK.prior.width + TASK.prior.low
    assert np.mean([TASK.floor(theta, 100_000, 160_000) for theta in grid]) == pytest.approx(0.366, abs=0.003)
    assert theta.var(axis=0).sum() == pytest.approx(1.667, abs=0.01)


def test_the_posterior_mean_lies_on_no_side_but_that_of_its_asymmetry():
    c = np.array([0.3, 1e-4, 1e-12, 1e-300])
    above, below = TASK.posterior_mean(c), TASK.posterior_mean(-c)
    np.testing.assert_allclose(above[:, 0] - 45, 45 - below[:, 0])
    np.testing.assert_allclose(above[:, 1], below[:, 1])
    assert (np.diff(above, axis=0) < 0).all()  # towards the limit at c = 0
    assert TASK.posterior_mean(0.0).tolist() == [45, 0]


def test_the_curve_shrinks_to_a_corner_at_the_largest_asymmetry():
    corner = np.array(TASK.prior.high)
    np.testing.assert_allclose(TASK.posterior_mean(TASK.asymmetry(corner[None])[0]), corner)
    assert 0 <= TASK.floor(corner, 100_000, None) < 1e-12


@pytest.mark.parametrize("c", [1.68, -1.68, np.nan])
def test_an_asymmetry_that_the_prior_does_not_have_has_no_posterior(c):
    with pytest.raises(ValueError, match=r"the prior has \|c\| of at most 1.6693"):
        TASK.posterior_mean(c)


def test_the_floor_of_the_asymmetry_is_that_of_its_information():
    """At c = 0 the information of one event is 3/4 (1 - pi/4); maximum likelihood reaches it."""
    at_zero = np.array([45.0, 1.0])
    assert TASK.asymmetry_floor(at_zero, 1000, None) == pytest.approx(1 / 1000 / (3 / 4 * (1 - np.pi / 4)))
    assert TASK.asymmetry_floor(at_zero, 1000, 1000) == pytest.approx(2 * TASK.asymmetry_floor(at_zero, 1000, None))
    theta, n = np.array([46.0, 1.2]), 4_000
    fits, true = [], TASK.asymmetry(theta[None])[0]
    for seed in range(150):
        x = TASK.simulate(np.tile(theta, (n, 1)), np.random.default_rng(seed))[:, 0]
        t, c = x / (1 + x**2), true
        for _ in range(4):  # Newton on the likelihood of 1 + c t
            c += (t / (1 + c * t)).sum() / ((t / (1 + c * t)) ** 2).sum()
        fits.append(c)
    ratio = np.mean((np.array(fits) - true) ** 2) / TASK.asymmetry_floor(theta, n, None)
    assert stats.chi2(150).ppf(1e-4) / 150 < ratio < stats.chi2(150).ppf(1 - 1e-4) / 150
