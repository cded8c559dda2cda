"""Records of a small benchmark whose errors are known, as fixtures."""

import numpy as np
import pytest

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import blank_record
from avobench.bench.store.record import identity_hash
from avobench.bench.store.status import Status

SECONDS = {"avo": 20.0, "avo-paper": 30.0, "abc-smc": 1.0, "bolfi": 10.0}


@pytest.fixture(scope="session")
def make_record():
    """A record of a method that lands `offset` away from its target in every parameter, or fails without one.

    Its trace has an estimate ten times farther at half the budget.
    """

    def make(task, method, target, offset, repetition=0, budget=16_000):
        cell = Cell(task, {}, "abc-smc", {}, target, repetition, budget, 2_000, 0)
        record = blank_record(cell, Status.OK if offset is not None else Status.METHOD_ERROR, "")
        true = np.array(record["theta_true"])
        floor = cell.build_task().floor(true, 2_000, budget)
        counts = dict.fromkeys([f"simulations_{what}" for what in ("discarded", "refused")], 0)
        counts |= dict.fromkeys([f"simulations_{what}" for what in ("requested", "used")], budget)
        seconds = {"method_seconds": SECONDS[method] * (1 + target / 10), "simulator_seconds": 1.0}
        id = identity_hash({**cell.identity, "method": method})
        record |= {"method": method, "id": id, "floor": floor, **counts, **seconds}
        if offset is None:
            return record
        theta = (true + offset).tolist()
        trace = [
            {"simulations": n, "theta": (true + far).tolist(), "std": [1.0] * len(true)}
            for n, far in ((budget // 2, 10 * offset), (budget, offset))
        ]
        error = float(((np.array(theta) - true) ** 2).sum())
        known = {"theta_hat": theta, "mean": theta, "std": [1.0] * len(true), "squared_error": error, "trace": trace}
        return record | known | {"how": "", "spread_of": "posterior" if method in ("abc-smc", "bolfi") else "proposal"}

    return make


@pytest.fixture(scope="session")
def benchmark(make_record):
    """Four methods on all tasks: avo nearest, then bolfi, then the others; every second target from below."""
    offsets = {"avo": 1e-3, "avo-paper": 1e-1, "abc-smc": 3e-2, "bolfi": 1e-2}
    return [
        make_record(task, method, target, offset * (-1) ** target)
        for task in ("poisson", "carl", "weinberg", "alignment")
        for method, offset in offsets.items()
        for target in range(6)
    ]
