"""The benchmark of AVO's step measures what it says."""

import numpy as np
import pytest
import torch
from click.testing import CliRunner

from avobench.bench.plugins.registry import build
from avobench.methods.discriminator import mlp
from avobench.methods.fused_step import FusedStep
from paper.speed import avo
from paper.speed.avo import Update, discriminator_update, iteration, products, updates
from paper.speed.plain_avo import PlainAvo

SMALL = Update("a small one", 2, 3, (8, 8), 16)


def test_the_plain_implementation_follows_the_same_algorithm():
    """From one state both updates of psi are those of AvoPaper: here the gradient of the proposal."""
    rng = np.random.default_rng(0)
    x = rng.standard_normal((100, 5))
    plain = PlainAvo(x, lambda theta: x[: len(theta)], 2, (8,), 16, rng)
    theta = rng.standard_normal((16, 2))
    before = torch.cat([plain.mean, plain.log_std]).detach().numpy().copy()
    inputs = torch.as_tensor(x[:16], dtype=torch.float32)
    f = (1 - plain.discriminator(inputs)).log().detach().numpy()[:, 0].astype(float)
    plain._update_proposal(torch.as_tensor(theta, dtype=torch.float32), inputs)
    score = np.stack([theta, theta**2 - 1], axis=1)  # of a standard Gaussian without bounds
    b = (score**2 * f[:, None, None]).mean(axis=0) / (score**2).mean(axis=0)
    expected = (score * (f[:, None, None] - b)).mean(axis=0)
    assert np.concatenate([plain.mean.grad, plain.log_std.grad]) == pytest.approx(expected.ravel(), rel=1e-3, abs=1e-6)
    assert (torch.cat([plain.mean, plain.log_std]).detach().numpy() != before).all()


def test_an_iteration_of_avo_paper_is_timed_beside_the_plain_one():
    measured = iteration(build("task", "carl", {}), 16, 3)
    assert measured["plain [ms]"] > 0  # the other is a difference, which noise may turn
    assert measured["plain / avo-paper"] == measured["plain [ms]"] / measured["avo-paper [ms]"]


def test_every_way_of_an_update_is_timed():
    measured = discriminator_update(SMALL, 3)
    assert [name for name in measured if name.startswith(("autograd", "stacked"))] == [
        f"{way}, {adam} / by hand" for way in ("autograd", "stacked") for adam in ("foreach", "fused")
    ]
    assert all(value > 0 for value in measured.values())
    assert measured["with traffic"] > measured["products / by hand"]


def test_the_networks_are_those_that_the_methods_train():
    shapes = {(update.networks, update.features, update.hidden, update.events) for update in updates()}
    for expected in [
        *[(networks, features, (64, 64, 64), 256) for networks in (2, 30) for features in (1, 5, 32)],
        *[(1, 1, hidden, half) for hidden in ((600,) * 3, (1000,) * 4) for half in (16, 32)],
    ]:
        assert expected in shapes


def test_the_products_are_five_a_layer_and_four_in_the_first(monkeypatch):
    networks = [mlp(SMALL.features, SMALL.hidden, np.random.default_rng(0)) for _ in range(SMALL.networks)]
    multiply, shapes = products(FusedStep(networks, 1e-3, 1.0), SMALL.events), []
    monkeypatch.setattr(torch, "bmm", lambda a, b, out: shapes.append((*a.shape, b.shape[2])))
    multiply()
    assert len(shapes) == 4 + 5
    assert sum(n * q * p for _, n, p, q in shapes) == (2 + 1 + 1 + 3) * 16 * 3 * 8 + (2 + 1 + 1 + 3 + 2) * 16 * 8 * 8


def test_the_command_prints_both_tables(monkeypatch):
    monkeypatch.setattr(avo, "updates", lambda: [SMALL])
    done = CliRunner().invoke(avo.main, ["--task", "carl", "--batch-size", "8", "--rounds", "1"])
    assert done.exit_code == 0, done.output
    assert "an iteration of avo-paper, median of 1 rounds" in done.output
    assert "8-8" in done.output


def test_a_task_that_does_not_exist_is_an_error_in_a_line():
    done = CliRunner().invoke(avo.main, ["--task", "poison"])
    assert done.exit_code == 1
    assert "did you mean poisson?" in done.output
