"""Cells carried out by the workers of a Dask cluster, on this machine or on others.

joblib has a Dask backend too, but there an error of one cell ends all others that are running, and neither the cell
whose worker died nor how far the others are can be told. So this asks `distributed` directly.
"""

import hashlib
import os
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avobench.bench.cells.cell import Cell
from avobench.bench.cells.trial import blank_record, execute
from avobench.bench.processes.contract import ATTEMPTS, Backend, differing, heartbeat
from avobench.bench.store.status import Status
from avobench.bench.store.versions import versions
from avobench.tasks.errors import AvobenchError, UsageError, optional

if TYPE_CHECKING:
    from distributed import Client, Future, Worker, as_completed

CONNECT_SECONDS = 5
"""The scheduler must answer within this: a network that works takes milliseconds, and a user should not wait long."""
WORKERS_SECONDS = 10
"""The first worker must be there within this; one that is started together with the sweep needs a few seconds."""
LOOK_SECONDS = 0.05
"""The pause between two looks for what has ended, where nothing had: cells take seconds."""
TOPIC = "avobench"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class DaskBackend(Backend):
    """The workers that are connected to a scheduler; more may come and go while the sweep runs.

    A worker needs the same versions of all that a result depends on, and one thread. A cell whose worker dies goes to
    another one, until it has lost the scheduler's `allowed-failures` (3) and one more.
    """

    name = "dask"

    def __init__(self, scheduler: str, *, debug: bool = False) -> None:
        """Nothing is connected before `records` is asked for; raises UsageError when Dask is not installed."""
        optional("distributed", "--backend dask", "cluster")
        self._scheduler, self._debug, self._most = scheduler, debug, 0
        self._running: dict[str, tuple[float, str]] = {}

    @property
    def workers(self) -> int:
        """The most that were at work at a time so far."""
        return self._most

    def shares(self) -> dict[str, float]:
        return {id: share for id, (share, _) in self._running.copy().items()}

    def records(self, cells: list[Cell], note: Callable[[str], None]) -> Iterator[dict[str, Any]]:
        from distributed import KilledWorker, as_completed
        from distributed.comm import CommClosedError

        wanted, by_id = facts(), {cell.id: cell for cell in cells}
        order = {id: -place for place, id in enumerate(by_id)}
        tries: dict[str, int] = {}
        begun: dict[str, int] = {}

        def heard(event: tuple[float, dict[str, Any]]) -> None:
            """Called by the client's own thread."""
            id, share, worker = (event[1][name] for name in ("id", "share", "worker"))
            if id in by_id:  # another sweep may use the scheduler too
                self._running[id] = share, worker
                self._most = max(self._most, len({worker for _, worker in self._running.copy().values()}))
                if share == 0:
                    begun[id] = begun.get(id, 0) + 1
                    if begun[id] > 1:
                        note(f"{by_id[id].label}: its worker died, begun again on {worker}")

        def submit(client: "Client", cell: Cell) -> "Future":
            # The key says what the result depends on, so a cell that still runs for a sweep that was stopped is taken
            # over. Dask forgets a result when its future goes, so none is kept here.
            tries[cell.id] = tries.get(cell.id, 0) + 1
            key = f"{cell.id}-{wanted['source']}-{tries[cell.id]}"
            return client.submit(_work, cell, wanted, self._debug, key=key, priority=order[cell.id])

        with _connected(self._scheduler) as client:
            for address, answer in client.run(facts, on_error="return").items():
                if not isinstance(answer, CommClosedError):  # that one died before it could answer
                    require_equal(address, answer, wanted)
            client.subscribe_topic(TOPIC, heard)
            futures = [submit(client, cell) for cell in cells]
            queue = as_completed(futures, loop=client.loop, with_results=True, raise_errors=False)
            del futures  # what holds a future keeps its result
            for future, outcome in self._ended(queue, client):
                id = future.key.partition("-")[0]
                self._running.pop(id, None)
                if isinstance(outcome, dict):  # even if its worker died since, and Dask is about to make it again
                    yield outcome
                elif future.status == "pending":  # its worker died before it could hand over the record
                    queue.add(future)
                elif future.status != "error":
                    raise self._gone(client)
                elif isinstance(outcome[1], AvobenchError):
                    raise outcome[1]
                elif not isinstance(outcome[1], KilledWorker):
                    raise AvobenchError(f"Dask could not carry out {by_id[id].label}: {outcome[1]}") from outcome[1]
                elif max(tries[id], begun.get(id, 0)) >= ATTEMPTS:
                    message = f"the worker process died at least {ATTEMPTS} times (killed, or out of memory)"
                    yield blank_record(by_id[id], Status.CRASHED, message)
                else:  # it was only waiting in the queues of workers that others brought down
                    queue.add(submit(client, by_id[id]))

    def _ended(self, queue: "as_completed", client: "Client") -> Iterator[tuple["Future", Any]]:
        """Futures with their outcomes, as they end. Raises AvobenchError when the scheduler is gone."""
        while not queue.is_empty():
            batch = queue.next_batch(block=False)
            yield from batch
            if not batch and client.status != "running":
                raise self._gone(client)
            if not batch:
                time.sleep(LOOK_SECONDS)

    def _gone(self, client: "Client") -> AvobenchError:
        while client.status in ("connecting", "closing"):  # closed in the middle, it logs a traceback
            time.sleep(0.1)
        return AvobenchError(f"the Dask scheduler at {self._scheduler} went away")


