"""Failures of the file system, injected.

Each write, fsync, rename and so on that a command does below its results folder is made to fail in its turn: with
"no space left", an error of the device, or no permission; once, or from then on; a write also after half of it was
done, after which it fails, or the process dies as at a power cut. A small shared object, compiled from faults.c, does
this within the process. What must hold each time is in `judge`.
"""

import errno
import os
import re
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import pandas as pd

from robustness import warm
from robustness.kills import finished_records, steady_records
from robustness.preload import KINDS, MANNERS, Faults

SECONDS = 60
"""After which a command that hangs on a fault is ended by the system."""


@dataclass(frozen=True)
class Fault:
    kind: str
    error: int
    manner: str = ""
    sticky: bool = False

    @property
    def label(self) -> str:
        name = errno.errorcode.get(self.error, "")
        return " ".join(part for part in (self.kind, name, self.manner, "from then on" if self.sticky else "") if part)


FAULTS = [
    *(Fault(kind, error) for kind in KINDS for error in (errno.ENOSPC, errno.EIO, errno.EACCES)),
    *(Fault(kind, errno.ENOSPC, sticky=True) for kind in ("open", "write", "fsync", "mkdir")),
    Fault("write", errno.ENOSPC, "torn", sticky=True),
    Fault("write", 0, "short"),
    Fault("write", 0, "dies"),
]


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str
    fired: int


RUN = ["run", "--task", "toys:Normal", "--method", "toys:Moment", "--budget", "400", "--observations", "100"]
RUN += ["--targets", "0-3"]
COMMANDS: dict[str, Callable[[Path], list[str]]] = {
    "run": lambda folder: [*RUN, *in_process(), "--results", str(folder)],
    "pack": lambda folder: ["pack", "--results", str(folder)],
    "export": lambda folder: ["export", "--format", "csv", "--out", str(folder / "t.csv"), "--results", str(folder)],
}


def in_process() -> list[str]:
    """Cells in the command's own process, for which the faults are set."""
    from avobench.cli.run import run

    known = {name for option in run.params for name in option.opts}
    return ["--jobs", "1", *({"--in-process"} & known)]


@dataclass(frozen=True)
class Started:
    """A command under way in a fork of this process; what it says goes to the folder."""

    pid: int
    place: Path


def start(arguments: list[str], set_up: Callable[[], None] = lambda: None, faults: Faults | None = None) -> Started:
    place = Path(tempfile.mkdtemp(prefix="told"))
    child = os.fork()
    if child == 0:
        _be(arguments, place, set_up, faults)
    return Started(child, place)


def _be(arguments: list[str], place: Path, set_up: Callable[[], None], faults: Faults | None) -> NoReturn:
    """Be the command `avobench`, in this process, which ends with it."""
    signal.alarm(SECONDS)
    for stream, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(place / name, os.O_WRONLY | os.O_CREAT, 0o600), stream)
    os.chdir(warm.USERS)
    sys.argv = ["avobench", *arguments]
    set_up()
    from avobench.cli import main as cli

    code = 0
    try:
        cli.main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0
    except BaseException:
        traceback.print_exc()
        code = 99
    sys.stdout.flush()
    sys.stderr.flush()
    fired = 0
    if faults is not None:
        fired = faults.get("fired")
        faults.set(kind=0)
    (place / "fired").write_text(str(fired))
    os._exit(code)


def end(started: Started) -> Ended:
    """Wait for a command, and read what it said."""
    place = started.place
    code = os.waitstatus_to_exitcode(os.waitpid(started.pid, 0)[1])
    out, err = ((place / name).read_text() for name in ("out", "err"))
    fired = int((place / "fired").read_text()) if (place / "fired").exists() else 1
    shutil.rmtree(place)
    return Ended(code, out, err, fired)


def call(arguments: list[str], set_up: Callable[[], None] = lambda: None, faults: Faults | None = None) -> Ended:
    """The command in a fork of this process, with what it said."""
    return end(start(arguments, set_up, faults))


