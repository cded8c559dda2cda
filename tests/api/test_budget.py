"""The number of simulated events that is said is the number that a counter in the simulator counts."""

import numpy as np
import pytest

import avobench


class Counter:
    """A simulator of decay times that counts its events."""

    def __init__(self):
        self.used = 0

    def __call__(self, theta, rng):
        self.used += len(theta)
        return rng.exponential(theta[:, 0])


@pytest.fixture
def counted():
    """A task, and the counter in its simulator, from zero."""
    counter = Counter()
    task = avobench.task(counter, prior={"lifetime": (1, 4)}, name="decay")
    counter.used = 0
    return task, counter


MEASURED = np.random.default_rng(0).exponential(2.2, 2000)


@pytest.mark.parametrize(("method", "budget"), [("smm", 300), ("smm", 40_000), ("abc-smc", 4000), ("avo", 2000)])
def test_a_fit_simulates_what_it_says_and_no_more_than_its_budget(counted, method, budget):
    task, counter = counted
    few = {"abc-smc": {"population_size": 20, "events_per_theta": 20}, "avo": {"iterations": 20}}
    found = avobench.infer(task, MEASURED, method, budget=budget, settings=few.get(method, {}))
    assert counter.used == found.num_simulations <= budget


@pytest.mark.parametrize("simulations", [None, 700_000])
def test_a_diagnosis_simulates_what_it_says_and_no_more_than_its_limit(counted, tmp_path, simulations):
    """What was saved, and the model in memory, take no further event."""
    task, counter = counted
    x = MEASURED.copy()
    x[:100] = 9.0
    found = avobench.diagnose(task, x, simulations=simulations, effects=["outliers", "peak_background"])
    assert found.model.num_features == 1
    found.plot()
    assert counter.used == found.diagnosis.num_simulations <= (simulations or 10**9)


def test_a_diagnosis_that_is_refused_has_simulated_no_more_than_the_checks_of_its_limit(counted):
    task, counter = counted
    with pytest.raises(avobench.UsageError, match="too few"):
        avobench.diagnose(task, MEASURED, simulations=10_000)
    assert counter.used <= 500
