"""Kills at random moments, and into which phase of a command they fell.

A command is started on the same folder again and again, each time ended by SIGKILL, until it is finished; then the next
folder is begun. Half of the moments are drawn uniformly over the time that is left of an undisturbed run. The others
aim at one phase after another, since the short ones are rarely hit by chance. All processes of the command are stopped
just before the kill, and the phase is read from what lies in the folder then, so it is observed and not assumed.

After every kill, what had been finished must be there as it was, and all that reads as finished must be whole. At the
end, the results must be those of an undisturbed run, bit for bit, apart from what a clock or a meter says.
"""

import json
import os
import random
import shutil
import signal
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from avobench.bench.store.packed import read_rows
from avobench.bench.store.record import decode_record
from avobench.bench.store.store import Store
from robustness.warm import start

REFERENCE = Path(__file__).parents[2] / "results" / "reference"
TIMED = ("observation_seconds", "simulator_seconds", "method_seconds", "harness_seconds", "peak_memory_mib", "started")
CLOCKS = ("seconds", "cpu_seconds")
PATIENCE = 60.0
"""Seconds after which a command that should have come to a phase, or to its end, is a failure."""
GLANCE = 0.0005
"""Seconds between two looks at the folder while a phase is waited for; the shortest phases take a few milliseconds."""
Files = dict[str, bytes]


class Subject(ABC):
    """A command whose kills are tried, and how its folder is read."""

    name: str
    phases: tuple[str, ...]
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
    def phase(self, folder: Path, before: int) -> str:
        """The phase of the command, from what lies in the folder; `before` things were finished when it was started."""

    def results(self, folder: Path) -> Any:
        """What must be the same in the end, without clocks."""
        return self.finished(folder)


class Run(Subject):
    """`avobench run --jobs 2` of short cells."""

    name = "run --jobs 2"
    tidies = True
    phases = (
        "before the first cell",
        "within cells",
        "within the write of a record",
        "between cells",
        "after the last",
    )
    cells = 20

    def prepare(self, folder: Path) -> None:
        pass

    def arguments(self, folder: Path) -> list[str]:
        task = ["--task", "toys:Normal", "--method", "toys:Moment", "--budget", "400", "--observations", "100"]
        task += ["--targets", "0-4", "--repetitions", "4", "--set", "moment.pause=0.005"]
        return ["run", *task, "--jobs", "2", "--results", str(folder)]

    def finished(self, folder: Path) -> Files:
        found = {path.name: path.read_bytes() for path in folder.glob("records/[!.]*")}
        for content in found.values():
            decode_record(content)
        return found

    def phase(self, folder: Path, before: int) -> str:
        if any(folder.glob("records/.*.tmp")):
            return "within the write of a record"
        done = sum(1 for _ in folder.glob("records/[!.]*"))
        if done == self.cells:
            return "after the last"
        if any(folder.glob("running/[!.]*")):
            return "within cells"
        return "between cells" if done > before else "before the first cell"

    def results(self, folder: Path) -> Any:
        records, damaged = Store(folder).read()
        assert not damaged, damaged
        return [{name: value for name, value in record.items() if name not in TIMED} for record in records]


class Pack(Subject):
    """`avobench pack` of records with long traces."""

    name = "pack"
    tidies = True
    phases = ("before the table", "within the write of the table", "while files are removed", "after the last")

    def __init__(self) -> None:
        self._records = Store(REFERENCE).read_all()[::15]

    def prepare(self, folder: Path) -> None:
        store = Store(folder, create=True)
        for record in self._records:
            store.write(record)

    def arguments(self, folder: Path) -> list[str]:
        return ["pack", "--results", str(folder)]

    def finished(self, folder: Path) -> Files:
        found = {path.name: path.read_bytes() for path in folder.glob("records/[!.]*")}
        for row in read_rows(folder / "records.parquet"):
            assert found.setdefault(row.file, row.text.encode()) == row.text.encode()
        assert len(found) == len(self._records), f"{len(found)} of {len(self._records)} records"
        return found

    def phase(self, folder: Path, before: int) -> str:
        if any(folder.glob(".*.tmp")):
            return "within the write of the table"
        if not (folder / "records.parquet").exists():
            return "before the table"
        return "while files are removed" if any(folder.glob("records/*")) else "after the last"


