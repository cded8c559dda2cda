"""Failures of the file system, injected.

Each write, fsync, rename and so on that a command does below its results folder is made to fail in its turn: with
"no space left", an error of the device, or no permission; once, or from then on; a write also after half of it was
done, after which it fails, or the process dies as at a power cut. A small shared object, compiled from faults.c, does
this within the process. What must hold each time is in `judge`.
"""

import errno
import re
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from robustness.kills import finished_records, lost_records, steady_records
from robustness.preload import KINDS, MANNERS, Faults
from robustness.warm import SWEEP, Ended, call, calmly


@dataclass(frozen=True)
class Fault:
    kind: str
    error: int
    manner: str = ""
    sticky: bool = False

    @property
    def label(self) -> str:
        parts = self.kind, errno.errorcode.get(self.error, ""), self.manner, "from then on" if self.sticky else ""
        return " ".join(filter(None, parts))


FAULTS = [
    *(Fault(kind, error) for kind in KINDS for error in (errno.ENOSPC, errno.EIO, errno.EACCES)),
    *(Fault(kind, errno.ENOSPC, sticky=True) for kind in ("open", "write", "fsync", "mkdir")),
    Fault("write", errno.ENOSPC, "torn", sticky=True),
    Fault("write", 0, "short"),
    Fault("write", 0, "dies"),
]


RUN = [*SWEEP, "--in-process", "--targets", "0-3"]
COMMANDS: dict[str, Callable[[Path], list[str]]] = {
    "run": lambda folder: [*RUN, "--results", str(folder)],
    "pack": lambda folder: ["pack", "--results", str(folder)],
    "export": lambda folder: ["export", "--format", "csv", "--out", str(folder / "t.csv"), "--results", str(folder)],
}


@contextmanager
def faulty(folder: Path, fault: Fault, turn: int) -> Iterator[None]:
    """Within the block the operation `turn`, from 0, of a kind fails below a folder; a file beside tells if it did."""
    faults, fired = Faults(), folder.with_name("fired")
    fired.write_text("1")  # which stays where the process dies of it
    faults.root(folder)
    faults.set(turn=turn, errno=fault.error, manner=MANNERS[fault.manner], sticky=fault.sticky, seen=0, fired=0)
    faults.set(kind=1 + KINDS.index(fault.kind))
    try:
        yield
    finally:
        faults.set(kind=0)
        fired.write_text(str(faults.get("fired")))


def prepare(folder: Path) -> None:
    """A store with a packed record and two files; `run` lacks a fourth."""
    for arguments in ([*RUN[:-1], "0"], ["pack"], [*RUN[:-1], "1-2"]):
        calmly([*arguments, "--results", str(folder)])


def judge(ended: Ended, before: dict[str, bytes], folder: Path, arguments: list[str], calm: Any) -> str:
    """Whether the fault was told or harmless. Raises AssertionError unless

    what was finished is there as it was; all that reads as a record is whole; a command that did not do all ends with
    an exit code that is not 0 and a line that says why, and no traceback; and the same command, when the fault is over,
    ends as an undisturbed one.
    """
    lost = lost_records(before, finished_records(folder))
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


def turns(name: str, fault: Fault, template: Path, folder: Path) -> Iterator[tuple[Ended, list[str]]]:
    """The command with the fault at its first operation, its second, and so on, as long as there is one."""
    for turn in range(1000):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(template, folder)
        arguments = COMMANDS[name](folder)
        ended = call(arguments, partial(faulty, folder, fault, turn))
        if folder.with_name("fired").read_text() == "0":
            return
        yield ended, arguments


def campaign(place: Path, every: int = 1) -> dict[str, Any]:
    """All commands with every fault, or each `every`th of the list: what came of them, and what must not."""
    outcomes, wrong = Counter(), []
    template = place / "template"
    prepare(template)
    for number, name in enumerate(COMMANDS):
        shutil.copytree(template, place / f"calm-{name}")
        calmly(COMMANDS[name](place / f"calm-{name}"))
        calm, before = steady_records(place / f"calm-{name}"), finished_records(template)
        for fault in FAULTS[number % every :: every]:
            for turn, (ended, arguments) in enumerate(turns(name, fault, template, place / "store")):
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
