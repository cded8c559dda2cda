"""The sweep: the same numbers however it is run, and nothing finished is ever lost."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from steady import without_clocks
from watch import Watch

from avobench.bench.processes.local import LocalBackend
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import run
from avobench.tasks.errors import StoreError, UsageError
from robustness.warm import SWEEP

HERE = Path(__file__).parents[2] / "users"


def sweep(path, *, methods=("toys:Moment",), targets="0-3", repetitions=1, jobs=None, settings=(), **options):
    """The records of a sweep of so many processes, or in this one, and what was said."""
    cells = plan(["toys:Normal"], list(methods), targets, repetitions, 400, 100, 0, list(settings))
    view, store = Watch(), Store(path, create=True)
    backend = LocalBackend(jobs, store.running)
    return run(cells, store, backend, view, **options), view


def test_this_process_or_two_others_give_the_same_records_bit_for_bit(tmp_path):
    settings = ["abc-smc.population_size=10", "abc-smc.events_per_theta=16"]
    cells = plan(["weinberg"], ["abc-smc"], "0", 1, 768, 300, 0, settings)
    cells += plan(["alignment"], ["avo-paper"], "0", 1, 768, 300, 0, ["avo-paper.hidden=[8]"])
    cells += plan(["toys:Normal"], ["toys:Moment"], "0", 1, 400, 100, 0, [])
    stores = [Store(tmp_path / name, create=True) for name in ("here", "two")]
    backends = LocalBackend(None, stores[0].running), LocalBackend(2, stores[1].running)
    one, two = (run(cells, store, backend, Watch()) for store, backend in zip(stores, backends, strict=True))
    assert [record["status"] for record in one] == ["ok"] * 3
    assert len(two) == 3
    assert without_clocks(stores[0].read_all()) == without_clocks(stores[1].read_all())


def test_a_second_run_does_only_what_is_missing(tmp_path):
    first, _ = sweep(tmp_path, targets="0-1")
    second, view = sweep(tmp_path, targets="0-3")
    assert len(view.order) == 2
    assert second[:2] == first
    third, view = sweep(tmp_path, targets="0-3")
    assert view.order == []
    assert third == second


def test_cells_are_finished_in_the_planned_order_with_one_worker(tmp_path):
    cells = plan(["toys:Normal"], ["toys:Moment"], "3,1,2", 2, 400, 100, 0, [])
    _, view = sweep(tmp_path, targets="3,1,2", repetitions=2)
    assert view.order == cells


def test_a_failed_cell_does_not_stop_the_sweep_and_is_tried_again_only_on_request(tmp_path):
    records, _ = sweep(tmp_path, settings=["moment.fault=raises"])
    assert [record["status"] for record in records] == ["method_error"] * 4
    _, view = sweep(tmp_path, settings=["moment.fault=raises"])
    assert view.order == []
    _, view = sweep(tmp_path, settings=["moment.fault=raises"], retry_failed=True)
    assert len(view.order) == 4


OWN = """
import avobench

class Counting:
    calls = 0

    def simulate(self, theta, rng):
        self.calls += 1
        return theta[:, 0] + rng.normal(0, SIGMA, len(theta))

