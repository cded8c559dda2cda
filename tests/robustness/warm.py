"""Commands started from a process that has loaded everything once, so that thousands of starts cost little.

The command runs in a process group of its own, with the same code and arguments as `avobench ARGUMENTS`.
"""

import importlib
import multiprocessing
import os
import signal
import sys
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

OPERATIONS = ("open", "tempfile.mkstemp", "os.chmod", "os.mkdir", "os.rename", "os.remove", "os.rmdir")
"""What Python tells an audit hook just before it does it."""


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


def start(arguments: list[str], log: Path, kill: tuple[Path, int] | None = None) -> BaseProcess:
    """Start `avobench ARGUMENTS`, its standard output and error in `log`; `kill` as `kill_before` takes it."""
    environment()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(LOADED))
    process = context.Process(target=command, args=(arguments, log, kill))
    process.start()
    return process


def calmly(arguments: list[str], log: Path) -> None:
    """Let a command end by itself, and well."""
    process = start(arguments, log)
    process.join()
    assert process.exitcode == 0, f"exit code {process.exitcode}: {log.read_text()[-2000:]}"


def command(arguments: list[str], log: Path, kill: tuple[Path, int] | None = None) -> None:
    """Be the command `avobench`, in this process and a group of its own."""
    _settled(log)
    sys.argv = ["avobench", *arguments]
    if kill is not None:
        kill_before(*kill)
    from avobench.cli import main as cli

    cli.main()


def kill_before(folder: Path, number: int) -> None:
    """Kill this process just before its operation `number`, from 0, on files below a folder; each second its group."""
    seen = 0

    def hook(event: str, arguments: tuple) -> None:
        nonlocal seen
        if event not in OPERATIONS or not str(arguments[0]).startswith(str(folder)):
            return
        if event == "open" and not arguments[2] & os.O_ACCMODE:  # which only reads
            return
        if seen == number:
            os.kill(0 if number % 2 else os.getpid(), signal.SIGKILL)
        seen += 1

    sys.addaudithook(hook)


def dask(kind: str, arguments: list[str], log: Path) -> BaseProcess:
    """Start `dask scheduler` or `dask worker` likewise."""
    environment()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LOADED, "distributed.cli.dask_scheduler", "distributed.cli.dask_worker"])
    process = context.Process(target=_dask, args=(kind, arguments, log))
    process.start()
    return process


def _dask(kind: str, arguments: list[str], log: Path) -> None:
    _settled(log)
    importlib.import_module(f"distributed.cli.dask_{kind}").main(["--no-dashboard", *arguments])


def _settled(log: Path) -> None:
    """Have a process group of its own, the folder of the user's modules, and the log as output."""
    os.setsid()
    os.chdir(USERS)
    with log.open("ab", buffering=0) as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