class Solve(Subject):
    """`avobench challenge solve` of small data sets."""

    name = "challenge solve"
    phases = ("before the first case", "within cases", "within the write of a result", "after the last")
    cases = 2

    def __init__(self) -> None:
        self._made: Path | None = None

    def prepare(self, folder: Path) -> None:
        if self._made is None:
            self._made = folder.parent / "made"
            task = ["--task", "toys:Normal", "--cases", str(self.cases), "--events", "200", "--kinds", "none,own"]
            calmly(["challenge", "make", *task, "--out", str(self._made)], folder.parent / "log")
        shutil.copytree(self._made, folder)

    def arguments(self, folder: Path) -> list[str]:
        return ["challenge", "solve", str(folder), "--trust"]

    def finished(self, folder: Path) -> Files:
        found = {path.name: path.read_bytes() for path in folder.glob("results/[!.]*")}
        for name, content in found.items():
            assert "diagnosis" in json.loads(content), name
        return found

    def phase(self, folder: Path, before: int) -> str:
        if any(folder.glob("results/.*.tmp")):
            return "within the write of a result"
        done = sum(1 for _ in folder.glob("results/[!.]*"))
        if done == self.cases:
            return "after the last"
        return "within cases" if done > before or before else "before the first case"

    def results(self, folder: Path) -> Any:
        return {name: _without_clocks(json.loads(content)) for name, content in self.finished(folder).items()}


class Diagnose(Subject):
    """`avobench diagnose`, which writes all at its end: it is whole if diagnosis.json, written last, is there."""

    name = "diagnose"
    phases = ("before the first file", "within the write of a file", "between files", "after the last")
    written = ("diagnosis.json", "model.json")

    def prepare(self, folder: Path) -> None:
        folder.mkdir()
        np.savez(folder / "events.npz", x=np.random.default_rng(0).normal(0.3, 1, (200, 1)))

    def arguments(self, folder: Path) -> list[str]:
        return ["diagnose", "--task", "toys:Normal", "--data", str(folder / "events.npz"), "--out", str(folder / "out")]

    def finished(self, folder: Path) -> Files:
        out = folder / "out"
        for path in out.glob("[!.]*.json"):
            json.loads(path.read_bytes())
        if not (out / "diagnosis.json").exists():
            return {}
        missing = [name for name in ("model.json", "report.html", "gap.png", "theta.png") if not (out / name).exists()]
        assert not missing, missing
        return {}  # the same command makes them anew, and diagnosis.json goes first

    def phase(self, folder: Path, before: int) -> str:
        out = folder / "out"
        if any(out.glob(".*.tmp")):
            return "within the write of a file"
        if (out / "diagnosis.json").exists():
            return "after the last"
        return "between files" if any(out.glob("[!.]*")) else "before the first file"

    def results(self, folder: Path) -> Any:
        found = {path.name: path.read_text() for path in (folder / "out").glob("*.csv")}
        documents = {name: json.loads((folder / "out" / name).read_text()) for name in self.written}
        return found | {name: _without_clocks(document) for name, document in documents.items()}


SUBJECTS: dict[str, Callable[[], Subject]] = {"run": Run, "pack": Pack, "solve": Solve, "diagnose": Diagnose}


def _without_clocks(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_clocks(inner) for name, inner in value.items() if name not in CLOCKS}
    return [_without_clocks(inner) for inner in value] if isinstance(value, list) else value


def difference(found: Any, expected: Any) -> str:
    """The first place in which the results are not those of an undisturbed run."""
    for name in found if isinstance(found, dict) else range(min(len(found), len(expected))):
        if name not in expected if isinstance(expected, dict) else False:
            return f"{name} is too many"
        if found[name] != expected[name]:
            return f"{name} is {str(found[name])[:2000]}, undisturbed {str(expected[name])[:2000]}"
    return f"{len(found)} results, undisturbed {len(expected)}"


def calmly(arguments: list[str], log: Path) -> float:
    """Let a command end by itself, and well; the seconds that it took."""
    begun = time.monotonic()
    process = start(arguments, log)
    process.join(PATIENCE)
    _group(process.pid, signal.SIGKILL)  # workers that wait for more
    assert process.exitcode == 0, f"exit code {process.exitcode}: {log.read_text()[-2000:]}"
    return time.monotonic() - begun


def _group(process_group: int, number: int) -> None:
    """Send a signal to what is left of a command, which has only just been there: numbers are used again later."""
    with suppress(ProcessLookupError):
        os.killpg(process_group, number)


