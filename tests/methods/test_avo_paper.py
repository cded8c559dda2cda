"""Algorithm 1: gradients against closed forms, events against the schedules, and convergence on an easy problem."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import execute
from avobench.bench.store.status import reason
from avobench.methods.avo_paper import (
    AvoPaper,
    baseline,
    entropy_gradient,
    initial_state,
    score_gradient,
    update_discriminator,
)
from avobench.methods.discriminator import Discriminator, cross_entropy, input_gradient_penalty
from avobench.methods.proposal import TruncatedGaussian
from avobench.tasks import Box
from gaussian import GaussianMean, gaussian_problem


class GaussianShifts(GaussianMean):
    """Two means, of which the support holds far more than the prior."""

    parameter_names, parameter_units, num_features = ("a", "b"), ("1", "1"), 2
    prior, support = Box((-2, -2), (2, 2)), Box((-9, -9), (9, 9))


THETA = np.array([0.8, -0.5])
PROPOSAL = TruncatedGaussian(GaussianShifts.prior, GaussianShifts.support)


def problem(budget, num_observations=10_000):
    given = gaussian_problem(GaussianShifts(), budget, THETA)
    return replace(given, x_observed=given.x_observed[:num_observations])


FAST = {"hidden": (16, 16), "learning_rate": 3e-3, "proposal_learning_rate": 3e-3}


def test_proposal_moves_to_the_true_parameters():
    estimate = AvoPaper(**FAST, r1=1.0).infer(problem(64_000), np.random.default_rng(1))
    start, end = estimate.trace[0], estimate.trace[-1]
    assert np.linalg.norm(end.theta - THETA) < 0.2 * np.linalg.norm(start.theta - THETA)
    assert (end.std < start.std).all()
    np.testing.assert_array_equal(end.theta, estimate.theta)


@pytest.mark.parametrize(
    ("schedule", "steps", "batch", "per_iteration"),
    [("as_printed", 1, 32, 48), ("as_printed", 3, 16, 40), ("shared", 1, 32, 32), ("shared", 4, 32, 32)],
)
def test_every_simulated_event_is_counted_once(schedule, steps, batch, per_iteration):
    method = AvoPaper(hidden=(4,), schedule=schedule, discriminator_steps=steps, batch_size=batch)
    given = problem(1000, num_observations=200)
    estimate = method.infer(given, np.random.default_rng(0))
    assert method.min_simulations(2) == per_iteration
    assert given.simulate.used == 1000 // per_iteration * per_iteration
    assert given.simulate.refused == 0
    assert f"{1000 // per_iteration} iterations" in estimate.message
    assert estimate.trace[-1].simulations == given.simulate.used


def test_optimal_baseline_has_the_least_variance():
    rng, psi = np.random.default_rng(0), np.array([[0.3, 0.0], [-0.5, 0.2]])
    u = PROPOSAL.sample(psi, 200_000, rng)
    f = -3 + (u @ [1.0, -0.5]) + 0.3 * rng.normal(size=len(u))
    score = PROPOSAL.score(psi, u)
    best, *others = (baseline(kind, score, f) for kind in ("optimal", "as_printed", "none"))
    least = (score * (f[:, None, None] - best)).var(axis=0)
    for other in (*others, best - 0.1, best + 0.1):  # a stationary point, component by component
        assert ((score * (f[:, None, None] - other)).var(axis=0) > least).all()
    # f^2 is positive while f = log(1 - d) is negative: the printed baseline has the wrong sign
    assert (baseline("as_printed", score, f) > 0).all()
    assert (best < 0).all()


def test_score_gradient_is_the_gradient_of_the_expected_value():
    """For f(u) = u the expectation over a wide Gaussian is its mean, so the gradient in the mean is 1."""
    psi = np.array([[0.4, -0.2], [-1.0, -1.0]])
    u = PROPOSAL.sample(psi, 400_000, np.random.default_rng(0))
    gradient = score_gradient(PROPOSAL.score(psi, u), u[:, 0], "optimal")
    np.testing.assert_allclose(gradient, [[1, 0], [0, 0]], atol=0.02)


def test_entropy_grows_with_the_width_of_the_proposal():
    psi = np.zeros((2, 2))
    u = PROPOSAL.sample(psi, 1000, np.random.default_rng(0))
    gradient, as_printed = (entropy_gradient(PROPOSAL, psi, u, kind) for kind in ("closed_form", "as_printed"))
    np.testing.assert_allclose(gradient, [[0, 0], [1, 1]], atol=2e-3)  # H = log std of a Gaussian, and a constant
    assert not np.allclose(as_printed, gradient, atol=0.1)


def test_an_entropy_penalty_makes_the_proposal_tighter():
    loose, tight = (
        AvoPaper(**FAST, entropy=entropy).infer(problem(4800, num_observations=200), np.random.default_rng(1)).std
        for entropy in (0.0, 0.5)
    )
    assert (tight < 0.9 * loose).all()


@pytest.mark.parametrize("r1_of", ["probability", "logit"])
def test_r1_is_the_mean_squared_input_gradient(r1_of):
    """For a logit linear in x the penalty is |w|^2, times (d (1 - d))^2 where the gradient is that of d."""
    discriminator = Discriminator(problem(10, num_observations=500), (), np.random.default_rng(0))
    weight = discriminator.network[-2].weight[0]
    real = discriminator.inputs(problem(10).x_observed[:64]).requires_grad_()
    logit = discriminator.network(real)
    d = torch.sigmoid(logit)
    factor = (d * (1 - d)) ** 2 if r1_of == "probability" else torch.ones_like(d)
    expected = (factor * weight.square().sum()).mean().item()
    assert input_gradient_penalty(logit, real, r1_of).item() == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("r1", "gradient_is_smaller"), [(0.0, False), (1000.0, True)])
def test_an_update_of_the_discriminator_goes_down_the_penalised_loss(r1, gradient_is_smaller):
    given = problem(10, num_observations=500)
    settings = AvoPaper(hidden=(8,), r1=r1, learning_rate=1e-2)
    state = initial_state(given, settings, np.random.default_rng(0))
    x_real, x_synthetic = given.x_observed[:64], given.x_observed[64:128] + 2

    def loss_and_penalty():
        real = state.discriminator.inputs(x_real).requires_grad_()
        logits = state.discriminator.network(real), state.discriminator.network(state.discriminator.inputs(x_synthetic))
        penalty = input_gradient_penalty(logits[0], real, settings.r1_of).item()
        return cross_entropy(*logits).item() + r1 * penalty, penalty

    before = loss_and_penalty()
    for _ in range(10):
        update_discriminator(state, x_real, x_synthetic, settings)
    after = loss_and_penalty()
    assert after[0] < before[0]
    assert (after[1] < before[1]) == gradient_is_smaller


@pytest.mark.parametrize(("logit", "holds"), [(0.0, True), (-120.0, False), (120.0, False)])
def test_r1_of_d_does_not_hold_a_discriminator_that_saturates(logit, holds):
    """And below, where log(1 - d) is 0 on every event, the proposal has no gradient; R1 of the logit holds anywhere."""
    given, settings = problem(10, num_observations=500), AvoPaper(hidden=(8,))
    state = initial_state(given, settings, np.random.default_rng(0))
    torch.nn.init.constant_(state.discriminator.network[-2].bias, logit)
    real = state.discriminator.inputs(given.x_observed[:64]).requires_grad_()

    def pull(r1_of):
        penalty = input_gradient_penalty(state.discriminator.network(real), real, r1_of)
        return torch.autograd.grad(penalty, state.discriminator.network[0].weight)[0].abs().max().item()

    assert (pull("probability") > 0) == holds
    assert pull("logit") > 0
    psi = state.psi.numpy()
    u = PROPOSAL.sample(psi, 64, np.random.default_rng(0))
    f = state.discriminator.log_one_minus_d(given.x_observed[:64])
    assert score_gradient(PROPOSAL.score(psi, u), f, settings.baseline).any() == (logit > -120)


def test_a_device_out_of_memory_fails_its_cell_in_a_line(monkeypatch):
    def out_of_memory(*arguments):
        raise torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 20.00 MiB.\nGPU 0 has 79 GiB")

    monkeypatch.setattr("avobench.methods.discriminator.cross_entropy", out_of_memory)
    record = execute(Cell("poisson", {}, "avo-paper", {"hidden": [4]}, 0, 0, 96, 100, 0))
    told = "method_error: CUDA out of memory. Tried to allocate 20.00 MiB. GPU 0 has 79 GiB; fewer"
    assert reason(record).startswith(told)
    assert "\n" not in reason(record)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")
def test_a_gpu_gives_the_estimate_of_the_cpu_to_rounding():
    near, far = (
        AvoPaper(**FAST, device=device).infer(problem(4800), np.random.default_rng(1)) for device in ("cpu", "cuda")
    )
    assert far.theta == pytest.approx(near.theta, abs=1e-2)


def test_estimates_are_those_that_they_were():
    """What this gave when the records of results/reference were made, to the rounding of another machine."""
    estimate = AvoPaper(**FAST).infer(problem(480), np.random.default_rng(1))
    theta, std = [0.160363986, -0.129705232], [1.151148804, 1.088380181]
    np.testing.assert_allclose(estimate.theta, theta, rtol=1e-4)
    np.testing.assert_allclose(estimate.std, std, rtol=1e-4)
