"""A bank of few thetas says how far theta may be off because its events between them are a mixture."""

import numpy as np
import pytest

import avobench
from avobench.tasks.interpolation import shift


def of_ones(nodes, chance, num, seed=0):
    """Events (M, d) of zeros and ones, whose chances are a function of theta (k, p): linear between the nodes."""
    theta = np.repeat(np.asarray(nodes, float), num, axis=0)
    x = np.random.default_rng(seed).random((len(theta), theta.shape[1])) < chance(theta)
    return avobench.bank(x, theta={f"t{j}": column for j, column in enumerate(theta.T)})


def test_the_shift_in_one_parameter_is_that_of_a_chord():
    """The chord of t^2 from 0.4 to 0.6 lies 0.01 above 0.25, where its slope is 1; from 0.6 to 0.8 that is 1.4."""
    bank = of_ones([[0.2], [0.4], [0.6], [0.8]], lambda theta: theta**2, 200_000)
    for at, expected in ((0.5, 0.01), (0.7, 0.01 / 1.4)):
        np.testing.assert_allclose(np.abs(shift(bank, np.array([at]))), expected, rtol=0.1)


def test_the_shift_in_two_parameters_is_that_of_a_triangle():
    """In the middle of a triangle of a square grid of distance h each parameter has a variance of 2 h^2 / 9."""
    ends = [0.3, 0.5, 0.7, 0.9]
    bank = of_ones([(a, b) for a in ends for b in ends], lambda theta: theta**2, 50_000)
    middle = bank.nodes[bank.corners(np.array([0.6, 0.55]))].mean(axis=0)
    found = shift(bank, middle)
    np.testing.assert_allclose(np.abs(found), 2 * 0.04 / 9 / (2 * middle), rtol=0.15)
    assert (np.sign(found) == np.sign(found[0])).all()


@pytest.mark.parametrize("num", [250, 5000])
def test_where_means_are_linear_or_noise_hides_that_they_bend_nothing_is_added(num):
    ends = np.linspace(0.1, 0.9, 5)
    banks = [of_ones([(a, b) for a in ends for b in ends], lambda theta: theta, num, seed) for seed in range(10)]
    told = np.array([shift(bank, np.array([0.4, 0.55])) for bank in banks])
    assert (told == 0).mean() > 0.8
    assert np.abs(told).max() < 2 / np.sqrt(num)


def weibull(grid, num):
    ends = np.linspace(0.5, 4, grid), np.linspace(10, 100, grid)
    theta = np.repeat(np.array(np.meshgrid(*ends)).reshape(2, -1).T, num, axis=0)
    x = theta[:, 1] * np.random.default_rng(0).weibull(theta[:, 0])
    return avobench.bank(x, theta={"shape": theta[:, 0], "scale": theta[:, 1]}, features=["hours"])


def test_a_fit_between_thetas_far_apart_is_doubted_with_errors_that_hold():
    """They were too small by a factor of five."""
    x = 50 * np.random.default_rng(2).weibull(1.5, 2000)
    fit = avobench.infer(weibull(5, 3000), x, progress=False)
    assert "shape by" in fit.estimate.doubt
    assert abs(fit.theta["shape"] - 1.5) < 3 * fit.std["shape"]
    assert fit.covariance.loc["shape", "shape"] == pytest.approx(fit.std["shape"] ** 2)


@pytest.mark.parametrize(
    ("nodes", "doubt"), [(np.linspace(1.6, 2.4, 9), ""), ([1.0, 2.4], "2 thetas of the bank are too few")]
)
def test_a_fit_between_thetas_that_are_near_is_what_it_was_but_two_do_not_tell_what_lies_between(nodes, doubt):
    theta = np.repeat(nodes, 5000)
    bank = avobench.bank(np.random.default_rng(1).normal(theta), theta={"mean": theta})
    fit = avobench.infer(bank, np.random.default_rng(2).normal(2.03, 1, 2000), progress=False)
    assert doubt in fit.estimate.doubt
    assert doubt or not fit.estimate.doubt
    assert doubt or abs(fit.theta["mean"] - 2.03) < 3 * fit.std["mean"] < 0.09


def test_a_diagnosis_between_thetas_far_apart_is_doubted_with_errors_that_hold():
    rng = np.random.default_rng(0)
    rate = np.repeat(np.linspace(0.5, 4, 6), 6000)
    bank = avobench.bank(np.sqrt(rng.exponential(1 / rate)), theta={"rate": rate})
    found = avobench.diagnose(bank, np.sqrt(rng.exponential(1 / 1.55, 2000)), progress=False)
    before = found.diagnosis.theta_before["rate"]
    assert "rate by" in found.diagnosis.doubt
    assert before.std > 0.05
    assert abs(before.value - 1.55) < 2 * before.std
    [combination] = found.diagnosis.identified_before
    assert combination.std == pytest.approx(before.std / (4 - 0.5), rel=0.02)
