"""A simulator that fails somewhere is kept to where it works, every call is counted, and what failed is told."""

from functools import partial

import numpy as np
import pytest

import avobench
from avobench.api.inference import restricted
from avobench.bench.cells.budget import MeteredSimulator
from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.methods import Estimate, WeightedSample
from avobench.tasks.errors import BudgetExhausted, SimulatorError, UsageError

PRIOR = {"mean": (-2, 3), "width": (0.5, 3)}
calls = 0


def normal(theta, rng):
    """It fails where mean + width > 3, and for one event in twenty wherever it is."""
    global calls
    calls += len(theta)
    x = rng.normal(theta[:, 0], theta[:, 1])
    x[(theta.sum(axis=1) > 3) | (rng.random(len(x)) < 0.05)] = np.nan
    return x


def raising(theta, rng):
    global calls
    calls += len(theta)
    if (theta.sum(axis=1) > 3).any():
        raise ArithmeticError("no solution")
    return rng.poisson(np.column_stack([np.exp(theta[:, 0]), 10 * theta[:, 1]]))


def program(theta, n, rng):
    if theta.sum() > 3:
        raise TimeoutError
    return rng.normal(theta[0], theta[1], n)


@pytest.mark.parametrize(("function", "per_theta"), [(normal, False), (raising, False), (program, True)])
def test_its_region_is_learnt_and_events_are_made_within(function, per_theta):
    task = avobench.task(function, prior=PRIOR, failed="region", per_theta=per_theta)
    rng = np.random.default_rng(1)
    theta = task.prior.sample(5000, rng)
    x = task.simulate(theta, rng)
    assert np.isfinite(x).all()
    assert x.dtype == (np.int64 if function is raising else np.float64)
    assert (task.region.contains(theta) == (theta.sum(axis=1) < 3)).mean() > 0.97
    within = task.region.within(theta)
    assert (within.sum(axis=1) < 3).mean() > 0.99
    np.testing.assert_array_equal(within[task.region.contains(theta)], theta[task.region.contains(theta)])


@pytest.mark.parametrize("function", [normal, raising])
def test_a_fit_finds_what_is_near_the_edge_and_tells_every_call(function):
    global calls
    task, rng = avobench.task(function, prior=PRIOR, failed="region"), np.random.default_rng(2)
    x = rng.normal(1.2, 1.2, 3000) if function is normal else rng.poisson([np.exp(1.2), 12], (3000, 2))
    calls = 0
    found = avobench.infer(task, x, "smm", budget=60_000, progress=False)
    assert found.num_simulations == calls
    assert abs(found.theta["mean"] - 1.2) < 4 * found.std["mean"] < 0.2
    assert not found.estimate.doubt
    assert any("6" in note and "% of the prior" in note for note in found.warnings)  # mean + width < 3 in 64 %


@pytest.mark.parametrize(("function", "method"), [(normal, "smm"), (raising, "abc-smc")])
def test_what_failed_counts_within_the_limit(function, method):
    global calls
    budget, rng = 30_000, np.random.default_rng(5)  # of 20 000, smm refuses one data set in two
    task = avobench.task(function, prior=PRIOR, failed="region")
    x = rng.normal(0, 1.2, 1000) if function is normal else rng.poisson([1.0, 12], (1000, 2))
    learnt, calls = task.region.beside, 0
    settings = {"population_size": 20} if method == "abc-smc" else None
    told = [avobench.infer(task, x, method, budget=budget, settings=settings, progress=False) for _ in range(2)]
    assert told[0].theta == told[1].theta
    assert sum(fit.num_simulations for fit in told) == calls
    assert told[0].num_simulations <= budget < learnt + budget


def test_a_metered_simulator_refuses_what_failures_would_take_beyond_its_budget():
    global calls
    task = avobench.task(normal, prior=PRIOR, failed="region")
    task.region, calls = task.region, 0
    simulate = MeteredSimulator(task, 1000, np.random.default_rng(6))
    with pytest.raises(BudgetExhausted):
        simulate(np.tile([0.0, 1.0], (999, 1)))
    assert 999 <= simulate.used == calls <= 1000
    simulate = MeteredSimulator(task, 1100, np.random.default_rng(6))
    assert np.isfinite(simulate(np.tile([0.0, 1.0], (1000, 1)))).all()
    assert simulate.used == 1000 + simulate.failed > 1030


