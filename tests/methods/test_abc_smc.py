import numpy as np
import pytest

from avobench.methods.abc_smc import AbcSmc, AbcSmcTuned
from avobench.tasks import Task
from avobench.tasks.warped import Means20
from gaussian import TRUTH, Constant, GaussianMean, gaussian_problem

METHOD = AbcSmc(population_size=40, events_per_theta=16)


def infer(budget: int = 6000, seed: int = 1, method: AbcSmc = METHOD, task: Task | None = None, **of):
    problem = gaussian_problem(task or GaussianMean(), budget, **of)
    return method.infer(problem, np.random.default_rng(seed)), problem


def test_calibration_costs_one_population_and_the_first_generation_accepts_about_half():
    """What `min_simulations` rests on: N evaluations calibrate, 2 N are expected for the first generation."""
    first = [infer(3500, seed=seed)[0].trace[0].simulations / (16 * 40) for seed in range(4)]
    assert min(first) >= 2
    assert np.mean(first) == pytest.approx(3, abs=0.5)
    assert METHOD.min_simulations(1) == 4 * 40 * 16


def test_says_why_when_pyabc_stops_before_the_budget():
    estimate, problem = infer(task=Constant())
    assert "pyABC stopped by itself" in estimate.message
    assert f"{problem.simulate.remaining} events left" in estimate.message
    assert estimate.discarded == 0


def test_says_what_to_do_where_particles_are_too_few_to_be_weighed():
    with pytest.raises(ArithmeticError, match=r"22 particles of 20 parameters .* larger population_size"):
        infer(120_000, method=AbcSmcTuned(population_size=22), task=Means20(), truth=0.0)


@pytest.mark.parametrize("estimate", ["mean", "regression"])
def test_other_estimates_of_the_last_generation_with_more_events_in_each(estimate):
    method = AbcSmc(population_size=20, events_per_theta=16, growth=1.5, estimate=estimate)
    found, problem = infer(method=method)
    assert (found.theta == found.mean).all()
    assert found.theta == pytest.approx(TRUTH, abs=0.3)
    assert found.discarded == problem.simulate.used - found.trace[-1].simulations
    assert found.trace[-1].simulations > 16 * 20 * 2 * len(found.trace)  # more than without growth
