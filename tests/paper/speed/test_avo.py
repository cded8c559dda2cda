"""The benchmark of AVO's step measures what it says."""

import numpy as np
import pytest
import torch

from paper.speed.plain_avo import PlainAvo


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
