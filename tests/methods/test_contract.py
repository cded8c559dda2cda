"""The seed of global generators."""

import random
import sys

import numpy as np
import torch

from avobench.methods.contract import global_seed


def draws(seed):
    with global_seed(np.random.default_rng(seed)):
        return np.random.random(), random.random(), torch.rand(()).item()


def test_global_generators_are_seeded_inside_and_as_before_outside():
    np.random.seed(5)
    random.seed(5)
    torch.manual_seed(5)
    before = np.random.get_state()[1].tolist(), random.getstate(), torch.get_rng_state().tolist()
    first = draws(1)
    assert (np.random.get_state()[1].tolist(), random.getstate(), torch.get_rng_state().tolist()) == before
    torch.manual_seed(6)
    assert draws(1) == first
    other = draws(2)
    assert all(a != b for a, b in zip(first, other, strict=True))


def test_the_generator_goes_on_alike_whether_pytorch_is_there_or_not(monkeypatch):
    with_torch, without = np.random.default_rng(3), np.random.default_rng(3)
    with global_seed(with_torch):
        monkeypatch.delitem(sys.modules, "torch")
    with global_seed(without):
        pass
    assert with_torch.random() == without.random()
