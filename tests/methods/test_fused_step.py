"""The update by hand is that of PyTorch's derivatives and Adam, for any networks, batch and penalty."""

import copy

import numpy as np
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from avobench.methods.discriminator import mlp
from avobench.methods.fused_step import FusedStep
from paper.speed.avo import AutogradStep

SLOPES = (0.25, -0.5, 1.0, 2.0)
"""Of PReLU: a slope of 1 is no special case, nor is a negative one."""


def stack(count, features, hidden, seed):
    """Networks in double precision."""
    rng = np.random.default_rng(seed)
    networks = [mlp(features, tuple(hidden), rng).double() for _ in range(count)]
    with torch.no_grad():
        for network in networks:
            for i, layer in enumerate(network):
                if isinstance(layer, torch.nn.PReLU):
                    layer.weight.fill_(SLOPES[i // 2])
    return networks


def batches(count, features, sizes, rng):
    return [torch.from_numpy(rng.normal(size=(count, size, features))) for size in sizes]


@settings(max_examples=25)
@given(
    count=st.integers(1, 4),
    hidden=st.lists(st.integers(1, 7), min_size=1, max_size=4),
    sizes=st.tuples(st.integers(1, 5), st.integers(1, 9), st.integers(1, 9)),
    r1=st.sampled_from([0.0, 0.5, 10.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_an_update_is_that_of_autograd_for_each_network_alone(count, hidden, sizes, r1, seed):
    features, n, m = sizes
    alone = stack(count, features, hidden, seed)
    stacked = copy.deepcopy(alone)
    plain, by_hand = AutogradStep(alone, 1e-3, r1), FusedStep(stacked, 1e-3, r1)
    rng = np.random.default_rng(seed)
    for both in ((n, m), (n, m), (m, n)):  # the last batch is of another size
        real, synthetic = batches(count, features, both, rng)
        plain(real, synthetic)
        by_hand(real, synthetic)
    for a, b in zip(alone, stacked, strict=True):
        for p, q in zip(a.parameters(), b.parameters(), strict=True):
            torch.testing.assert_close(q, p, rtol=1e-6, atol=1e-7)
    with torch.no_grad():
        expected = torch.stack([network(x) for network, x in zip(alone, real, strict=True)])
    torch.testing.assert_close(by_hand.logits(real), expected, rtol=1e-6, atol=1e-7)


def test_many_updates_in_single_precision_stay_with_autograd():
    rng = np.random.default_rng(0)
    alone = [mlp(2, (40, 40), np.random.default_rng(seed)) for seed in range(2)]
    stacked = copy.deepcopy(alone)
    plain, by_hand = AutogradStep(alone, 1e-4, 10.0), FusedStep(stacked, 1e-4, 10.0)
    start = by_hand.flat.clone()
    for _ in range(50):
        real, synthetic = (x.float() for x in batches(2, 2, (16, 16), rng))
        plain(real, synthetic + 0.5)
        by_hand(real, synthetic + 0.5)
    assert (by_hand.flat - start).abs().max() > 1e-3
    x = torch.randn(2, 200, 2)
    with torch.no_grad():
        expected = torch.stack([network(events) for network, events in zip(alone, x, strict=True)])
    torch.testing.assert_close(by_hand.logits(x), expected, rtol=0, atol=2e-4)
