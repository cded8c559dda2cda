"""What every method keeps of its contract, on means of Gaussians, whose posterior is known."""

import logging
import random
import warnings
from functools import cache

import numpy as np
import pytest
import torch

from avobench.methods.abc_smc import AbcSmc
from avobench.methods.avo import Avo
from avobench.methods.avo_paper import AvoPaper
from avobench.methods.bolfi import Bolfi
from avobench.methods.bsl import Bsl
from avobench.methods.nle import Nle
from avobench.methods.npe import Npe, Tsnpe
from avobench.methods.nre import Nre
from avobench.methods.rank_moments import RankMoments
from avobench.methods.smm import Smm
from avobench.tasks.errors import BudgetExhausted, SimulatorError, UsageError
from gaussian import Failing, GaussianMean, GaussianMeans, gaussian_problem

METHODS = [
    Avo(iterations=20, hidden=(8,), statistic_steps=20),
    AvoPaper(hidden=(4,)),
    AbcSmc(population_size=40, events_per_theta=16),
    Bolfi(events_per_theta=16, num_trace_points=3, num_posterior_points=512),
    Bsl(events_per_set=2, chains=2),
    Smm(),
    RankMoments(),
    Nle(steps=30),
    Nre(steps=30, hidden=10),
    Npe(steps=30, events_per_set=16),
    Tsnpe(steps=20, rounds=2, events_per_set=16),
]
BUDGET = {"bolfi": 400, "avo-paper": 2000, "nle": 1000, "nre": 1000, "npe": 1500, "tsnpe": 1500}
"""Where 5000 events would take long; the networks also have fewer observed ones."""
every_method = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)


def infer(method, seed=1, budget=None, task=None, **truth):
    observed = 500 if isinstance(method, Nle | Nre | Npe) else 10_000
    budget = budget or BUDGET.get(method.name, 5000)
    problem = gaussian_problem(task or GaussianMean(), budget, num_observed=observed, **truth)
    return method.infer(problem, np.random.default_rng(seed)), problem


@cache
def once(name):
    """An estimate of the method of this name, and the problem that it had, which two tests look at."""
    return infer(next(method for method in METHODS if method.name == name))


def state():
    """What a method may not leave changed."""
    import elfi

    generators = np.random.get_state()[1].tolist(), random.getstate(), torch.get_rng_state().tolist()
    elsewhere = elfi.get_client(), elfi.get_default_model(), list(elfi.get_default_model().nodes)
    return generators, elsewhere, list(warnings.filters), logging.getLogger("ABC").level


@every_method
def test_the_seed_alone_decides_and_no_state_is_left(method, tmp_path, monkeypatch, capfd):
    first, _ = once(method.name)
    monkeypatch.chdir(tmp_path)
    np.random.seed(2)
    torch.manual_seed(2)
    before = state()
    capfd.readouterr()
    second, _ = infer(method)
    assert state() == before
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())
    assert first.theta.tolist() == second.theta.tolist()
    assert first.std.tolist() == second.std.tolist()
    assert [point.simulations for point in first.trace] == [point.simulations for point in second.trace]
    assert infer(method, seed=3)[0].mean.tolist() != first.mean.tolist()


@every_method
def test_the_trace_counts_events_within_the_budget_and_ends_at_the_estimate(method):
    estimate, problem = once(method.name)
    simulations = [point.simulations for point in estimate.trace]
    assert simulations == sorted(simulations)
    assert simulations[-1] + estimate.discarded == problem.simulate.used <= problem.simulate.budget
    assert estimate.trace[-1].theta.tolist() == estimate.theta.tolist()
    assert all(problem.support.contains(point.theta).all() for point in estimate.trace)


@every_method
def test_a_budget_below_the_least_is_exhausted_and_the_least_is_enough(method):
    least = method.min_simulations(1)
    assert np.isfinite(infer(method, budget=least)[0].theta).all()
    with pytest.raises(BudgetExhausted):
        infer(method, budget=least // 3)


@every_method
def test_an_error_of_the_simulator_propagates(method):
    with pytest.raises(SimulatorError, match="the detector is off"):
        infer(method, task=Failing())


IN_OWN_UNITS = Bolfi(events_per_theta=16, num_trace_points=2, unit_box=False)


@pytest.mark.parametrize("method", [METHODS[0], *METHODS[2:7], IN_OWN_UNITS], ids=lambda method: method.name)
def test_parameters_keep_their_order(method):
    truth = np.array([-1.5, 12.0])
    estimate, _ = infer(method, task=GaussianMeans(), budget=600 if method.name == "bolfi" else 20_000, truth=truth)
    assert estimate.theta == pytest.approx(truth, abs=0.7)
    assert estimate.mean.shape == estimate.std.shape == (2,)


WRONG = {
    Avo: [
        *({"iterations": 0}, {"hidden": ()}, {"learning_rate": (1e-3, 0.0)}, {"max_std": 2.0}, {"min_std": 0.0}),
        *({"r1": -1.0}, {"local_share": 1.0}, {"replay": 1}, {"entropy": -1.0}),
        {"matched": "divergence", "cross_fit": False},
    ],
    AvoPaper: [
        *({"batch_size": 31}, {"batch_size": 0}, {"discriminator_steps": 0}, {"learning_rate": 0.0}, {"r1": -1.0})
    ],
    AbcSmc: [{"population_size": 1}, {"events_per_theta": 0}, {"growth": 0.5}, {"estimate": "median"}],
    Bolfi: [
        *({"events_per_theta": 0}, {"initial_evidence": 0}, {"update_interval": 0}, {"num_trace_points": 0}),
        *({"surrogate": "exact"}, {"exploration_rate": 0.0}, {"acq_noise_var": -1.0}, {"num_posterior_points": 1000}),
    ],
    Bsl: [{"sets": 0}, {"events_per_set": 0}, {"chains": 0}, {"growth": 0.5}, {"nearest": 0.0}, {"nearest": 1.5}],
    Smm: [{"rounds": 0}, {"shrink": 0.0}, {"shrink": 1.5}, {"errors": 0.0}, {"trim": 0.5}],
    RankMoments: [{"rounds": 0}, {"degree": 0}, {"shrink": 0.0}, {"shrink": 1.5}, {"errors": 0.0}],
    Nre: [{"rounds": 0}, {"learning_rate": 0.0}, {"amortised": True, "rounds": 2}],
}


@pytest.mark.parametrize(("method", "wrong"), [(method, wrong) for method, each in WRONG.items() for wrong in each])
def test_settings_that_make_no_sense_are_refused(method, wrong):
    with pytest.raises((UsageError, ValueError), match=r"must|need|amortised|cross_fit"):
        method(**wrong)