def test_a_posterior_ends_at_the_edge():
    task = avobench.task(normal, prior=PRIOR, failed="region")
    points, one = task.prior.sample(2000, np.random.default_rng(3)), np.ones(2)
    sample = WeightedSample.equal(points)
    kept = restricted(Estimate(3 * one, "", "posterior", one, one, [], sample=sample), task)
    inside = points[task.region.contains(points)]
    np.testing.assert_allclose(kept.mean, inside.mean(axis=0))
    np.testing.assert_allclose(kept.std, inside.std(axis=0))
    assert task.region.contains(kept.theta[None]).all()


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_bank_remembers_where_it_works(tmp_path, jobs):
    x, told = np.random.default_rng(4).normal(0, 1, 300), []
    for _ in range(2):
        task = avobench.task(normal, prior=PRIOR, failed="region")
        told.append(avobench.diagnose(task, x, effects=["offset"], bank=tmp_path, jobs=jobs, progress=False).diagnosis)
    assert told[1].num_simulations == 0
    assert told[0].theta_before == told[1].theta_before
    assert sum("failed at" in note for note in told[1].notes) == 1
    (tmp_path / "worked.json").write_text('[{"reason": "", "worked": [true]}]')
    with pytest.raises(UsageError, match=r"worked\.json"):
        avobench.diagnose(avobench.task(normal, prior=PRIOR, failed="region"), x, bank=tmp_path, progress=False)


def test_one_that_hardly_works_is_no_simulator():
    prior, support = {"a": (-3, 2), "b": (0.5, 1)}, {"a": (-3, 60), "b": (0.5, 60)}
    task = avobench.task(program, prior=prior, support=support, failed="region", per_theta=True)
    with pytest.raises(SimulatorError, match=r"failed at 5.. of 512 thetas.*TimeoutError"):
        task.simulate(np.array([[1.0, 0.6]]), np.random.default_rng(0))


@pytest.mark.parametrize("error", [KeyError("boom"), SystemExit(1), AttributeError("none")])
def test_a_fault_of_the_code_is_no_failure_and_is_said_in_a_line(error):
    def faulty(theta, rng):
        if (theta[:, 0] > 2.5).any():
            raise error
        return normal(theta, rng)

    task = avobench.task(faulty, prior=PRIOR, failed="region")
    with pytest.raises(SimulatorError, match=f"the simulator of faulty raised {type(error).__name__}"):
        avobench.infer(task, np.zeros(300), "smm", budget=20_000, progress=False)


@pytest.mark.parametrize(("share", "budget"), [(0.001, 160_000), (0.01, 20_000), (0.3, 5000)])
def test_failures_at_random_leave_a_method_the_events_that_it_plans_with(share, budget):
    """The answer to 1000 exponential events is their mean, but for the error that simulation adds."""
    made = 0

    def decay(theta, rng):
        nonlocal made
        made += len(theta)
        return np.where(rng.random(len(theta)) < share, np.nan, rng.exponential(theta[:, 0]))

    task = avobench.task(decay, prior={"tau": (1, 4)}, failed="region")
    x = np.random.default_rng(1).exponential(2, 1000)
    learnt, made = task.region.beside, 0
    fit = avobench.infer(task, x, "rank-moments", budget=budget, progress=False)
    assert 0.8 * budget < made == fit.num_simulations <= budget
    assert learnt == 512
    assert abs(fit.theta["tau"] - x.mean()) < 0.8 * fit.std["tau"] < 0.1


NORMAL = avobench.task(normal, prior=PRIOR, failed="region")


def test_a_cell_of_a_sweep_leaves_room_for_failures_too():
    record = execute(Cell(f"{__file__}:NORMAL", {}, "rank-moments", {}, 0, 0, 4000, 200, 0))
    assert record["status"] == "ok"
    assert 3000 < record["simulations_used"] <= 4000


def test_too_small_a_budget_for_what_fails_names_one_that_suffices():
    task = avobench.task(normal, prior=PRIOR, failed="region")
    x = np.random.default_rng(2).normal(0, 1, 200)
    infer = partial(avobench.infer, task, x, "rank-moments", progress=False)
    with pytest.raises(UsageError, match=r"allow \d+$") as refused:
        infer(budget=500)
    assert infer(budget=int(str(refused.value).split()[-1])).num_simulations > 480