def _connected(scheduler: str) -> "Client":
    """A client of the scheduler, which has at least one worker. Raises UsageError."""
    from distributed import Client

    try:
        client = Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(f"there is no Dask scheduler at {scheduler}: {error}") from error
    try:
        client.wait_for_workers(1, timeout=WORKERS_SECONDS)
    except TimeoutError as error:
        client.close()
        raise UsageError(
            f"the Dask scheduler at {scheduler} has no workers; start some: dask worker {scheduler} --nthreads 1"
        ) from error
    return client


def facts(dask_worker: "Worker | None" = None) -> dict[str, Any]:
    """The facts that must be the same wherever cells are carried out, so that results are. Dask gives `dask_worker`."""
    threads = 1 if dask_worker is None else dask_worker.state.nthreads
    packages = {name: version for name, version in versions().items() if name != "commit"}
    return packages | {"source": source()} | {name: os.environ.get(name) for name in THREADS} | {"threads": threads}


@cache
def source() -> str:
    """A hash of the source of this package, which tells two states of a checkout apart where a version does not."""
    root, digest = Path(__file__).resolve().parents[2], hashlib.sha256()
    for path in sorted(
        path for part in ("bench", "effects", "methods", "tasks") for path in (root / part).rglob("*.py")
    ):
        digest.update(f"{path.relative_to(root).as_posix()}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def require_equal(address: str, answer: dict[str, Any] | Exception, wanted: dict[str, Any]) -> None:
    """Raise UsageError, in one line, when a worker's facts are not those of the sweep."""
    if isinstance(answer, Exception):
        raise UsageError(f"the worker at {address} cannot use avobench: {type(answer).__name__}: {answer}")
    for name in wanted:
        if answer.get(name) != wanted[name]:
            what = f"{name} {answer.get(name)} where this run has {wanted[name]}"
            hint = "start it with --nthreads 1" if name in ("threads", *THREADS) else "install the same on both"
            raise UsageError(f"the worker at {address} has {what}; {hint}")


def _work(cell: Cell, wanted: dict[str, Any], debug: bool) -> dict[str, Any]:
    """One cell in a worker's only thread. Raises UsageError when the worker, which may have come late, is not fit."""
    from distributed import get_worker

    worker = get_worker()
    require_equal(worker.address, facts(worker), wanted)
    if what := differing(cell):
        raise UsageError(f"the worker at {worker.address} has another version of {what}; give it the same files")
    topic = {"id": cell.id, "worker": worker.address}
    return execute(cell, heartbeat(cell, lambda share: worker.log_event(TOPIC, {**topic, "share": share})), debug)