class Campaign:
    """The kills of one command, and where they fell."""

    def __init__(self, subject: Subject, folder: Path, seed: int) -> None:
        self.subject, self.folder, self.moments = subject, folder, random.Random(seed)
        self.drawn: Counter[str] = Counter()
        self.aimed: Counter[str] = Counter()
        self.length = 0.0
        self.folders = 0
        self.ended = 0
        """Commands that were finished before the moment came."""

    def go(self, kills: int) -> None:
        """Kill so often. Raises AssertionError for the first thing that is lost, halved, or not as in a calm run."""
        self.folder.mkdir(parents=True)
        calmly(["list"], self.folder / "log")  # loads everything, so that what is measured next is the command alone
        calm = self.folder / "calm"
        self.subject.prepare(calm)
        self.length = calmly(self.subject.arguments(calm), self.folder / "log")
        self.expected = self.subject.results(calm)
        aims = self._aims()
        while self.total < kills:
            self._one_folder(self.folder / str(self.folders), kills, aims)
            shutil.rmtree(self.folder / str(self.folders))
            self.folders += 1

    @property
    def total(self) -> int:
        return self.drawn.total() + self.aimed.total()

    def _aims(self) -> Iterator[str | None]:
        while True:
            for phase in self.subject.phases[1:-1]:  # the first and the last are hit by chance often enough
                yield None
                yield phase

    def _one_folder(self, folder: Path, kills: int, aims: Iterator[str | None]) -> None:
        self.subject.prepare(folder)
        seen = self.subject.finished(folder)
        left = self.length
        while self.total < kills:
            killed, took = self._one(folder, next(aims), left, len(seen))
            found = self.subject.finished(folder)
            lost = [name for name, content in seen.items() if found.get(name) != content]
            assert not lost, f"{self.subject.name}: lost or changed by a kill: {lost}"
            if not killed:
                break
            left = max(self.length / 4, left - took / 2)
            seen = found
        else:
            calmly(self.subject.arguments(folder), self.folder / "log")
        found = self.subject.results(folder)
        assert found == self.expected, f"{self.subject.name}: {difference(found, self.expected)}"
        assert not (self.subject.tidies and list(folder.glob("**/.*.tmp"))), "temporary files are left"

    def _one(self, folder: Path, aim: str | None, left: float, before: int) -> tuple[bool, float]:
        """Start, and kill, unless it ends before: whether it was killed, and how long it ran."""
        begun = time.monotonic()
        process = start(self.subject.arguments(folder), self.folder / "log")
        moment = begun + self.moments.uniform(0, left)
        while process.exitcode is None:
            now = time.monotonic()
            if aim is None and now >= moment:
                break
            if aim is not None and self.subject.phase(folder, before) == aim:
                break
            if now - begun > PATIENCE:
                raise AssertionError(f"{self.subject.name}: not finished after {PATIENCE:.0f} s")
            process.join(min(0.5, moment - now) if aim is None else GLANCE)
        took = time.monotonic() - begun
        _group(process.pid, signal.SIGSTOP)
        if process.exitcode is not None:
            _group(process.pid, signal.SIGKILL)
            assert process.exitcode == 0, f"exit code {process.exitcode}: {(self.folder / 'log').read_text()[-2000:]}"
            self.ended += 1
            return False, took
        phase = self.subject.phase(folder, before)
        if self.moments.random() < 0.5:
            process.kill()  # the command alone, as an impatient user does: its workers are to end by themselves
            _group(process.pid, signal.SIGCONT)
            time.sleep(self.moments.uniform(0, 0.2))  # the next start may come while they end
            _group(process.pid, signal.SIGKILL)  # a fork that waits for work has no way to notice
        else:
            _group(process.pid, signal.SIGKILL)  # all at once, as when the machine goes down
            process.kill()
        process.join(PATIENCE)
        (self.drawn if aim is None else self.aimed)[phase] += 1
        return True, took

    def report(self) -> str:
        lines = [f"{self.subject.name}: {self.total} kills in {self.folders} folders, a calm run {self.length:.2f} s"]
        for phase in self.subject.phases:
            drawn, aimed = self.drawn[phase], self.aimed[phase]
            lines.append(f"  {phase:32}{drawn + aimed:5}   {drawn:4} at drawn moments, {aimed:4} aimed at a phase")
        lines.append("  nothing lost, nothing halved, every end as the calm run's")
        return "\n".join(lines)
