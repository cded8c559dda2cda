import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from scipy.stats import uniform

from avobench.methods.gaussian_process import GaussianProcess
from avobench.methods.lower_confidence_bound import BatchedLCBSC, minimise


class UnitBox:
    """A prior as ELFI's acquisitions use it."""

    def __init__(self, dim: int) -> None:
        self.dim = dim

    def rvs(self, size, random_state):
        return uniform.rvs(size=(size, self.dim), random_state=random_state)


def acquisition(p: int, seed: int, noise_var: float | None = None) -> BatchedLCBSC:
    rng = np.random.default_rng(seed)
    x = rng.uniform(size=(30, p))
    process = GaussianProcess(["a", "b", "c"][:p], [(0.0, 1.0)] * p)
    process.update(x, np.sqrt(((x - 0.3) ** 2).sum(1)) + rng.normal(0.1, 0.01, 30) ** 2, optimize=True)
    return BatchedLCBSC(process, prior=UnitBox(p), noise_var=noise_var, seed=seed)


@settings(max_examples=50, deadline=None)
@given(p=st.integers(1, 4), seed=st.integers(0, 2**32 - 1))
def test_finds_the_least_squares_in_a_box(p, seed):
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(p + 2, p)), rng.normal(size=p + 2)
    low, high = -rng.uniform(size=p), rng.uniform(size=p)

    def function(x):
        residual = x @ a.T - b
        return (residual**2).sum(1) / 2, residual @ a, np.broadcast_to(a.T @ a, (len(x), p, p))

    x, values = minimise(function, rng.uniform(low, high, (5, p)), low, high, 1000)
    best = lsq_linear(a, b, (low, high), tol=1e-12)
    assert values == pytest.approx(np.full(5, best.cost), rel=1e-6, abs=1e-9)
    assert ((x >= low) & (x <= high)).all()


def test_each_start_goes_to_its_own_minimum():
    def function(x):
        return np.cos(x[:, 0]), -np.sin(x), -np.cos(x)[:, :, None]

    x, values = minimise(function, np.array([[2.5], [9.0], [6.0]]), np.array([0.0]), np.array([10.0]), 100)
    assert x[:2, 0] == pytest.approx([np.pi, 3 * np.pi], abs=1e-6)
    assert values == pytest.approx(-1)


@pytest.mark.parametrize("p", [1, 2, 3])
def test_the_bound_and_its_derivatives_are_elfis(p):
    of, x = acquisition(p, 0), np.random.default_rng(1).uniform(size=(7, p))
    value, gradient, hessian = of._bound(x, np.sqrt(of._beta(5)))
    assert value == pytest.approx(of.evaluate(x, 5)[:, 0])
    assert gradient == pytest.approx(of.evaluate_gradient(x, 5), rel=1e-6)
    shifts = 1e-5 * np.eye(p)
    found = [(of.evaluate_gradient(x + s, 5) - of.evaluate_gradient(x - s, 5)) / 2e-5 for s in shifts]
    assert hessian == pytest.approx(np.stack(found, axis=-1), rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("p", [1, 2])
def test_acquires_what_elfi_acquires_or_better(p):
    for seed in range(10):
        ours, stock = acquisition(p, seed), acquisition(p, seed)
        theirs = super(BatchedLCBSC, stock).acquire(2, t=3)
        x = ours.acquire(2, t=3)
        assert x.shape == (2, p)
        assert ours.evaluate(x, 3)[0] <= ours.evaluate(theirs, 3)[0] + 1e-6
        assert (ours.random_state.uniform(size=3) == stock.random_state.uniform(size=3)).all()


def test_noise_stays_in_the_box():
    x = acquisition(2, 0, noise_var=1.0).acquire(50, t=0)
    assert ((x >= 0) & (x <= 1)).all()
    assert x.std(axis=0) == pytest.approx(0.29, abs=0.1)  # a broad Gaussian cut to the box is nearly uniform
