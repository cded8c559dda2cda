"""The adapters of sbi, and the posterior of many rows that they share."""

import numpy as np
import pytest
import torch

from avobench.bench.cells.budget import MeteredSimulator, pose
from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute, execute_together
from avobench.methods.nle import Nle
from avobench.methods.npe import Npe, Tsnpe
from avobench.methods.nre import Nre
from avobench.methods.product_posterior import posterior
from avobench.tasks import Box
from avobench.tasks.poisson import Poisson

METHODS = [Nre(steps=300), Nle(steps=300), Npe(steps=300), Tsnpe(rounds=2, steps=200)]


def problem(task, truth, budget, num_observed=5_000, seed=0):
    rng = np.random.default_rng(seed)
    x = task.simulate(np.tile(truth, (num_observed, 1)), rng)
    return pose(task, x, MeteredSimulator(task, budget, rng))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_rate_is_found_within_the_budget(method):
    """No nearer than chance would be a third of the prior's width; a tenth of that is learning."""
    posed = problem(Poisson(), [2.0], 20_000)
    estimate = method.infer(posed, np.random.default_rng(1))
    assert estimate.theta[0] == pytest.approx(2.0, abs=0.13)
    assert 0 < estimate.std[0] < 0.1
    assert 0.95 * 20_000 < posed.simulate.used <= 20_000
    assert [point.simulations for point in estimate.trace][-1] == posed.simulate.used
    assert len(estimate.trace) == method.rounds


@pytest.mark.xfail(
    reason="the sample collapses: its width is a tenth of the exact one, or less, in 7 runs of 8", strict=True
)
def test_the_posterior_of_three_parameters_is_the_exact_one():
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((20_000, 3)).astype(np.float32)
    found = posterior(lambda theta, x: -((x - theta) ** 2).sum(-1) / 2, rows, Box((-2,) * 3, (2,) * 3), rng, 400)
    assert found.std == pytest.approx(len(rows) ** -0.5, rel=0.5)


def test_the_posterior_of_many_rows_is_the_exact_one():
    """Of a correlated Gaussian mean with known noise: (n, 2) rows, so the posterior is Gaussian about their mean."""
    rng, covariance = np.random.default_rng(2), np.array([[1.0, 0.8], [0.8, 2.0]])
    rows = rng.multivariate_normal([0.3, -0.5], covariance, 4_000).astype(np.float32)
    precision = torch.tensor(np.linalg.inv(covariance)).float()

    def log_factors(theta, x):
        return -((x - theta) @ precision * (x - theta)).sum(-1) / 2

    found = posterior(log_factors, rows, Box((-2, -2), (2, 2)), rng, 100)
    exact = np.sqrt(np.diag(covariance) / len(rows))
    assert found.mode == pytest.approx(rows.mean(axis=0), abs=0.01 * exact.min())
    assert (np.abs(found.mean - rows.mean(axis=0)) < 0.8 * exact).all()  # of some 40 weighted points
    assert (np.abs(np.log(found.std / exact)) < 0.7).all()


def test_an_amortised_network_is_the_same_for_every_target_and_its_records_say_so():
    cells = [Cell("carl", {}, "nle", {"amortised": True, "steps": 20}, target, 0, 4_000, 100, 0) for target in (0, 1)]
    together = execute_together(cells, [None, None])
    alone = [execute(cell) for cell in cells]
    for one, other in zip(together, alone, strict=True):
        assert one["status"] == "ok", one["message"]
        assert one["theta_hat"] == pytest.approx(other["theta_hat"], rel=1e-4)
        assert one["simulations_used"] == 4_000
        assert one["amortised"] is True
    assert "amortised" not in execute(Cell("carl", {}, "nle", {"steps": 20}, 0, 0, 4_000, 100, 0))
