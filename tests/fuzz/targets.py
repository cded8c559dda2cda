"""What each kind of hostile input is given to: `Target.check` says "taken" or "refused", or raises AssertionError."""

import contextlib
import io
import json
import os
import shutil
import signal
import sys
import tempfile
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from avobench.bench.events import read_events
from avobench.bench.plugins import registry
from avobench.bench.store.packed import Row, read_rows, write_rows
from avobench.bench.store.store import Store
from avobench.cli import main as cli
from avobench.effects.catalogue import catalogue
from avobench.tasks.errors import AvobenchError, UsageError
from fuzz import inputs
from fuzz.guard import Guard, plant

REFERENCE = Path(__file__).parents[2] / "results" / "reference"
PATIENCE = 300
"""Seconds that any input may take: a page of figures takes a minute on a loaded machine."""
GUARD = Guard()


def ended(arguments: list[str]) -> tuple[int, str]:
    """Exit code of the command line and its last words. Raises AssertionError for a traceback or a fault."""
    out, err, before = io.StringIO(), io.StringIO(), sys.argv
    sys.argv, code = ["avobench", *arguments], 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            cli.main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        sys.argv = before
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    said = err.getvalue()
    assert "Traceback" not in said, said
    assert "a fault of avobench" not in said, said
    assert code in (0, 1, 2), (code, said)
    if code:
        told = [line for line in said.splitlines() if line.startswith("avobench: ")]
        assert told or out.getvalue(), f"exit code {code} without a word"
    return code, said


def refused(error: AvobenchError) -> bool:
    """False, once it is seen that the refusal has a reason."""
    assert str(error).strip(), "refused without a word"
    return False


class Target(ABC):
    """A kind of input. The current folder is an empty one with `planted.py`, which nothing may run."""

    name: str

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.prepare()

    def prepare(self) -> None:  # noqa: B027
        """Make what all examples share."""

    @abstractmethod
    def inputs(self) -> st.SearchStrategy: ...

    @abstractmethod
    def given(self, made: Any) -> bool:
        """Whether the input was taken. Raises AssertionError when it should not have been, or was refused badly."""

    def check(self, made: Any) -> str:
        with self._alone(), warnings.catch_warnings(), GUARD.watching(self.folder):
            warnings.simplefilter("ignore")  # NumPy's and Pandas' about what they are given
            try:
                return "taken" if self.given(made) else "refused"
            except SystemExit as error:  # else it would end the proof as if all were well
                raise AssertionError("the process was ended") from error

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """The block runs in the folder, with its modules first on the path, and not for ever."""
        before, modules = Path.cwd(), set(sys.modules)
        plant(self.folder)
        os.chdir(self.folder)
        sys.path.insert(0, "")
        signal.alarm(PATIENCE)
        try:
            yield
        finally:
            signal.alarm(0)
            sys.path.remove("")
            os.chdir(before)
            for name in set(sys.modules) - modules:
                if name.startswith("planted"):
                    del sys.modules[name]


class CommandLines(Target):
    """Lines of every command, in a folder with a few files that they may take; `-Q` and the like must be refused."""

    name = "command lines"

    def prepare(self) -> None:
        self.kept = {}
        np.save(self.folder / "x.npy", np.random.default_rng(0).poisson(7, (300, 1)))
        (self.folder / "model.json").write_text(json.dumps(Models(self.folder).document))
        store = Store(self.folder / "store", create=True)
        for record in Store(REFERENCE).read_all()[::60]:
            store.write(record)
        self.kept = {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}

    def inputs(self) -> st.SearchStrategy:
        commands = {}
        for name, command in ((name, cli.cli.get_command(None, name)) for name in cli.COMMANDS):
            inner = getattr(command, "commands", None)
            commands |= {name: command} if inner is None else {f"{name} {each}": inner[each] for each in inner}
        return inputs.command_lines(commands)

    def given(self, made: tuple[list[str], bool]) -> bool:
        line, wrong = made
        self._restore()
        before, tempfile.tempdir = tempfile.tempdir, str(self.folder)
        try:
            code, said = ended(["--in-process", *line])  # another process would be out of the guard's sight
        finally:
            tempfile.tempdir = before  # None would let the next input look for a folder, which the guard sees
        assert code or not wrong or {"-h", "--help", "--version"} & set(line), f"{line} was taken: {said}"
        return code == 0

    def _restore(self) -> None:
        for path in self.folder.iterdir():
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()
        for path, content in self.kept.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        plant(self.folder)


