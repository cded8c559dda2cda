"""The adapters of sbi, and the posterior of many rows that they share."""

import numpy as np
import pytest
import torch

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute, execute_together
from avobench.methods.nle import Nle
from avobench.methods.npe import Npe, Tsnpe
from avobench.methods.nre import Nre
from avobench.methods.product_posterior import posterior
from avobench.tasks import Box
from avobench.tasks.poisson import Poisson
from gaussian import problem_at

METHODS = [Nre(steps=300), Nle(steps=300), Npe(steps=300), Tsnpe(rounds=2, steps=200)]


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_rate_is_found_within_the_budget(method):
    """No nearer than chance would be a third of the prior's width; a tenth of that is learning."""
    problem = problem_at(Poisson(), [2.0], 20_000, 0, num_observed=2_000)
    estimate = method.infer(problem, np.random.default_rng(1))
    assert estimate.theta[0] == pytest.approx(2.0, abs=0.13)
    assert 0 < estimate.std[0] < 0.1
    assert 0.95 * 20_000 < problem.simulate.used <= 20_000
    assert estimate.trace[-1].simulations == problem.simulate.used
    assert len(estimate.trace) == method.rounds


@pytest.mark.parametrize("dim", [1, 2, 3, 5])
def test_the_posterior_of_many_rows_is_the_exact_one(dim):
    """Of a correlated Gaussian mean with known noise: (n, p) rows, so the posterior is Gaussian about their mean."""
    rng = np.random.default_rng(dim)
    root = np.linalg.cholesky(np.cov(rng.standard_normal((dim, 3 * dim))).reshape(dim, dim))
    rows = (rng.uniform(-1, 1, dim) + rng.standard_normal((2_000, dim)) @ root.T).astype(np.float32)
    precision = torch.tensor(np.linalg.inv(root @ root.T)).float()

    def log_factors(theta, x):
        return -((x - theta) @ precision * (x - theta)).sum(-1) / 2

    found = posterior(log_factors, rows, Box((-2,) * dim, (2,) * dim), rng, 100)
    exact = np.sqrt(np.diag(root @ root.T) / len(rows))
    assert found.mode == pytest.approx(rows.mean(axis=0), abs=0.02 * exact.min())
    assert (np.abs(found.mean - rows.mean(axis=0)) < 0.4 * exact).all()  # of some 170 weighted points or more
    assert found.std == pytest.approx(exact, rel=0.3)
    assert not found.doubt


def test_both_modes_of_a_posterior_have_points():
    """The sign of the first parameter is not determined: each has half of the probability."""
    rng = np.random.default_rng(0)
    rows = (np.array([0.7, 0.3]) + rng.standard_normal((5_000, 2))).astype(np.float32)

    def log_factors(theta, x):
        return -((x[:, 0] - theta[0].abs()) ** 2 + (x[:, 1] - theta[1]) ** 2) / 2

    found = posterior(log_factors, rows, Box((-2, -2), (2, 2)), rng, 400)
    assert found.sample.weights[found.sample.theta[:, 0] > 0].sum() == pytest.approx(0.5, abs=0.25)
    size = np.abs(found.sample.theta[:, 0])
    std = np.sqrt(found.sample.weights @ (size - found.sample.weights @ size) ** 2)
    assert std == pytest.approx(5_000**-0.5, rel=0.3)


def test_a_bent_ridge_of_a_posterior_is_covered():
    """The product of two parameters is determined alone; mean and width of the first are those of a grid."""
    rng = np.random.default_rng(0)
    rows = (0.5 + rng.standard_normal((5_000, 1))).astype(np.float32)
    found = posterior(
        lambda theta, x: -((x[:, 0] - theta[0] * theta[1]) ** 2) / 2, rows, Box((0.2, 0.2), (2, 2)), rng, 400
    )
    grid = np.linspace(0.2, 2, 1_000)
    log_p = -len(rows) * (grid[:, None] * grid - rows.mean()) ** 2 / 2
    of_first = np.exp(log_p - log_p.max()).sum(axis=1)
    mean = np.average(grid, weights=of_first)
    assert found.mean[0] == pytest.approx(mean, abs=0.15)
    assert found.std[0] == pytest.approx(np.sqrt(np.average((grid - mean) ** 2, weights=of_first)), rel=0.2)


def test_an_amortised_network_is_the_same_for_every_target_and_its_records_say_so():
    cells = [
        Cell("poisson", {}, "nle", {"amortised": True, "steps": 20}, target, 0, 4_000, 100, 0) for target in (0, 1)
    ]
    together = execute_together(cells, [None, None])
    alone = [execute(cell) for cell in cells]
    for one, other in zip(together, alone, strict=True):
        assert one["status"] == "ok", one["message"]
        assert one["theta_hat"] == pytest.approx(other["theta_hat"], rel=1e-4)
        assert one["simulations_used"] == 4_000
        assert one["amortised"] is True
    assert "amortised" not in execute(Cell("poisson", {}, "nle", {"steps": 20}, 0, 0, 4_000, 100, 0))
