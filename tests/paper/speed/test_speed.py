"""The cost table adds up, and the benchmark of growth measures what it says."""

import pytest

from avobench.bench.processes.local import LocalBackend
from avobench.bench.store.status import Status
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import View, run
from paper.speed import growth
from paper.speed.cost import PARTS, cost_table, harness_share


def test_the_parts_of_a_sweep_add_up_to_its_time(tmp_path, beside_users_modules):
    cells = plan(["toys:Normal"], ["toys:Moment"], "0-3", 1, 400, 100, 0, ["moment.pause=0.05"])
    store = Store(tmp_path, create=True)
    records = run(cells, store, LocalBackend(1, store.running), View())
    assert {record["status"] for record in records} == {Status.OK}
    table = cost_table(store)
    assert table["cells"].tolist() == [4]
    assert table["method [s]"].iloc[0] >= 0.2  # four pauses of 0.05 s
    share = harness_share(store)
    spent = sum(record[f"{part}_seconds"] for record in records for part in PARTS[:-1])
    (sweep,) = store.sweeps()
    assert share == pytest.approx(1 - spent / sweep["wall_seconds"], abs=0.02)
    assert sweep["cells"] == 4


def test_memory_does_not_grow_with_the_number_of_cells(tmp_path, monkeypatch):
    """The leader keeps some kilobytes a cell, whatever its method: its records without their traces."""
    monkeypatch.setitem(growth.TINY, "smm", (400, []))  # which loads no network
    few = growth.sweep(1, 2, 1, 400, tmp_path / "few", "smm")
    many = growth.sweep(6, 3, 1, 400, tmp_path / "many", "smm")
    assert many["cells"] == 18
    assert many["of it new [MiB]"] < few["of it new [MiB]"] + 3
