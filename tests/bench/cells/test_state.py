"""What one cell does to the process is nothing to the next."""

import os
import random
import warnings
from functools import cache

import numpy as np
import pytest
import torch
from dirty import LOST, WAYS

from avobench.bench.cells.trial import execute
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan

TIMES = ("started", "versions", "id", "peak_memory_mib")


def cell(method, *settings):
    return plan(["poisson"], [method], "0", 1, 3000, 2000, 0, list(settings))[0]


@cache
def alone():
    return numbers(execute(cell("smm")))


def state():
    return (
        *(torch.get_default_dtype(), torch.is_grad_enabled(), torch.get_default_device(), torch.get_rng_state().sum()),
        *(np.geterr(), np.random.get_state()[1].tolist(), random.getstate(), len(warnings.filters)),
        *(dict(os.environ), os.getcwd()),
    )


def numbers(record):
    return {name: value for name, value in record.items() if not (name in TIMES or name.endswith("seconds"))}


@pytest.mark.parametrize("how", WAYS)
def test_a_dirty_cell_costs_itself_at_most_and_leaves_no_trace(how, tmp_path):
    alone()
    before = state()
    dirty = execute(cell("dirty:Dirty", f"dirty.how={how}"))
    assert state() == before
    assert numbers(execute(cell("smm"))) == alone()
    assert (dirty["theta_hat"] is None) == (how in LOST), dirty["message"]
    store = Store(tmp_path / "store", create=True)
    store.write(dirty)
    assert store.read() == ([dirty], {})
