"""What one cell does to the process is nothing to the next."""

import os
import random
import warnings

import numpy as np
import pytest
import torch

from avobench.bench.cells.trial import execute
from avobench.bench.sweep.plan import plan

HOW = ["torch", "events", "errors", "warnings", "random", "environment", "folder"]
TIMES = ("started", "versions", "id", "peak_memory_mib")


def cell(method, *settings):
    return plan(["poisson"], [method], "0", 1, 3000, 2000, 0, list(settings))[0]


def state():
    return (
        *(torch.get_default_dtype(), torch.is_grad_enabled(), torch.get_default_device(), torch.get_rng_state().sum()),
        *(np.geterr(), np.random.get_state()[1].tolist(), random.getstate(), len(warnings.filters)),
        *(dict(os.environ), os.getcwd()),
    )


def numbers(record):
    return {name: value for name, value in record.items() if not (name in TIMES or name.endswith("seconds"))}


@pytest.mark.parametrize("how", HOW)
def test_a_cell_after_a_dirty_one_is_as_it_would_be_alone(how):
    alone = numbers(execute(cell("smm")))
    before = state()
    dirty = execute(cell("dirty:Dirty", f"dirty.how={how}"))
    assert state() == before
    assert numbers(execute(cell("smm"))) == alone
    assert (dirty["status"], "changed the observed events" in dirty["message"]) == (
        ("invalid_estimate", True) if how == "events" else ("ok", False)
    )