def prepare(folder: Path) -> None:
    """A store with a packed record and two files; `run` lacks a fourth."""
    for arguments in ([*RUN[:-1], "0"], ["pack"], [*RUN[:-1], "1-2"]):
        own = in_process() if arguments[0] == "run" else []
        assert call([*arguments, *own, "--results", str(folder)]).code == 0


def judge(ended: Ended, before: dict[str, bytes], folder: Path, arguments: list[str], calm: Any) -> str:
    """Whether the fault was told or harmless. Raises AssertionError unless

    what was finished is there as it was; all that reads as a record is whole; a command that did not do all ends with
    an exit code that is not 0 and a line that says why, and no traceback; and the same command, when the fault is over,
    ends as an undisturbed one.
    """
    found = finished_records(folder)
    lost = [name for name, content in before.items() if found.get(name) != content]
    assert not lost, f"lost {lost}"
    if ended.code == 0:
        assert not ended.err or "cells ok" in ended.out, ended.err
        assert arguments[0] == "export" or steady_records(folder) == calm, "exit code 0, and not all was done"
    elif ended.code != 137:
        assert ended.code in (1, 2), f"exit code {ended.code}: {ended.err}"
        last = ended.err.strip().splitlines()[-1]
        assert last.startswith("avobench: "), ended.err
        assert "Traceback" not in ended.err, ended.err
        assert "a fault of avobench" not in last, last
        assert sum(line.startswith("avobench: ") for line in ended.err.splitlines()) == 1, ended.err
    again = call(arguments)
    assert again.code == 0, f"afterwards: {again.err}"
    assert steady_records(folder) == calm, "afterwards: not as an undisturbed run"
    left = [path.name for path in folder.glob("**/.*.tmp")]
    assert arguments[0] == "export" or not left, f"afterwards: {left} left"
    return "harmless" if ended.code == 0 else "died" if ended.code == 137 else "told"


def turns(faults: Faults, name: str, fault: Fault, template: Path, folder: Path) -> Iterator[tuple[Ended, list[str]]]:
    """The command with the fault at its first operation, its second, and so on, as long as there is one."""
    for turn in range(1000):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(template, folder)
        arguments = COMMANDS[name](folder)

        def set_up(turn: int = turn) -> None:
            manner = MANNERS[fault.manner]
            faults.root(folder)
            faults.set(turn=turn, errno=fault.error, manner=manner, sticky=fault.sticky, seen=0, fired=0)
            faults.set(kind=1 + KINDS.index(fault.kind))

        ended = call(arguments, set_up, faults)
        if not ended.fired:
            return
        yield ended, arguments


def campaign(place: Path, every: int = 1) -> dict[str, Any]:
    """All commands with every fault, or each `every`th of the list: what came of them, and what must not."""
    faults, outcomes, wrong = Faults(), Counter(), []
    template = place / "template"
    prepare(template)
    for number, name in enumerate(COMMANDS):
        shutil.copytree(template, place / f"calm-{name}")
        assert call(COMMANDS[name](place / f"calm-{name}")).code == 0
        calm, before = steady_records(place / f"calm-{name}"), finished_records(template)
        for fault in FAULTS[number % every :: every]:
            for turn, (ended, arguments) in enumerate(turns(faults, name, fault, template, place / "store")):
                try:
                    outcome = judge(ended, before, place / "store", arguments, calm)
                except (AssertionError, ValueError) as error:
                    outcome = "wrong"
                    wrong.append(f"{name}: {fault.label} at {turn}: {re.sub(str(place), '', str(error))}")
                outcomes[name, fault.kind, outcome] += 1
    return {"outcomes": [[*key, count] for key, count in outcomes.items()], "wrong": wrong}


def table(found: dict[str, Any]) -> str:
    """A line a command and operation: how many failed, and what came of it."""
    rows = pd.DataFrame(found["outcomes"], columns=["command", "operation", "outcome", "times"])
    told = rows.pivot_table("times", ["command", "operation"], "outcome", "sum", 0, sort=False).to_string()
    return f"{told}\n{rows['times'].sum()} operations failed, {len(found['wrong'])} of them with a wrong outcome"
