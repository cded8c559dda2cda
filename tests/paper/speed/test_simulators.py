"""Simulators and what they are compared with do the same, and both are timed."""

import numpy as np
import pytest

from avobench.bench.plugins.registry import build
from paper.speed.simulators import BARE


@pytest.mark.parametrize("name", BARE)
def test_the_bare_simulators_have_the_distribution_of_the_tasks(name):
    task, rng = build("task", name, {}), np.random.default_rng(0)
    theta = np.repeat(task.targets()[:1], 200_000, axis=0)
    x, bare = task.simulate(theta, rng), BARE[name](theta, rng)
    error = np.sqrt((x.var(axis=0) + bare.var(axis=0)) / len(x))
    assert (np.abs(x.mean(axis=0) - bare.mean(axis=0)) < 4.5 * error).all()
    assert bare.std(axis=0) == pytest.approx(x.std(axis=0), rel=0.02)
