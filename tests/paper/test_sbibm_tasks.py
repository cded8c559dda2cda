"""The simulators of others have the information of their densities, and the solutions of their equations.

What every task has is tested beside the hard ones, in test_hard_tasks.py.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import multivariate_normal, norm

from paper.sbibm_tasks import GaussianMixture, Glm, Sir, Slcp, TwoMoons


def events(task, theta, n):
    return task.simulate(np.tile(theta, (n, 1)), np.random.default_rng(0))


def mean_square(log_density, theta, steps=1e-5):
    """The Fisher information from the slopes of log densities of events, by central differences."""
    slopes = [
        (log_density(theta + step) - log_density(theta - step)) / (2 * steps) for step in steps * np.eye(len(theta))
    ]
    return np.array(slopes) @ np.transpose(slopes) / len(slopes[0])


def test_the_information_of_slcp_is_that_of_its_gaussians():
    theta = np.array([0.5, -1.0, -1.2, 0.8, 0.4])
    x = events(Slcp(), theta, 100_000)

    def log_density(theta):
        a, b, rho = theta[2] ** 2, theta[3] ** 2, np.tanh(theta[4])
        of_one = multivariate_normal(theta[:2], [[a**2, rho * a * b], [rho * a * b, b**2]])
        return of_one.logpdf(x.reshape(-1, 4, 2)).sum(axis=1)

    signs = np.array([1, 1, -1, 1, 1])
    expected = mean_square(log_density, theta) * np.outer(signs, signs)
    assert Slcp().information(theta) == pytest.approx(expected, abs=0.02 * expected.max())
    assert Slcp().identifiable(theta[None])[0].tolist() == (theta * signs).tolist()


def test_the_information_of_the_mixture_and_of_the_crescent_is_the_mean_square_of_their_scores():
    theta = np.array([0.3, -0.2])
    x = events(GaussianMixture(), theta, 200_000)

    def mixture(theta):
        return np.log(sum(norm.pdf(x, theta, width).prod(axis=1) for width in (1, 0.1)))

    assert GaussianMixture().information(theta) == pytest.approx(mean_square(mixture, theta), rel=0.02, abs=1)
    moons = TwoMoons()
    x = events(moons, theta, 200_000)
    left, up = moons.identifiable(theta[None])[0]

    def crescent(shift):
        r = np.hypot(*(x - [0.25 - shift[0], shift[1]]).T)
        return norm.logpdf(r, 0.1, 0.01) - np.log(r)

    expected = mean_square(crescent, np.array([left, up]))
    assert moons.information(theta) == pytest.approx(expected, rel=0.02, abs=60)
    other = moons.simulate(np.tile(-theta[::-1], (200_000, 1)), np.random.default_rng(1))
    assert other.mean(axis=0) == pytest.approx(x.mean(axis=0), abs=1e-3)


def test_events_of_the_neuron_are_its_sufficient_statistic():
    """So their covariance is the information on the coefficients."""
    theta = np.linspace(-1, 1, 10)
    found = np.cov(events(Glm(), theta, 50_000).T)
    assert Glm().information(theta) == pytest.approx(found, abs=0.03 * np.abs(found).max())


def test_the_epidemic_solves_its_equations():
    contact, recovery = theta = np.array([0.6, 0.11])

    def change(day, state):
        new = contact * state[0] * state[1]
        return [-new, new - recovery * state[1]]

    days = np.arange(0, 154, 17)
    expected = solve_ivp(change, (0, 153), [1 - 1e-6, 1e-6], t_eval=days, rtol=1e-10, atol=1e-14).y[1]
    assert Sir.infected(theta[None])[0] == pytest.approx(expected, rel=1e-3)  # half a day is a step
    assert events(Sir(), theta, 20_000).mean(axis=0) == pytest.approx(1000 * expected, rel=0.02, abs=0.05)
