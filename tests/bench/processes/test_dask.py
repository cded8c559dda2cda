"""A real scheduler and real worker processes: the records of this machine, whatever happens to a worker."""

import os
import signal
import threading

import pytest
from distributed import Client
from watch import Watch

from avobench.bench.processes.dask import DaskBackend
from avobench.bench.store.store import Store
from avobench.bench.sweep.plan import plan
from avobench.bench.sweep.runner import run
from avobench.tasks.errors import UsageError
from robustness.cluster import Cluster
from robustness.warm import SWEEP


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path, allowed_failures=1)  # not 3, which takes longer
    cluster.begin(0)
    yield cluster
    cluster.end()


def wait_for(cluster, workers):
    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=60)


@pytest.fixture
def worker(cluster):
    """A worker that is there."""
    process = cluster.worker()
    wait_for(cluster, 1)
    return process


def toys(targets="0-4", method="toys:Moment", pause=0.1, repetitions=1):
    return plan(["toys:Normal"], [method], targets, repetitions, 400, 100, 0, [f"{method[5:].lower()}.pause={pause}"])


def far(cells, cluster, store, view=None):
    return run(cells, store, DaskBackend(cluster.address), view or Watch())


def test_a_worker_that_dies_while_it_is_asked_for_its_versions_is_none_the_less(cluster, worker, tmp_path):
    dying = cluster.worker()
    wait_for(cluster, 2)
    os.killpg(dying.pid, signal.SIGSTOP)  # it is connected, and does not answer
    end = threading.Timer(1.5, os.killpg, (dying.pid, signal.SIGKILL))
    end.start()
    records = far(toys("0-2"), cluster, Store(tmp_path / "far", create=True))
    end.join()
    assert [record["status"] for record in records] == ["ok"] * 3


def test_a_cell_that_kills_its_workers_is_recorded_as_crashed_and_no_other_is(cluster, tmp_path):
    cluster.worker("--nthreads", "1")  # its nanny starts it again
    wait_for(cluster, 1)
    cells = toys("0", "toys:Dying") + toys("0-2")
    records = far(cells, cluster, Store(tmp_path / "r", create=True))
    assert [record["status"] for record in records] == ["crashed", "ok", "ok", "ok"]
    assert records[0]["message"] == "the worker process died at least 2 times (killed, or out of memory)"


def test_cells_are_begun_in_their_order(cluster, worker, tmp_path):
    view = Watch()
    far(toys("3,1,2", pause=0), cluster, Store(tmp_path / "r", create=True), view)
    assert view.order == toys("3,1,2", pause=0)


def test_a_late_worker_that_is_not_fit_ends_the_sweep_and_what_was_finished_stays(cluster, worker, tmp_path):
    store = Store(tmp_path / "r", create=True)
    view = Watch(act=lambda: cluster.worker("--nthreads", "2", "--no-nanny"))
    with pytest.raises(UsageError, match="has threads 2 where this run has 1; start it with --nthreads 1"):
        far(toys("0-14", pause=0.5, repetitions=9), cluster, store, view)  # for longer than any start of a worker
    assert len(store.read_all()) >= 1


def test_a_worker_of_another_source_gets_no_cell(cluster, worker, tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.bench.processes.dask.source", lambda: "0" * 12)
    view = Watch()
    with pytest.raises(UsageError, match=r"has source [0-9a-f]{12} where this run has 000000000000; install the same"):
        far(toys(), cluster, Store(tmp_path / "r", create=True), view)
    assert not view.order


def test_the_command_needs_a_scheduler_that_answers_and_has_workers(cluster, avobench, tmp_path, monkeypatch):
    monkeypatch.setattr("avobench.bench.processes.dask.WORKERS_SECONDS", 1)
    start = (*SWEEP, "--results", tmp_path / "r", "--backend", "dask", "--scheduler")
    for scheduler, more, words in (
        (cluster.address, ("--jobs", 2), "--jobs is for --backend local"),
        ("tcp://127.0.0.1:9", (), "there is no Dask scheduler at tcp://127.0.0.1:9"),
        ("nonsense://x", (), "there is no Dask scheduler at nonsense://x"),
        (cluster.address, (), "has no workers; start some: dask worker"),
    ):
        with monkeypatch.context() as patch:
            if scheduler != cluster.address:  # the one that is there may take its time to answer
                patch.setattr("avobench.bench.processes.dask.CONNECT_SECONDS", 1)
            code, _, err = avobench(*start, scheduler, *more)
        assert code == 2
        assert words in err
        assert err.count("\n") == 1
    assert not Store(tmp_path / "r").sweeps()
