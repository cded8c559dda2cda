from types import SimpleNamespace

import numpy as np
import pytest
from measurements import LIGHT, measured
from scipy.special import polygamma

import avobench
from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.fit.null import best_null, fit_null
from avobench.diagnosis.fit.surrogate import Design
from avobench.diagnosis.goodness_of_fit.gates import summary_gate
from avobench.effects.bank import Bank, Given
from avobench.effects.model import Model
from avobench.tasks.meter import Meter
from avobench.tasks.poisson import Poisson


def fitted(model, x, rng, effort=LIGHT):
    """The fit by the covariance of its own model."""
    return summary_gate(*fit_null(model, x, rng, effort, None), rng, effort)[1]


def test_poisson_fit_attains_the_fisher_information():
    pulls, ratios = [], []
    for k in range(6):
        own = fitted(Model(Poisson()), *measured(Poisson(), [1.5], 4000, k))
        ratios.append(own.std[0] / np.sqrt((1 + own.noise) / (4000 * np.exp(1.5))))
        pulls.append((own.params[0] - 1.5) / own.std[0])
    assert np.median(ratios) == pytest.approx(1, rel=0.2)
    assert np.sqrt(np.mean(np.square(pulls))) < 1.8


def test_errors_are_not_below_the_best_possible_where_a_model_is_curved():
    """The shape of a gamma distribution, by the Cramer-Rao bound: over too wide a design its slope seems steeper."""
    prior = {"k": (0.3, 8), "s": (0.2, 5)}
    task = avobench.task(lambda theta, rng: rng.gamma(theta[:, 0], theta[:, 1]), prior=prior)
    bound, pulls, errors = 1 / np.sqrt(1000 * (polygamma(1, 2.0) - 0.5)), [], []
    for k in range(10):
        rng = np.random.default_rng(k)
        own = fitted(Model(task, events=Bank(task, Meter(), k)), rng.gamma(2, 1, (1000, 1)), rng, Effort())
        pulls.append((own.params[0] - 2) / own.std[0])
        errors.append(own.std[0] / np.sqrt(1 + own.noise))
    assert np.median(errors) > 0.9 * bound
    assert np.sqrt(np.mean(np.square(pulls))) < 1.6


def test_a_sample_at_a_few_thetas_determines_theta_as_the_simulator_would():
    """The nodes lie three standard errors apart: a design between two of them hardly sees a slope."""
    rng = np.random.default_rng(1)
    lifetimes = np.repeat(np.linspace(1.6, 2.4, 9), 8000)
    task = avobench.bank(rng.exponential(lifetimes), theta={"lifetime": lifetimes})
    own = fitted(Model(task, events=Given(task, Meter())), rng.exponential(1.9, (3000, 1)), rng)
    assert own.std[0] == pytest.approx(1.9 / np.sqrt(3000), rel=0.6)
    assert own.params[0] == pytest.approx(1.9, abs=4 * own.std[0])


def test_a_fit_that_leaves_much_is_the_same_whatever_the_seed():
    """Counts with a long tail, which no rate describes: a search that stops short would show in the gap."""
    rng = np.random.default_rng(7)
    x = rng.poisson(4 * rng.pareto(2.5, 8000) + 0.5)[:, None]
    found = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        fit, target = fit_null(Model(Poisson()), x, rng, LIGHT, None)
        found.append(best_null([fit], target, rng, LIGHT).params[0])
    assert np.ptp(found) < 0.1


@pytest.mark.parametrize("rank", [2, 20, 300])
def test_slopes_of_noise_alone_identify_nothing(rank):
    """Also where few numbers are fitted, whose noise has a long tail."""
    rng, found = np.random.default_rng(0), 0
    for slopes in rng.normal(0, 100.0, (2000, rank, 1)):
        noise = np.array([[rank * 100.0**2]])
        fit = Fit(SimpleNamespace(dim=1), np.zeros(1), np.zeros(rank), slopes, noise, 1, 0, 0, 0, Design(0, np.eye(1)))
        found += fit.num_identified
    assert found < 10
