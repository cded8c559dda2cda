"""The benchmarks of speed measure what they say."""

import numpy as np
import pandas as pd
import pytest
import torch

from avobench.bench.registry import build
from avobench.methods.avo_paper import AvoPaper
from avobench.speed.avo import Noise, discriminator_step, whole_step
from avobench.speed.growth import against_budget_and_observations, exponent, sweep
from avobench.speed.plain_avo import PlainAvo


@pytest.mark.parametrize("power", [-1.0, 0.0, 0.5, 2.0])
def test_the_exponent_of_a_power_law_is_its_power(power):
    x = pd.Series([1.0, 3.0, 10.0, 200.0])
    assert exponent(x, 7 * x**power) == pytest.approx(power, abs=1e-12)


def test_time_and_memory_are_told_for_every_size():
    table = against_budget_and_observations("avo-paper", (1000, 2000))
    assert table["size"].tolist() == [1000, 2000] * 2
    assert (table["seconds"] > 0).all()


def test_memory_does_not_grow_with_the_number_of_cells(tmp_path):
    """The leader keeps some kilobytes a cell: its records without their traces."""
    few = sweep(1, 2, 1, 480, tmp_path / "few")
    many = sweep(10, 6, 1, 480, tmp_path / "many")
    assert many["cells"] == 60
    assert many["of it new [MiB]"] < few["of it new [MiB]"] + 3


def test_the_plain_implementation_follows_the_same_algorithm():
    """From one state both updates of psi are those of AvoPaper: here the gradient of the proposal."""
    task = Noise(build("task", "carl", {}))
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
    assert AvoPaper(schedule="shared").batch_size == 32
    assert task.num_features == 5


def test_every_column_of_the_step_is_a_time():
    carl = build("task", "carl", {})
    whole, part = whole_step(carl, 16, 3), discriminator_step(carl, 16, 3)
    assert whole["plain [ms]"] > 0  # the others are differences, which noise may turn
    assert whole["plain / fused"] == whole["plain [ms]"] / whole["fused [ms]"]
    assert all(value > 0 for value in part.values())
    assert part["share"] == part["products [ms]"] / part["fused [ms]"]
