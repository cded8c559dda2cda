"""The parts of z against their exact distributions, the information, and the floor as a fit attains it."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize

from avobench.bench.plugins import registry
from avobench.tasks import warped
from avobench.tasks.warped import NARROW, WIDE, Means5, Mixed, Warped5, Warped10, gaussian, information, rotation

NAMES = {f"{family}-{p}" for family in ("warped", "means") for p in (2, 5, 10, 20)}


def unwarped(x):
    """z / SPREAD of events: (n, d) -> (n, d)."""
    return np.arcsinh(x @ rotation(x.shape[1])) / warped.SPREAD


def log_likelihood(task, theta, z):
    """log p(x | theta) of events that are `unwarped`, summed, but for a constant: it says what the floor is."""
    columns, total = iter(z.T), 0.0
    for kind, t in zip(task.kinds, theta, strict=True):
        z = next(columns)
        if kind == "mean":
            total -= ((z - t) ** 2).sum() / 2
        elif kind == "scale":
            total -= (z**2).sum() * np.exp(-2 * t) / 2 + len(z) * t
        elif kind == "tail":
            share = (1 + np.tanh(t)) / 2
            total += np.log(share * gaussian(z, WIDE) + (1 - share) * gaussian(z, NARROW)).sum()
        else:
            r = np.tanh(t)
            total -= ((next(columns) - r * z) ** 2).sum() / (1 - r**2) / 2 + len(z) * np.log(1 - r**2) / 2
    return float(total)


def events(task, theta, n, seed):
    return task.simulate(np.tile(theta, (n, 1)), np.random.default_rng(seed))


def test_they_are_registered_and_no_part_of_a_sweep_without_names():
    by_default = {name for name in registry.names("task") if registry.load("task", name).by_default}
    assert set(registry.names("task")) - by_default >= NAMES
    assert by_default >= {"poisson", "carl"}


def test_the_map_is_inverted():
    task = Warped5()
    z = np.random.default_rng(0).normal(size=(100, task.num_features))
    x = np.sinh(warped.SPREAD * z) @ rotation(task.num_features).T
    np.testing.assert_allclose(unwarped(x), z, atol=1e-10)
    np.testing.assert_allclose(rotation(6) @ rotation(6).T, np.eye(6), atol=1e-12)


def test_parts_of_z_follow_their_distributions():
    theta = np.array([0.5, -0.6, 0.3, 0.7, -0.4])  # scale, correlation (two coordinates), tail, mean, scale
    z = unwarped(events(Warped5(), theta, 20_000, 1))
    share, r = (1 + np.tanh(0.3)) / 2, np.tanh(-0.6)
    mixture = lambda t: share * stats.norm(0, WIDE).cdf(t) + (1 - share) * stats.norm(0, NARROW).cdf(t)  # noqa: E731
    rest = (z[:, 2] - r * z[:, 1]) / np.sqrt(1 - r**2)
    for values, cdf in (
        (z[:, 0], stats.norm(0, np.exp(0.5)).cdf),
        (z[:, 1], stats.norm().cdf),
        (rest, stats.norm().cdf),
        (z[:, 3], mixture),
        (z[:, 4], stats.norm(0.7).cdf),
        (z[:, 5], stats.norm(0, np.exp(-0.4)).cdf),
    ):
        assert stats.kstest(values, cdf).pvalue > 1e-4
    assert abs(np.corrcoef(rest, z[:, 1])[0, 1]) < 0.03


def test_only_means_move_the_mean_of_x():
    theta = np.array([0.6, 0.6, 0.6, 0.0, 0.6])
    x = events(Warped5(), theta, 100_000, 2)
    assert (np.abs(x.mean(axis=0)) < 5 * x.std(axis=0) / np.sqrt(len(x))).all()
    moved = events(Means5(), np.full(5, 0.3), 100_000, 3) @ rotation(5)
    assert (moved.mean(axis=0) > 0.2).all()


def test_the_information_is_the_variance_of_the_exact_score_of_each_kind():
    task, step = Warped10(), 1e-5
    theta = task.prior.sample(1, np.random.default_rng(4))[0]
    z = unwarped(events(task, theta, 1500, 5))
    scores = []
    for axis in step * np.eye(10):
        ends = [np.array([log_likelihood(task, theta + sign * axis, row[None]) for row in z]) for sign in (1, -1)]
        scores.append((ends[0] - ends[1]) / (2 * step))
    measured = np.cov(scores)
    exact = information(task.kinds, theta)
    np.testing.assert_allclose(np.diag(measured), exact, rtol=0.2)
    correlation = measured / np.sqrt(np.outer(exact, exact))
    assert np.abs(correlation - np.diag(np.diag(correlation))).max() < 6 / np.sqrt(len(z))


def test_the_quadrature_of_a_tail_has_converged():
    shares = (1 + np.tanh(0.4)) / 2
    fine = np.linspace(-20, 20, 400_001)
    wide, narrow = (stats.norm(0, width).pdf(fine) for width in (WIDE, NARROW))
    integral = np.trapezoid((wide - narrow) ** 2 / (shares * wide + (1 - shares) * narrow), fine)
    found = information(("tail",), np.array([0.4]))[0]
    assert found == pytest.approx((2 * shares * (1 - shares)) ** 2 * integral, rel=1e-6)


def test_the_floor_is_the_mean_squared_error_of_maximum_likelihood():
    """150 fits of 2 000 events: the mean of their squared errors is known to 12 % (5 parameters, unequal shares)."""
    task, theta, n, repetitions = Warped5(), np.array([0.3, -0.4, 0.2, 0.5, -0.3]), 2000, 150
    errors = []
    for seed in range(repetitions):
        z = unwarped(events(task, theta, n, 100 + seed))
        fit = minimize(lambda at, z=z: -log_likelihood(task, at, z) / n, np.zeros(5), method="BFGS")
        errors.append(((fit.x - theta) ** 2).sum())
    floor = task.floor(theta, n, None)
    assert np.mean(errors) == pytest.approx(floor, rel=0.35)
    assert task.floor(theta, n, n) == pytest.approx(2 * floor)


@pytest.mark.parametrize("cls", Mixed.__subclasses__())
def test_shares_of_the_floor_sum_to_one(cls):
    assert sum(cls.floor_shares) == pytest.approx(1)
    assert len(cls.parameter_names) == cls.prior.dim == int(cls.name.rpartition("-")[2])
