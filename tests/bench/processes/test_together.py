"""Cells carried out as one piece of work: the records of single ones, and a fault costs its own cell only."""

import time

import numpy as np
import pytest
import torch
from steady import without_clocks
from watch import Watch

from avobench.bench.cells.trial import execute
from avobench.bench.processes.local import LocalBackend
from avobench.bench.store.status import Status
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import run, seconds

ESTIMATED = ("theta_hat", "squared_error", "mean", "std", "trace", "message")


def toys(*settings, task="Normal", methods=("Lockstep",), targets="0-3", repetitions=2, budget=400):
    settings = [f"lockstep.{setting}" for setting in settings]
    specs = [f"toys:{method}" for method in methods]
    return plan([f"toys:{task}"], specs, targets, repetitions, budget, 100, 0, settings)


def together(path, cells, jobs=None, most=None):
    """Records with traces in the planned order, and what was noted."""
    store, view = Store(path, create=True), Watch()
    backend = LocalBackend(jobs, store.running, together=True, most=most)
    order = [record["id"] for record in run(cells, store, backend, view)]
    return sorted(store.read_all(), key=lambda record: order.index(record["id"])), view


def numbers(record):
    """Estimate, errors and trace of a record as one array."""
    trace = [value for point in record["trace"] for value in (*point["theta"], *(point["std"] or []))]
    return np.array([*record["theta_hat"], *record["mean"], *record["std"], record["squared_error"], *trace])


def assert_as_single(records, cells):
    for record, cell in zip(records, cells, strict=True):
        single = execute(cell)
        rest, expected = ({name: each[name] for name in each if name not in ESTIMATED} for each in (record, single))
        assert without_clocks(rest) == without_clocks(expected)
        np.testing.assert_allclose(numbers(record), numbers(single), rtol=0, atol=1e-6)


@pytest.mark.parametrize("jobs", [None, 2])
def test_records_are_those_of_single_cells(tmp_path, jobs):
    cells = toys()
    records, view = together(tmp_path, cells, jobs)
    assert_as_single(records, cells)
    assert {record["message"] for record in records} == {"one of 8 cells carried out together"}
    assert not view.notes


def test_each_cell_has_its_share_of_the_time_and_together_they_have_all_of_it(tmp_path):
    start = time.perf_counter()
    records, _ = together(tmp_path, toys("pause=0.1"))
    spent = time.perf_counter() - start
    assert len({record["method_seconds"] for record in records}) == 1
    assert 0.4 < 8 * records[0]["method_seconds"] < spent
    assert 0.4 < sum(map(seconds, records)) < spent


def test_pieces_are_of_one_task_and_method_and_the_rest_follows_one_by_one(tmp_path):
    cells = plan(["toys:Normal", "toys:Cliff"], ["toys:Moment", "toys:Lockstep"], "0-2", 1, 400, 100, 0, [])
    pieces = LocalBackend(1, tmp_path, together=True).pieces(cells)
    assert [len(piece) for piece in pieces] == [3, 3, 1, 1, 1, 1, 1, 1]
    assert [[cell.target for cell in piece] for piece in pieces[:2]] == [[0, 1, 2]] * 2
    labels = [piece[0].label.split(" target")[0] for piece in pieces[:3]]
    assert labels == ["normal lockstep", "cliff lockstep", "normal moment"]
    assert sorted(cell.id for piece in pieces for cell in piece) == sorted(cell.id for cell in cells)
    assert [len(piece) for piece in LocalBackend(1, tmp_path, together=True, most=2).pieces(cells)][:2] == [2, 2]
    pieces = LocalBackend(1, tmp_path, together=True).pieces([*toys(), *toys("steps=2"), *toys(budget=800)])
    assert [len(piece) for piece in pieces] == [8, 8, 8]


def test_one_that_fails_fails_alone(tmp_path):
    cells = toys("fault=raises", "limit=0.6", targets="0-14", repetitions=1)
    guilty = [execute(cell)["status"] == Status.METHOD_ERROR for cell in cells]
    assert 0 < sum(guilty) < len(cells)
    records, view = together(tmp_path, cells)
    assert [record["status"] == Status.METHOD_ERROR for record in records] == guilty
    messages = {record["message"] for record in records if record["status"] != Status.OK}
    assert messages == {"RuntimeError: lost the thread"}
    assert all(record["simulations_used"] == 400 for record in records if record["status"] == Status.OK)
    assert view.notes[0] == (
        "normal lockstep, 15 cells together: RuntimeError: lost the thread; begun again in halves, as with --group 8"
    )