class Packed(Target):
    """Tables of records whose bytes were changed, and rows that lie about their names."""

    name = "packed tables"

    def prepare(self) -> None:
        store = Store(self.folder / "store", create=True)
        self.rows = list(read_rows(REFERENCE / "records.parquet"))[:60:5]
        write_rows(store.table, self.rows)
        self.content, self.records = store.table.read_bytes(), store.read()[0]

    def inputs(self) -> st.SearchStrategy:
        rows = st.builds(Row, inputs.nasty_texts, st.sampled_from([row.text for row in self.rows]) | inputs.nasty_texts)
        return inputs.mutated(self.content) | st.lists(rows, min_size=1, max_size=3)

    def given(self, made: bytes | list[Row]) -> bool:
        store = Store(self.folder / "store")
        if isinstance(made, bytes):
            store.table.write_bytes(made)
        else:
            write_rows(store.table, made)
        sound, damaged = store.read()
        assert all(record in self.records for record in sound)
        assert damaged or sound == self.records, "rows are missing without a word"
        code, said = ended(["status", "--results", "store"])
        assert bool(code) == bool(damaged), said
        return not damaged


class Manifests(Target):
    """The public part of a challenge, whose data sets are too small to be diagnosed."""

    name = "manifests"

    def prepare(self) -> None:
        document = {"schema": "avobench-challenge", "version": 1, "task": "weinberg", "num_events": 10}
        cases = [{"case": "0000", "effects": None}, {"case": "0001", "effects": ["resolution"]}]
        self.document = {**document, "cases": cases}
        self.place = self.folder / "c"

    def inputs(self) -> st.SearchStrategy:
        return inputs.changed(self.document)

    def given(self, made: Any) -> bool:
        shutil.rmtree(self.place, ignore_errors=True)
        (self.place / "data").mkdir(parents=True)
        for case in ("0000", "0001"):
            np.savez(self.place / "data" / f"{case}.npz", x=np.zeros((3, 1)))
        (self.place / "manifest.json").write_text(json.dumps(made))
        code, _ = ended(["challenge", "solve", "c"])
        ended(["challenge", "score", "c"])
        return code == 0


class Results(Target):
    """The results of a challenge, which hold what a diagnosis.json does, and its answers."""

    name = "diagnosis files"

    def prepare(self) -> None:
        lines = (REFERENCE.parent / "challenge" / "null-weinberg.jsonl").read_text().splitlines()
        self.head, self.row = json.loads(lines[0]), json.loads(lines[1])

    def inputs(self) -> st.SearchStrategy:
        return inputs.changed([self.head, self.row])

    def given(self, made: Any) -> bool:
        lines = made if isinstance(made, list) else [made]
        (self.folder / "r.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        return ended(["challenge", "score", "r.jsonl", "--format", "json"])[0] == 0


class Models(Target):
    """Models, each built and asked for a few events."""

    name = "models"

    def prepare(self) -> None:
        task = registry.build("task", "weinberg", {})
        effect = catalogue(task)[0]
        boxes = [*zip(task.parameter_names, task.prior.low, task.prior.high, strict=True)]
        boxes += [(parameter.name, parameter.low, parameter.high) for parameter in effect.parameters]
        parameters = [
            {"name": name, "unit": "1", "value": low, "std": 0.1, "prior": [low, high], "support": [low, high]}
            for name, low, high in boxes
        ]
        added = {"name": effect.name, "feature": effect.key[1], "shape": effect.shape, "source": None, "settings": {}}
        self.document = {"kind": "avobench-model", "schema_version": 1, "name": "weinberg-x", "task": "weinberg"}
        self.document |= {"task_settings": {}, "effects": [added], "parameters": parameters}
        assert self.given(self.document)

    def inputs(self) -> st.SearchStrategy:
        return inputs.changed(self.document)

    def given(self, made: Any) -> bool:
        path = self.folder / "model.json"
        path.write_text(json.dumps(made))
        try:
            task = registry.build("task", str(path), {})
        except AvobenchError as error:
            return refused(error)
        rng = np.random.default_rng(0)
        try:
            x = task.simulate(task.prior.sample(50, rng), rng)
        except (ValueError, AvobenchError):  # outside its support, which is told as the task's own fault
            return False
        assert x.shape == (50, task.num_features)
        store = Store(self.folder / "store", create=True)
        assert store.place({"task": task.name, "method": "avo", "target": 0, "repetition": 0, "id": "0"})
        return True


class Events(Target):
    """Files of measured events of one format."""

    def __init__(self, folder: Path, kind: str) -> None:
        self.kind, self.name = kind, f"events .{kind}"
        super().__init__(folder)

    def inputs(self) -> st.SearchStrategy:
        return inputs.events(self.kind, self.folder / "was-run")

    def given(self, made: bytes) -> bool:
        path = self.folder / f"x.{self.kind}"
        path.write_bytes(made)
        try:
            x = read_events(f"{path}:t" if self.kind == "root" else str(path))
        except UsageError as error:
            return refused(error)
        assert x.ndim == 2
        assert np.asarray(x).dtype.kind in "iuf"
        return True


KINDS = (CommandLines, Packed, Manifests, Results, Models)
