"""ELFI's synthetic likelihood within a budget."""

import numpy as np
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.methods.bsl import Bsl
from avobench.tasks.errors import UsageError
from gaussian import TRUTH, GaussianMean, gaussian_problem


def infer(truth=TRUTH):
    problem = gaussian_problem(GaussianMean(), 40_000, truth)
    return Bsl(events_per_set=2, chains=2).infer(problem, np.random.default_rng(1)), problem


def test_the_posterior_of_a_mean_is_as_wide_as_the_events_of_a_step_allow():
    """Both the likelihood's covariance and the mean in it are of n = 128 events: 1/N + 2/n, to a fifth by the chain."""
    estimate, problem = infer()
    assert estimate.std == pytest.approx(np.sqrt(1e-4 + 2 / 128), rel=0.3)
    assert estimate.theta == pytest.approx(TRUTH, abs=0.06)  # of some forty independent draws
    assert (estimate.mean == estimate.theta).all()
    assert (estimate.error == estimate.std).all()
    assert problem.simulate.refused == 0
    assert 40_000 - 128 < problem.simulate.used <= 40_000


def test_spends_what_steps_out_of_the_prior_have_left():
    """The truth is at the prior's end: half of the steps lead out of it and are refused unseen."""
    estimate, problem = infer(truth=np.array([3.0]))
    assert problem.prior.contains(estimate.theta).all()
    assert estimate.theta == pytest.approx(3.0, abs=0.3)
    assert problem.simulate.used > 40_000 - 128


def test_more_parameters_than_its_sets_can_tell_apart_are_refused():
    with pytest.raises(UsageError, match=r"bsl\.sets = 4 is too few for the covariance of 3 parameters"):
        Bsl(sets=4).min_simulations(3)
    assert Bsl(sets=5).min_simulations(3) > 0


def test_finds_both_parameters_of_carl_from_its_histograms():
    record = execute(Cell("carl", {}, "bsl", {}, 0, 0, 80_000, 20_000, 3))
    assert record["status"] == "ok", record["message"]
    away = np.abs(np.subtract(record["theta_hat"], record["theta_true"]))
    assert (away < 3 * np.array(record["standard_error"])).all()
    assert (np.array(record["std"]) < 0.5).all()  # the prior's are 1.15
