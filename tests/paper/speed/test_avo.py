"""The benchmark of AVO's step measures what it says."""

import numpy as np
import pytest
import torch
from click.testing import CliRunner

from paper.speed import avo
from paper.speed.avo import Update
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


def test_the_command_prints_both_tables(monkeypatch):
    monkeypatch.setattr(avo, "updates", lambda: [SMALL])
    done = CliRunner().invoke(avo.main, ["--task", "carl", "--batch-size", "8", "--rounds", "1"])
    assert done.exit_code == 0, done.output
    assert "an iteration of avo-paper, median of 1 rounds" in done.output
    assert "8-8" in done.output
