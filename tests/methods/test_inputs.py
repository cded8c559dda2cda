"""What avo's discriminator sees."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import kstest

import avobench
from avobench.methods.inputs import GaussianScale, Inputs
from gaussian import GaussianMean, gaussian_problem


class Image(GaussianMean):
    """Images of 3 x 4, on which a shift along the second axis means nothing."""

    num_features, event_shape, cyclic_axes = 12, (3, 4), (1,)


def observed(x, task=GaussianMean):
    return replace(gaussian_problem(task(), 1), x_observed=x)


@pytest.mark.parametrize("whiten", [True, False])
def test_inputs_have_zero_mean_and_unit_spread(whiten):
    x = np.random.default_rng(0).multivariate_normal([5, -3], [[4, 1.2], [1.2, 1]], 20_000)
    seen = Inputs(observed(x), symmetric=True, whiten=whiten)(x)
    assert seen.dtype == np.float32
    np.testing.assert_allclose(seen.mean(axis=0), 0, atol=1e-4)
    covariance = np.cov(seen.T)
    np.testing.assert_allclose(np.diag(covariance), 1, rtol=0.05)
    assert (abs(covariance[0, 1]) < 0.01) == whiten


@given(
    arrays(float, st.integers(2, 40), elements=st.floats(-1e9, 1e9)), arrays(float, 20, elements=st.floats(-1e12, 1e12))
)
def test_a_gaussian_scale_keeps_the_order_of_all_values(observed, x):
    """Also of those beyond what was observed, and of equal ones."""
    scale = GaussianScale(observed)
    made = scale(np.sort(x))
    assert np.isfinite(made).all()
    assert (np.diff(made) >= 0).all()
    assert scale(observed).tolist() == pytest.approx((-GaussianScale(-observed)(-observed)).tolist(), abs=1e-6)


def test_on_their_gaussian_scale_observed_values_are_gaussian_and_those_beyond_are_told_apart():
    rng = np.random.default_rng(4)
    x = rng.standard_cauchy(10_000)
    scale = GaussianScale(x)
    assert kstest(scale(x), "norm").pvalue > 0.99
    far = scale(np.array([1, 2, 10, 1000]) * x.max())
    assert (np.diff(far) > 0.1).all()
    assert far[-1] < 15
    counts = rng.poisson(3, 1000).astype(np.uint8)
    assert (np.diff(GaussianScale(counts)(np.arange(256, dtype=np.uint8))) > 0).all()


def test_images_are_summed_over_their_cyclic_axes():
    x = np.random.default_rng(1).poisson(2, (500, 12)).astype(np.uint8)
    rolled = np.roll(x.reshape(-1, 3, 4), 1, axis=2).reshape(-1, 12)
    symmetric = Inputs(observed(x, Image), symmetric=True, whiten=True)
    assert symmetric(x).shape == (500, 3)
    np.testing.assert_array_equal(symmetric(x), symmetric(rolled))
    flat = Inputs(observed(x, Image), symmetric=False, whiten=True)
    assert flat(x).shape == (500, 12)
    assert np.abs(flat(x) - flat(rolled)).max() > 1


def test_a_feature_that_never_varied_stays_finite():
    x = np.random.default_rng(2).normal(size=(100, 2)) * [1, 0]
    seen = Inputs(observed(x), symmetric=True, whiten=True)
    assert np.abs(seen(np.ones((3, 2)))).max() < 1.2 / np.sqrt(1e-3 / 2)
    constant = Inputs(observed(x * 0), symmetric=True, whiten=True)
    np.testing.assert_array_equal(constant(x * 0), 0)


FAR = [(0.0, 1.0), (1.7e9, 1.0), (-1e3, 1e3), (1e12, 0.1), (-1e12, 1.0)]
"""Offsets of a feature, and its units."""
SETTINGS = {"smm": {}, "rank-moments": {}, "avo": {"iterations": 50}, "avo-paper": {}, "nle": {"steps": 20}}


@pytest.mark.parametrize("method", SETTINGS)
def test_where_a_feature_is_counted_from_and_its_unit_are_nothing_to_the_answer(method):
    """Times since 1970 are the same data as those since the run began; float32 alone would lose what varies."""
    answers, budget = [], 6000 if "avo" in method else 4000
    for offset, unit in FAR if method == "smm" else FAR[:2]:

        def simulate(theta, rng, offset=offset, unit=unit):
            return offset + unit * rng.normal(theta[:, 0], 1)

        task = avobench.task(simulate, prior={"mean": (-3, 3)}, name="clock")
        x = simulate(np.full((300 if method == "nle" else 3000, 1), 0.7), np.random.default_rng(3))
        found = avobench.infer(task, x, method, budget=budget, settings=SETTINGS[method])
        answers.append(found.theta["mean"])
    np.testing.assert_allclose(answers, answers[0], atol=0.02)


@pytest.mark.parametrize("method", ["smm", "rank-moments", "avo"])
def test_what_the_simulator_can_never_make_moves_nothing_and_is_named(method):
    """A run number in the data that the simulator has as another one, and one that varies in the data alone."""
    rng = np.random.default_rng(0)
    energy = rng.normal(0.7, 1, 2000)
    run = 8 + 0.5 * energy + rng.normal(size=2000)

    def simulate(theta, rng):
        return np.column_stack([rng.normal(theta[:, 0]), np.full(len(theta), 7.0)])

    task = avobench.task(simulate, prior={"mean": (-3, 3)}, features=["energy", "run"], name="runs")
    settings = {"iterations": 20, "statistic_steps": 100} if method == "avo" else {}
    budget = 20_000 if method == "rank-moments" else 4000  # its statistic is learnt anew beside another feature
    same, constant, varying = (
        avobench.infer(task, np.column_stack([energy, each]), method, budget=budget, settings=settings)
        for each in (np.full(2000, 7.0), np.full(2000, 8.0), run)
    )
    assert constant.theta["mean"] == pytest.approx(same.theta["mean"], abs=same.std["mean"] / 4)
    assert varying.theta["mean"] == pytest.approx(same.theta["mean"], abs=same.std["mean"] / 2)
    assert "run = 7" in constant.estimate.doubt
    assert "run = 7" in varying.estimate.doubt
    assert not same.estimate.doubt


@pytest.mark.parametrize("method", ["smm", "rank-moments", "avo"])
@pytest.mark.parametrize("num_events", [100, 3000])
def test_of_nothing_counted_the_rate_is_low_with_an_error_that_covers_it(method, num_events):
    """The largest rate that still makes no count in so many events with a probability of 5 % is 3 over their number."""
    task = avobench.task(lambda theta, rng: rng.poisson(theta[:, 0]), prior={"rate": (0, 10)}, name="counter")
    settings = {"iterations": 20, "statistic_steps": 100} if method == "avo" else {}
    found = avobench.infer(task, np.zeros(num_events, int), method, budget=6000, settings=settings)
    assert "alike" in found.estimate.doubt
    assert 1 / num_events < found.theta["rate"] + found.std["rate"] < 0.3


@pytest.mark.parametrize("ratio", [1e4, 1e12, 1e24])
def test_units_of_features_that_are_far_apart_lose_no_parameter(ratio):
    scale = np.array([np.sqrt(ratio), 1 / np.sqrt(ratio)])
    task = avobench.task(lambda theta, rng: scale * rng.normal(theta), prior={"a": (-5, 5), "b": (-5, 5)}, name="apart")
    x = scale * np.random.default_rng(0).normal([1.0, 2.0], size=(2000, 2))
    found = avobench.infer(task, x, "smm", budget=10_000)
    assert list(found.theta.values()) == pytest.approx(x.mean(axis=0) / scale, abs=0.06)
    assert list(found.std.values()) == pytest.approx([0.0245, 0.0245], rel=0.3)


def test_one_event_is_fitted_with_a_doubt_and_no_warning():
    task = avobench.task(lambda theta, rng: rng.normal(theta), prior={"a": (-5, 5)}, name="one")
    with warnings.catch_warnings(action="error"):
        assert avobench.infer(task, np.array([0.5]), "smm", budget=10_000).estimate.doubt
