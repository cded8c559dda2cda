"""Simulators and what they are compared with do the same, and both are timed."""

import numpy as np
import pytest

from avobench.bench.plugins.registry import build
from paper.speed.simulators import BARE, numpy_rates


@pytest.mark.parametrize("name", BARE)
def test_the_bare_simulators_have_the_distribution_of_the_tasks(name):
    task, rng = build("task", name, {}), np.random.default_rng(0)
    theta = np.repeat(task.targets()[:1], 200_000, axis=0)
    x, bare = task.simulate(theta, rng), BARE[name](theta, rng)
    error = np.sqrt((x.var(axis=0) + bare.var(axis=0)) / len(x))
    assert (np.abs(x.mean(axis=0) - bare.mean(axis=0)) < 4.5 * error).all()
    assert bare.std(axis=0) == pytest.approx(x.std(axis=0), rel=0.02)


def test_rates_of_the_numpy_simulators_are_told_for_each():
    table = numpy_rates(100, num_events=2000, rounds=2)
    assert table["task"].tolist() == list(BARE)
    assert (table[["events/s", "bare", "times the bare"]] > 0).all(axis=None)
