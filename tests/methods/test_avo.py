"""The preset avo on problems whose best answer is known; see test_polish.py for the polish alone."""

import numpy as np
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.methods.avo import Avo, regression
from avobench.tasks.errors import UsageError
from avobench.tasks.function import task
from gaussian import GaussianMeans, gaussian_problem, posed, problem_at

FEW = {"iterations": 250, "hidden": (32, 32), "statistic_steps": 100}
BRIEF = Avo(iterations=60, hidden=(16,), statistic_steps=200)
TRUTH = np.array([1.0, 12.5])


def test_without_the_polish_it_still_moves_to_the_observed_means():
    given = gaussian_problem(GaussianMeans(), 30_000, TRUTH)
    estimate = Avo(**FEW, polish=False).infer(given, np.random.default_rng(2))
    np.testing.assert_allclose(estimate.theta, given.x_observed.mean(axis=0), atol=0.2)
    assert estimate.how == "mean of the proposal over the last quarter"


def test_the_standard_error_is_near_that_of_all_events_at_the_right_place():
    given = gaussian_problem(GaussianMeans(), 30_000, TRUTH)
    estimate = Avo(**FEW).infer(given, np.random.default_rng(4))
    best, local = np.sqrt(1 / 10_000 + 1 / 30_000), np.sqrt(1 / 10_000 + 1 / 15_000)
    assert (0.95 * best < estimate.error).all()
    assert (estimate.error < 1.1 * local).all()
    assert (np.abs(estimate.theta - given.x_observed.mean(axis=0)) < 4 * np.sqrt(2 / 30_000)).all()
    assert given.simulate.used == 30_000
    assert estimate.how == "mean of the proposal after the polish"
    assert "the polish converged" in estimate.message
    assert estimate.doubt == ""


def test_problems_solved_together_are_solved_as_each_by_itself():
    method = Avo(iterations=30, hidden=(16,), statistic_steps=5)  # each step enlarges what rounding changes

    def given():
        problems = [gaussian_problem(GaussianMeans(), 3000, mean) for mean in (TRUTH, np.array([-1.0, 8.0]))]
        return problems, [np.random.default_rng(i) for i in range(2)]

    for a, b in zip(map(method.infer, *given()), method.infer_together(*given()), strict=True):
        np.testing.assert_allclose(b.theta, a.theta, rtol=1e-4)
        assert [point.simulations for point in b.trace] == [point.simulations for point in a.trace]


def test_estimates_are_those_that_they_were():
    """What this gave when the records of results/reference were made, to the rounding of another machine."""
    given = gaussian_problem(GaussianMeans(), 3000, TRUTH)
    estimate = Avo(iterations=10, hidden=(8,), statistic_steps=20).infer(given, np.random.default_rng(5))
    theta, adversarial = [0.998644292, 12.486653180], [0.248475433, 11.731815335]
    np.testing.assert_allclose(estimate.theta, theta, rtol=1e-4)
    np.testing.assert_allclose(estimate.trace[9].theta, adversarial, rtol=1e-4)


def test_of_many_inputs_each_parameter_has_one_sum():
    """Of 60 inputs each tells a little: all their means at once would move with theta by noise alone."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(4000, 60)).astype(np.float32)
    mix = rng.normal(size=(60, 3))
    np.testing.assert_allclose(regression(x, 2 + x @ mix), mix, atol=1e-4)
    prior, truth = dict.fromkeys("abc", (-1, 1)), np.array([0.3, -0.5, 0.1])
    shared = task(lambda theta, rng: rng.normal(np.repeat(theta, 20, axis=1), 3.5), prior=prior, name="shared")
    estimate = BRIEF.infer(problem_at(shared, truth, 40_000, rng), np.random.default_rng(2))
    assert not estimate.doubt
    assert (estimate.error < 0.02).all()
    np.testing.assert_array_less(np.abs(estimate.theta - truth), 4 * estimate.error)


@pytest.mark.parametrize("num_rare", [20, 60])
def test_inputs_that_are_hardly_ever_hit_do_no_harm(num_rare):
    """Of a pixel that no observed event and one simulated event hits, the variance is not known."""

    def simulate(theta, rng):
        hits = rng.random((len(theta), num_rare)) < np.geomspace(1e-1, 1e-5, num_rare)
        return np.hstack([rng.normal(theta, 1), hits])

    pixels = task(simulate, prior={"mean": (-1, 1)}, name="pixels")
    observed = simulate(np.full((20_000, 1), 0.3), np.random.default_rng(0))
    estimate = BRIEF.infer(posed(pixels, observed, 40_000, 1), np.random.default_rng(2))
    assert not estimate.doubt
    assert abs(estimate.theta[0] - observed[:, 0].mean()) < 4 * estimate.error[0] < 0.05


def test_one_observed_event_is_refused_in_a_line():
    shift = task(lambda theta, rng: rng.normal(theta), prior={"mean": (-3, 3)}, name="shift")
    with pytest.raises(UsageError, match="at least 2 observed events"):
        Avo().infer(posed(shift, np.ones((1, 1)), 5000, 0), np.random.default_rng(0))


def test_heavy_tails_and_a_wide_prior_leave_it_near_the_best_with_errors_that_hold():
    """A Cauchy of a width between 0.01 and 100, of whose events most of those simulated are far off."""

    def simulate(theta, rng):
        return theta[:, 0] + 10 ** theta[:, 1] * rng.standard_cauchy(len(theta))

    cauchy = task(simulate, prior={"centre": (-3, 3), "log_width": (-2, 2)}, name="cauchy")
    truth, budget, num_events = np.array([1.0, -0.5]), 40_000, 10_000
    best = np.sqrt(2 * (1 / num_events + 1 / budget)) * np.array([10 ** truth[1], 1 / np.log(10)])
    pulls = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        estimate = Avo(**FEW).infer(problem_at(cauchy, truth, budget, rng, num_events), rng)
        assert (estimate.error < 3 * best).all()
        assert estimate.doubt == ""
        pulls.append((estimate.theta - truth) / estimate.error)
    assert np.square(pulls).sum() < 22.5  # of six degrees of freedom, exceeded once in a thousand


def test_it_aims_again_while_its_answer_moves_on():
    """A case of the study of growth that is 1 900 floors off after the three rounds of the rule."""
    record = execute(Cell("paper.hard_tasks:GAndK", {}, "avo", {}, 2, 0, 40_000, 100_000, 0))
    assert record["squared_error"] / record["floor"] < 30
    assert record["status"] == "ok"
    assert record["simulations_used"] <= 40_000
    after = [point["simulations"] for point in record["trace"] if point["simulations"] > 0.3 * 40_000]
    assert len(set(after)) > 3


@pytest.mark.parametrize(("refine", "local_share"), [(False, 0.02), (True, 0.02), (True, 0.7)])
def test_it_comes_to_an_end_where_rounds_have_hardly_an_event(refine, local_share):
    """An answer that never rests: the events say nothing of the parameter."""
    still = task(lambda theta, rng: rng.normal(size=len(theta)), prior={"theta": (-1, 1)}, name="still")
    rng = np.random.default_rng(0)
    method = Avo(refine=refine, local_share=local_share, iterations=5, statistic_steps=5)
    problem = posed(still, rng.normal(size=(100, 1)), 400, rng)
    method.infer(problem, rng)
    assert problem.simulate.used <= 400
