"""Commands started from a process that has loaded everything once, so that hundreds of starts cost little.

The command runs in a process group of its own, with the same code and arguments as `avobench ARGUMENTS`.
"""

import importlib
import multiprocessing
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

TESTS = Path(__file__).parents[1]
USERS = TESTS / "users"
ENVIRONMENT = {"PYTHONPATH": os.pathsep.join(map(str, (TESTS.parent, TESTS, USERS)))}
"""What lets a command, and the processes that it starts, find the modules of the tests and of users."""
LOADED = (
    *("avobench.cli.run", "avobench.cli.records", "avobench.bench.cells.trial"),
    *("avobench.cli.diagnose", "avobench.cli.challenge", "avobench.cli.main", "avobench.api.diagnosis"),
    *("avobench.challenge.solve", "avobench.challenge.make", "avobench.diagnosis.run", "avobench.reports.page"),
    *("avobench.reports.diagnosis.page", "avobench.reports.diagnosis.figures"),
)
"""What a command would load; no module that starts a thread may be among them, for each start is a fork."""
SWEEP = ["run", "--task", "toys:Normal", "--method", "toys:Moment", "--budget", "400", "--observations", "100"]
"""The beginning of a command that carries out cells of milliseconds."""
PATIENCE = 60.0
"""Seconds after which a command that should have ended is killed."""
Around = Callable[[], AbstractContextManager[None]]
"""What surrounds a command in its process."""


@dataclass(frozen=True)
class Ended:
    """How a command ended, with what it said."""

    code: int
    out: str
    err: str


@dataclass(frozen=True)
class Started:
    """A command under way; what it says goes to a folder."""

    process: BaseProcess
    place: Path

    def end(self) -> Ended:
        self.process.join(PATIENCE)
        self.process.kill()
        self.process.join()
        out, err = ((self.place / name).read_text() for name in ("out", "err"))
        shutil.rmtree(self.place)
        return Ended(self.process.exitcode, out, err)


def start(arguments: list[str], around: Around = nullcontext) -> Started:
    """Start `avobench ARGUMENTS`."""
    place = Path(tempfile.mkdtemp(prefix="told"))
    return Started(_forked(_command, (arguments, place, around)), place)


def call(arguments: list[str], around: Around = nullcontext) -> Ended:
    return start(arguments, around).end()


def calmly(arguments: list[str]) -> None:
    """Let a command end by itself, and well."""
    ended = call(arguments)
    assert ended.code == 0, f"exit code {ended.code}: {ended.err[-2000:]}"


def dask(kind: str, arguments: list[str], log: Path, settings: dict[str, Any]) -> BaseProcess:
    """Start `dask scheduler` or `dask worker` likewise, with settings of Dask's."""
    more = ("distributed.cli.dask_scheduler", "distributed.cli.dask_worker")
    return _forked(_dask, (kind, arguments, log, settings), *more)


def _forked(target: Callable[..., None], arguments: tuple, *more: str) -> BaseProcess:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*LOADED, *more])
    process = context.Process(target=target, args=arguments)
    process.start()
    return process


def _command(arguments: list[str], place: Path, around: Around) -> None:
    _settle(place / "out", place / "err")
    sys.argv = ["avobench", *arguments]
    from avobench.cli import main as cli

    with around():
        cli.main()


def _dask(kind: str, arguments: list[str], log: Path, settings: dict[str, Any]) -> None:
    import dask

    _settle(log, log)
    dask.config.set(settings)
    importlib.import_module(f"distributed.cli.dask_{kind}").main(arguments)


def _settle(*outputs: Path) -> None:
    """Have a process group of its own, and the folder of a user; what is said goes to the files."""
    os.setsid()
    os.chdir(USERS)
    os.environ |= ENVIRONMENT
    for stream, path in enumerate(outputs, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600), stream)
