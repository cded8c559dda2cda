"""Commands started from a process that has loaded everything once, so that thousands of starts cost little.

The command runs in a process group of its own, with the same code and arguments as `avobench ARGUMENTS`.
"""

import importlib
import multiprocessing
import os
import sys
import time
from multiprocessing.process import BaseProcess
from pathlib import Path

TESTS = Path(__file__).parents[1]
USERS = TESTS / "users"
OF_STORES = ("avobench.cli.run", "avobench.cli.records", "avobench.bench.cells.trial", "avobench.bench.store.pack")
LOADED = (
    *OF_STORES,
    *("avobench.cli.diagnose", "avobench.cli.challenge", "avobench.cli.main", "avobench.api.diagnosis"),
    *("avobench.challenge.solve", "avobench.challenge.make", "avobench.diagnosis.run", "avobench.reports.page"),
    *("avobench.reports.diagnosis.page", "avobench.reports.diagnosis.figures", "toys"),
)
"""What a command would load; no module that starts a thread may be among them, for each start is a fork."""


def environment() -> None:
    """What the command needs of its surroundings: one thread a process, and the toy task beside the user."""
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[variable] = "1"
    os.environ["PYTHONPATH"] = os.pathsep.join(map(str, (TESTS.parent, TESTS, USERS)))
    sys.path[:0] = [part for part in map(str, (TESTS, USERS)) if part not in sys.path]


def loaded() -> None:
    """Load what commands on a store would, in this process, of which each of them is a fork."""
    environment()
    for module in OF_STORES:
        importlib.import_module(module)


def start(arguments: list[str], log: Path) -> BaseProcess:
    """Start `avobench ARGUMENTS`, its standard output and error in `log`."""
    environment()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(LOADED))
    process = context.Process(target=command, args=(arguments, log))
    process.start()
    while process.exitcode is None and os.getpgid(process.pid) != process.pid:
        time.sleep(0.001)  # until it has a group of its own, which signals are sent to
    return process


def command(arguments: list[str], log: Path | None = None) -> None:
    """Be the command `avobench`, in this process."""
    os.setsid()
    os.chdir(USERS)
    if log is not None:
        with log.open("ab", buffering=0) as file:
            for stream in (1, 2):
                os.dup2(file.fileno(), stream)
    sys.argv = ["avobench", *arguments]
    workers_by_fork()
    from avobench.cli import main as cli

    try:
        cli.main()
    except SystemExit as end:
        sys.stdout.flush()
        sys.stderr.flush()
        # Here a fork would wait for its workers, which a command that was started by itself ends on its way out.
        os._exit(end.code if isinstance(end.code, int) else 0)


def workers_by_fork() -> None:
    """Let joblib fork its workers from here: an interpreter of its own for each takes a second of a core."""
    from joblib.externals.loky.backend import context

    context.set_start_method("fork", force=True)


def dask(kind: str, arguments: list[str], log: Path) -> BaseProcess:
    """Start `dask scheduler` or `dask worker` likewise."""
    environment()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LOADED, "distributed.cli.dask_scheduler", "distributed.cli.dask_worker"])
    process = context.Process(target=_dask, args=(kind, arguments, log))
    process.start()
    return process


def _dask(kind: str, arguments: list[str], log: Path) -> None:
    os.setsid()
    os.chdir(USERS)
    with log.open("ab", buffering=0) as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    importlib.import_module(f"distributed.cli.dask_{kind}").main(["--no-dashboard", *arguments])
