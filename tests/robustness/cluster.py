"""A sweep on a Dask cluster whose processes die.

Workers of this machine carry out short cells. Every few seconds one of them, drawn at random, is ended by
SIGKILL and another one started in its place. Once, when half of the cells are finished, the scheduler is killed with
all that it knew; the sweep then ends with a line, a new scheduler and new workers are started, and the same sweep is
begun again, as a user would. A cell that loses two workers is recorded as crashed, and may be innocent here: such
cells are made again with `--retry-failed` when nobody kills any more. In the end every cell must be finished once, with
the numbers of this machine.
"""

import json
import os
import random
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from pathlib import Path

from steady import without_clocks

from robustness import warm

GLANCE = 0.01
"""Seconds between two looks at how many cells are finished; a cell takes some tens of milliseconds."""


@dataclass
class Cluster:
    """A scheduler and workers in processes of this machine, which can be killed one by one."""

    folder: Path
    allowed_failures: int = 3
    """The workers that a cell may bring down before Dask gives it up, less one; 3 is Dask's own number."""
    workers: list[BaseProcess] = field(default_factory=list)
    scheduler: BaseProcess | None = None
    address: str = ""

    def begin(self, workers: int) -> None:
        file = self.folder / "scheduler.json"
        file.unlink(missing_ok=True)
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        deadline = time.monotonic() + 60
        while not file.exists() or not file.read_text():
            assert time.monotonic() < deadline, (self.folder / "log").read_text()[-2000:]
            time.sleep(0.05)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(workers):
            self.worker()

    def worker(self, *arguments: str) -> BaseProcess:
        """Start a worker; without a nanny, which would start it again, if the arguments do not say otherwise."""
        arguments = arguments or ("--nthreads", "1", "--no-nanny")
        self.workers.append(self._start("worker", self.address, *arguments, "--local-directory", str(self.folder)))
        return self.workers[-1]

    def end(self) -> None:
        for process in (*self.workers, *filter(None, [self.scheduler])):
            kill(process)
        self.workers = []

    def _start(self, kind: str, *arguments: str) -> BaseProcess:
        settings = {"distributed.scheduler.allowed-failures": self.allowed_failures}
        return warm.dask(kind, ["--no-dashboard", *arguments], self.folder / "log", settings)


def kill(process: BaseProcess) -> None:
    """Kill a process, with the worker that it started if it is a nanny."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.join(10)


@dataclass
class Killer:
    """Kills a worker at random moments, about every `seconds`, and the scheduler once, at half of the cells."""

    cluster: Cluster
    seconds: float
    half: int
    finished: list[str]
    moments: random.Random
    workers: int = 0
    schedulers: int = 0
    stop: threading.Event = field(default_factory=threading.Event)

    def work(self) -> None:
        due = self._due()
        while not self.stop.wait(GLANCE):
            if not self.schedulers and len(self.finished) >= self.half:
                self.schedulers += 1
                kill(self.cluster.scheduler)
                return
            if time.monotonic() >= due:
                kill(self.cluster.workers.pop(self.moments.randrange(len(self.cluster.workers))))
                self.workers += 1
                self.cluster.worker()
                due = self._due()

    def _due(self) -> float:
        return time.monotonic() + self.moments.uniform(0, 2 * self.seconds)


def _ends(sweep: Callable[[], object], cluster: Cluster, killer: Killer, workers: int) -> list[str]:
    """How a sweep ended each time that it was begun, the last time by itself."""
    from avobench.tasks.errors import AvobenchError

    ends = []
    while len(ends) < 10 and "finished" not in ends:
        cluster.begin(workers)
        killer.stop = threading.Event()
        thread = threading.Thread(target=killer.work)
        thread.start()
        try:
            sweep()
            ends.append("finished")
        except AvobenchError as error:
            ends.append(str(error))
            assert "went away" in ends[-1], ends[-1]
        finally:
            killer.stop.set()
            thread.join()
            cluster.end()
    return ends


def soak(folder: Path, cells: int, workers: int, seconds: float, seed: int) -> str:
    """The sweep to its end, however often it must be begun. Raises AssertionError for a cell that is lost or twice."""
    from avobench.bench.processes.dask import DaskBackend
    from avobench.bench.processes.local import LocalBackend
    from avobench.bench.store.store import Store
    from avobench.bench.sweep.plan import plan
    from avobench.bench.sweep.runner import View, run

    finished: list[str] = []
    crashed: list[str] = []
    notes: list[str] = []

    class Watch(View):
        def note(self, line: str) -> None:
            notes.append(line)

        def finished(self, sweep: object, cell: object, record: dict) -> None:
            (finished if record["status"] == "ok" else crashed).append(record["id"])

    pause = ["moment.pause=0.005"]
    asked = plan(["toys:Normal"], ["toys:Moment"], "0-9", -(-cells // 10), 400, 100, 0, pause)[:cells]
    store, cluster = Store(folder / "far", create=True), Cluster(folder)
    killer = Killer(cluster, seconds, cells // 2, finished, random.Random(seed))
    begun = time.monotonic()
    try:
        ends = _ends(lambda: run(asked, store, DaskBackend(cluster.address), Watch()), cluster, killer, workers)
        if crashed:
            messages = {record["message"] for record in store.read()[0] if record["status"] != "ok"}
            assert all("worker process died" in message for message in messages), messages
            cluster.begin(workers)
            run(asked, store, DaskBackend(cluster.address), Watch(), retry_failed=True)
    finally:
        cluster.end()
    took = time.monotonic() - begun
    assert ends[-1] == "finished", ends
    twice = [id for id, count in Counter(finished).items() if count > 1]
    assert not twice, f"made twice: {twice}"
    records, damaged = store.read()
    assert not damaged, damaged
    assert sorted(record["id"] for record in records) == sorted(cell.id for cell in asked), "cells are missing"
    failed = [record["message"] for record in records if record["status"] != "ok"]
    assert not failed, f"{len(failed)} cells failed, the first with: {failed[0]}"
    sample = asked[:: max(1, cells // 100)]
    near = run(sample, local := Store(folder / "near", create=True), LocalBackend(1, local.running), View())
    far = {record["id"]: record for record in records}
    for record in near:
        other = {name: far[record["id"]][name] for name in record}  # with its trace
        assert without_clocks(record) == without_clocks(other), f"{record['id']} is another one here"
    again = sum("begun again" in note for note in notes)
    return f"""{cells} cells on {workers} workers in {took:.0f} s, {len(ends)} sweeps: {"; ".join(ends)}
{killer.workers} workers and {killer.schedulers} scheduler killed, {again} cells begun again elsewhere
{len(crashed)} cells lost two workers and were made again with --retry-failed
{len(records)} records, each made once, all ok; {len(near)} of them made here too, the same bit for bit"""