SIGMA = 1.0
made = avobench.task(Counting().simulate, prior={"mu": (-2, 2)}, support={"mu": (-9, 9)})
"""


def test_a_file_that_is_edited_while_a_sweep_runs_ends_it(tmp_path):
    """Else a worker that is started later makes records of the new file under the identity of the old one."""
    path, store = tmp_path / "own.py", Store(tmp_path / "r", create=True)
    path.write_text(OWN)
    cells = plan([f"{path}:made"], ["toys:Lockstep", "toys:Moment"], "0-1", 1, 400, 100, 0, [])
    path.write_text(OWN.replace("SIGMA = 1.0", "SIGMA = 30.0"))
    with pytest.raises(UsageError, match="changed"):
        run(cells, store, LocalBackend(1, store.running), Watch())
    assert not store.read()[0]
    path.write_text(OWN)
    assert len(run(cells, store, LocalBackend(1, store.running), Watch())) == 4  # though the object counts its calls


def test_damaged_records_are_set_aside_and_made_again(tmp_path):
    first, _ = sweep(tmp_path)
    damaged = sorted((tmp_path / "records").iterdir())[1]
    damaged.write_text(damaged.read_text()[:100])
    second, view = sweep(tmp_path)
    assert without_clocks(second) == without_clocks(first)
    assert len(view.order) == 1
    assert "set aside" in view.notes[0]
    assert [path.name for path in (tmp_path / "damaged").iterdir()] == [damaged.name]


@contextmanager
def failing(monkeypatch, where, name, place, error):
    """Within the block a function fails with an error at one place."""
    sound = getattr(where, name)

    def fails(path="."):
        if Path(path) == place:
            raise error
        return sound(path)

    with monkeypatch.context() as patch:
        patch.setattr(where, name, fails)
        yield


def test_a_record_that_the_disk_does_not_give_is_never_made_again(tmp_path, monkeypatch):
    sweep(tmp_path)
    refused = sorted((tmp_path / "records").iterdir())[1]
    content = refused.read_bytes()
    told = pytest.raises(StoreError, match="cannot be read: Input/output error; look at the disk")
    with told, failing(monkeypatch, Path, "read_bytes", refused, OSError(5, "Input/output error")):
        sweep(tmp_path)
    assert refused.read_bytes() == content
    assert not (tmp_path / "damaged").exists()


def test_a_folder_that_cannot_be_listed_is_not_an_empty_one(tmp_path, monkeypatch):
    first, _ = sweep(tmp_path)
    told = pytest.raises(StoreError, match="cannot be listed: Permission denied")
    with told, failing(monkeypatch, os, "scandir", tmp_path / "records", PermissionError(13, "Permission denied")):
        sweep(tmp_path)
    again, view = sweep(tmp_path)
    assert (again, view.order) == (first, [])


COMMAND = [sys.executable, "-m", "avobench", *SWEEP, "--targets", "0-9", "--jobs", "2", "--set", "moment.pause=0.15"]


def start(path):
    """A sweep of 10 cells that was started in a process group of its own and has finished one."""
    how = {"start_new_session": True, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen([*COMMAND, "--results", str(path)], cwd=HERE, **how)
    while not list(path.glob("records/*.json")):
        assert process.poll() is None
        time.sleep(0.02)
    return process


def gone(group, seconds=120):
    """Whether a process group ends in time; a dead process stays in its group until the system has reaped it."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


def test_the_workers_of_a_killed_sweep_end_too_and_the_next_one_goes_on(tmp_path):
    process = start(tmp_path)
    process.kill()
    process.communicate()
    before = {path: path.read_bytes() for path in tmp_path.glob("records/*.json")}
    assert gone(process.pid)
    assert before.keys() == {*tmp_path.glob("records/*.json")}
    assert subprocess.run([*COMMAND, "--results", str(tmp_path)], cwd=HERE, capture_output=True).returncode == 0
    assert len(Store(tmp_path).read_all()) == 10
    assert all(path.read_bytes() == content for path, content in before.items())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_sweep_says_so_in_one_line_and_leaves_no_process(tmp_path, number):
    process = start(tmp_path)
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does on Ctrl-C
    else:
        process.send_signal(number)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 130
    kept = "avobench: stopped; finished work is kept, and the same command continues from it"
    assert error.decode().splitlines()[-1] == kept
    assert "Traceback" not in error.decode()
    assert gone(process.pid)
    sound, damaged = Store(tmp_path).read()
    assert sound
    assert not damaged


def test_a_record_that_a_newer_version_wrote_is_left_as_it_is_and_told(tmp_path):
    sweep(tmp_path, targets="0")
    (path,) = (tmp_path / "records").iterdir()
    newer = path.read_text().replace('"schema_version": 1', '"schema_version": 2')
    assert newer != path.read_text()
    path.write_text(newer)
    with pytest.raises(StoreError, match=r"schema version 2.* use the avobench that wrote it"):
        sweep(tmp_path, targets="0")
    assert path.read_text() == newer
    assert not (tmp_path / "damaged").exists()
