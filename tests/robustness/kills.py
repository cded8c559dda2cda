"""Kills before each operation on files that a command does below its folder.

Between two of these operations the folder stays as it is, so that a kill at any other moment leaves the same; a write
of which half was done is among the faults of the file system. By turns the command alone is killed, as an impatient
user does, so that its workers end by themselves while the next command runs; and all of its processes at once, as when
the machine goes down.

What had been finished must be there afterwards as it was, and all that reads as finished must be whole. The same
command is then given again, and must end as an undisturbed one, bit for bit, apart from what a clock or a meter says.
"""

import itertools
import json
import os
import shutil
import signal
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from steady import without_clocks

from avobench.bench.store.packed import read_rows
from avobench.bench.store.record import decode_record
from avobench.bench.store.store import Store
from robustness.warm import SWEEP, call, calmly

REFERENCE = Path(__file__).parents[2] / "results" / "reference"
OPERATIONS = ("open", "tempfile.mkstemp", "os.chmod", "os.mkdir", "os.rename", "os.remove", "os.rmdir")
"""What Python tells an audit hook just before it does it."""
Files = dict[str, bytes]


def finished_records(folder: Path) -> Files:
    """Every record that reads as finished, by name; raises ValueError for a half one."""
    found = {row.file: row.text.encode() for row in read_rows(folder / "records.parquet")}
    found |= {path.name: path.read_bytes() for path in folder.glob("records/[!.]*")}
    for content in found.values():
        decode_record(content)
    return found


def lost_records(before: Files, after: Files) -> list[str]:
    """The names of those that are gone or have another content."""
    return [name for name, content in before.items() if after.get(name) != content]


def steady_records(folder: Path) -> list[dict[str, Any]]:
    """The records without what a clock or a meter says. Raises AssertionError for a damaged one."""
    records, damaged = Store(folder).read()
    assert not damaged, damaged
    return without_clocks(records)


class Subject(ABC):
    """A command whose kills are tried, and how its folder is read."""

    tidies = False
    """Whether the next start removes the temporary files that a kill leaves."""

    @abstractmethod
    def prepare(self, folder: Path) -> None:
        """Make what the command needs in a new folder."""

    @abstractmethod
    def arguments(self, folder: Path) -> list[str]: ...

    @abstractmethod
    def finished(self, folder: Path) -> Files:
        """What reads as finished, by name; raises AssertionError or ValueError for what is not whole."""

    @abstractmethod
    def results(self, folder: Path) -> Any:
        """What must be the same in the end, without clocks."""


class Run(Subject):
    """`avobench run --jobs 2` of four short cells, of which one is finished."""

    tidies = True

    def prepare(self, folder: Path) -> None:
        calmly([*self.arguments(folder), "--targets", "0"])

    def arguments(self, folder: Path) -> list[str]:
        return [*SWEEP, "--targets", "0-3", "--jobs", "2", "--results", str(folder)]

    finished = staticmethod(finished_records)
    results = staticmethod(steady_records)


class Pack(Run):
    """`avobench pack` of records with long traces."""

    def prepare(self, folder: Path) -> None:
        store = Store(folder, create=True)
        for record in Store(REFERENCE).read_all()[::30]:
            store.write(record)

    def arguments(self, folder: Path) -> list[str]:
        return ["pack", "--results", str(folder)]


class Solve(Subject):
    """`avobench challenge solve` of two small data sets."""

    def prepare(self, folder: Path) -> None:
        task = ["--task", "toys:Normal", "--cases", "2", "--events", "200", "--kinds", "none,own"]
        calmly(["challenge", "make", *task, "--out", str(folder)])

    def arguments(self, folder: Path) -> list[str]:
        return ["challenge", "solve", str(folder), "--trust"]

    def finished(self, folder: Path) -> Files:
        found = {path.name: path.read_bytes() for path in folder.glob("results/[!.]*")}
        assert all("diagnosis" in json.loads(content) for content in found.values())
        return found

    def results(self, folder: Path) -> Any:
        return {name: without_clocks(json.loads(content)) for name, content in self.finished(folder).items()}


class Diagnose(Subject):
    """`avobench diagnose`, which writes all at its end: it is whole if diagnosis.json, written last, is there."""

    def prepare(self, folder: Path) -> None:
        folder.mkdir()
        np.savez(folder / "events.npz", x=np.random.default_rng(0).normal(0.3, 1, (200, 1)))

    def arguments(self, folder: Path) -> list[str]:
        data, out = folder / "events.npz", folder / "out"
        return ["--in-process", "diagnose", "--task", "toys:Normal", "--data", str(data), "--out", str(out)]

    def finished(self, folder: Path) -> Files:
        names = {path.name for path in folder.glob("out/[!.]*")}
        if "diagnosis.json" in names:
            assert {"model.json", "report.html", "theta.png"} <= names
        return {}  # the same command makes them anew, and diagnosis.json goes first

    def results(self, folder: Path) -> Any:
        documents = {path.name: json.loads(path.read_text()) for path in folder.glob("out/*.json")}
        return without_clocks(documents) | {path.name: path.read_text() for path in folder.glob("out/*.csv")}


SUBJECTS = {"run": Run, "pack": Pack, "challenge solve": Solve, "diagnose": Diagnose}


@contextmanager
def killed_before(folder: Path, number: int) -> Iterator[None]:
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
    yield


def campaign(name: str, place: Path, every: int = 1) -> int:
    """How many operations `name` does, killed before one in `every`. Raises AssertionError for what went wrong."""
    subject, template = SUBJECTS[name](), place / "template"
    place.mkdir(parents=True)
    subject.prepare(template)
    calm = Path(shutil.copytree(template, place / "calm"))
    calmly(subject.arguments(calm))
    expected = subject.results(calm)
    for number in itertools.count(every // 2, every):
        folder = Path(shutil.copytree(template, place / str(number)))
        ended = call(subject.arguments(folder), partial(killed_before, folder, number))
        if ended.code == 0:
            return number
        assert ended.code == -signal.SIGKILL, ended.err[-2000:]
        killed = subject.finished(folder)
        calmly(subject.arguments(folder))
        for kept, later in ((subject.finished(template), killed), (killed, subject.finished(folder))):
            lost = lost_records(kept, later)
            assert not lost, f"{name}, killed before operation {number}: lost or changed {lost}"
        assert subject.results(folder) == expected, f"{name}, killed before operation {number}: not as undisturbed"
        assert not (subject.tidies and list(folder.glob("**/.*.tmp"))), "temporary files are left"
        shutil.rmtree(folder)
    raise AssertionError("there is no end")