def test_one_that_cannot_be_observed_does_not_hold_up_the_others(tmp_path):
    cells = toys(task="Cliff", targets="0-14", repetitions=1, budget=800)
    over = [cell.build_task().targets()[cell.target][0] > 0.5 for cell in cells]
    records, view = together(tmp_path, cells)
    assert [record["status"] == Status.SIMULATOR_ERROR for record in records] == over
    assert "over the edge" in records[over.index(True)]["message"]
    assert records[over.index(False)]["message"] == f"one of {over.count(False)} cells carried out together"
    assert not view.notes


def test_what_a_gpu_has_no_memory_for_is_done_in_smaller_pieces(tmp_path):
    cells = toys("most=2", targets="0-4", repetitions=1)
    records, view = together(tmp_path, cells)
    assert_as_single(records, cells)
    assert view.notes[0] == (
        "normal lockstep, 5 cells together: CUDA out of memory. Tried to allocate 2.00 GiB; fewer cells at a time "
        "(--group, --jobs) or --device cpu need less; begun again in halves, as with --group 3"
    )
    assert len(view.notes) == 2
    (alone,) = toys("most=0", targets="0", repetitions=1)
    assert execute(alone)["message"].endswith("(--group, --jobs) or --device cpu need less")


def test_a_method_that_returns_too_few_is_asked_one_by_one(tmp_path):
    records, view = together(tmp_path, toys("fault=few", targets="0-2", repetitions=1))
    assert [record["status"] for record in records] == ["ok"] * 3
    assert "must return a list of 3 estimates, got [Estimate(" in view.notes[0]


def test_one_that_kills_its_worker_crashes_alone(tmp_path):
    cells = toys("fault=dies", "limit=0.6", targets="5-9", repetitions=1)
    guilty = [cell.target == 8 for cell in cells]  # at 0.7, the others below 0.5
    records, view = together(tmp_path, cells, jobs=2)
    assert [record["status"] == Status.CRASHED for record in records] == guilty
    assert view.notes[0].startswith("normal lockstep, 5 cells together: the process was ended by SIGKILL")
    assert view.notes[0].endswith("begun again one by one")
    assert not any((tmp_path / "running").iterdir())


def test_all_cells_of_a_piece_tell_how_far_they_are(tmp_path):
    _, view = together(tmp_path, toys("pause=0.7", targets="0-1"))
    assert len(view.shares) == 4
    assert all(0 < shares[-1] < 1 for shares in view.shares.values())


def test_the_command_takes_the_backend_and_its_limit(done, tmp_path):
    start = ("run", "--task", "toys:Normal", "--method", "toys:Lockstep", "--targets", "0-3", "--budget", 400)
    start += ("--observations", 100, "--jobs", 1, "--results", tmp_path / "r")
    assert "4 of 4 cells ok" in done(*start, "--backend", "together", "--group", 3)
    messages = [record["message"] for record in Store(tmp_path / "r").read_all()]
    assert messages == ["one of 3 cells carried out together"] * 3 + [""]
    assert Store(tmp_path / "r").sweeps()[0]["backend"] == "together"


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")
def test_avo_trains_all_targets_at_once_on_a_gpu(done, tmp_path):
    start = ("run", "--task", "poisson", "--method", "avo", "--targets", "0-3", "--budget", 16000, "--jobs", 1)
    start += ("--observations", 20000, "--results", tmp_path / "r")
    for device in ("cpu", "cuda"):
        done(*start, "--device", device)
    records = sorted(Store(tmp_path / "r").read_all(), key=lambda record: record["target"])
    assert [record["target"] for record in records] == [0, 0, 1, 1, 2, 2, 3, 3]
    assert sum("one of 4 cells carried out together" in record["message"] for record in records) == 4
    for first, second in zip(records[::2], records[1::2], strict=True):
        assert abs(first["theta_hat"][0] - second["theta_hat"][0]) < 5 * np.sqrt(first["floor"])
