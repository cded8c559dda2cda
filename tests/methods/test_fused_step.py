"""The fused step is one step of autograd and RMSProp, for any network, batch and penalty."""

import copy

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.methods.discriminator import Discriminator, mlp, penalised_cross_entropy
from avobench.methods.fused_step import FusedStep

settings.register_profile("fused", deadline=None, max_examples=25)


class Given:
    """What a Discriminator needs of a problem."""

    def __init__(self, x):
        self.x_observed, self.discriminator = x, type("Network", (), {"standardise": False})


def twins(hidden, features, seed, r1, r1_of, rate=1e-3):
    """Two equal networks in double precision, the step of one by autograd and of the other fused."""
    rng = np.random.default_rng(seed)
    plain = Discriminator(Given(rng.normal(size=(4, features))), hidden, rng)
    plain.network.double()
    fused = copy.deepcopy(plain)
    optimiser = torch.optim.RMSprop(plain.parameters(), lr=rate)
    plain.inputs = torch.from_numpy  # in double precision

    def step(real, synthetic):
        optimiser.zero_grad()
        plain.loss(real, synthetic, r1, r1_of).backward()
        optimiser.step()

    quick = FusedStep([fused.network], rate, r1, r1_of)
    return (
        plain,
        step,
        fused,
        lambda real, synthetic: quick(torch.from_numpy(real)[None], torch.from_numpy(synthetic)[None]),
    )


@settings(settings.get_profile("fused"))
@given(
    hidden=st.lists(st.integers(1, 7), min_size=1, max_size=4),
    sizes=st.tuples(st.integers(1, 5), st.integers(1, 9), st.integers(1, 9)),
    r1=st.sampled_from([0.0, 0.5, 10.0]),
    r1_of=st.sampled_from(["probability", "logit"]),
    seed=st.integers(0, 2**32 - 1),
)
def test_gradients_are_those_of_autograd(hidden, sizes, r1, r1_of, seed):
    features, n, m = sizes
    rng = np.random.default_rng(seed)
    plain, step, fused, quick = twins(tuple(hidden), features, seed, r1, r1_of)
    with torch.no_grad():
        for network in (plain.network, fused.network):
            for i, layer in enumerate(network):
                if isinstance(layer, torch.nn.PReLU):
                    layer.weight.fill_([0.25, -0.5, 1.0, 2.0][i // 2])  # a slope of 1 is no special case
    for n_now, m_now in ((n, m), (m, n)):  # a second batch of another size
        real, synthetic = rng.normal(size=(n_now, features)), rng.normal(size=(m_now, features))
        step(real, synthetic)
        quick(real, synthetic)
        for p, q in zip(plain.parameters(), fused.parameters(), strict=True):
            torch.testing.assert_close(q, p, rtol=1e-7, atol=1e-7)


def test_many_steps_in_single_precision_stay_with_autograd():
    rng = np.random.default_rng(0)
    plain, fused = (Discriminator(Given(np.zeros((4, 2))), (40, 40), np.random.default_rng(1)) for _ in range(2))
    optimiser, quick = torch.optim.RMSprop(plain.parameters(), lr=1e-4), FusedStep([fused.network], 1e-4, 10.0, "logit")
    for _ in range(50):
        real, synthetic = rng.normal(size=(16, 2)), rng.normal(0.5, 1, size=(16, 2))
        optimiser.zero_grad()
        plain.loss(real, synthetic, 10.0, "logit").backward()
        optimiser.step()
        quick(fused.inputs(real)[None], fused.inputs(synthetic)[None])
    x = rng.normal(size=(200, 2))
    assert fused.log_one_minus_d(x) == pytest.approx(plain.log_one_minus_d(x), abs=2e-4)


@settings(settings.get_profile("fused"))
@given(
    count=st.integers(1, 4),
    hidden=st.lists(st.integers(1, 6), min_size=1, max_size=3),
    r1=st.sampled_from([0.0, 1.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_networks_in_a_stack_are_trained_as_each_by_itself_with_adam(count, hidden, r1, seed):
    rng = np.random.default_rng(seed)
    alone = [mlp(2, tuple(hidden), rng).double() for _ in range(count)]
    stacked = copy.deepcopy(alone)
    optimisers = [torch.optim.Adam(network.parameters(), lr=1e-3, betas=(0.5, 0.99)) for network in alone]
    quick = FusedStep(stacked, 1e-3, r1, "probability", "adam")
    for _ in range(4):
        real, synthetic = (
            torch.from_numpy(rng.normal(size=(count, 5, 2))),
            torch.from_numpy(rng.normal(size=(count, 7, 2))),
        )
        quick(real, synthetic)
        for network, optimiser, *x in zip(alone, optimisers, real.clone(), synthetic, strict=True):
            optimiser.zero_grad()
            penalised_cross_entropy(network, *x, r1, "probability").backward()
            optimiser.step()
    for a, b in zip(alone, stacked, strict=True):
        for p, q in zip(a.parameters(), b.parameters(), strict=True):
            torch.testing.assert_close(q, p, rtol=1e-6, atol=1e-7)
    with torch.no_grad():
        expected = torch.stack([network(x) for network, x in zip(alone, synthetic, strict=True)])
    torch.testing.assert_close(quick.logits(synthetic), expected, rtol=1e-6, atol=1e-7)
