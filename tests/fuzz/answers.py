"""Kinds of input whose right answer is known: tables, simulators, methods, stores from elsewhere."""

import gzip
import os
import random
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import torch
from dirty import LOST, WAYS, Speechless
from hypothesis import strategies as st
from numpy.typing import NDArray
from steady import without_clocks
from written_tables import FORMS, VALUES, written

import avobench
from avobench.bench.cells.trial import execute
from avobench.bench.events import read_events
from avobench.bench.store.packed import read_rows
from avobench.bench.store.store import NAMES, Store
from avobench.bench.sweep.plan import plan
from avobench.tasks.errors import AvobenchError, UsageError
from fuzz.targets import REFERENCE, Target, ended, refused

TRUTH = 0.6
"""The location of the events that are fitted."""
BUDGET = 20_000
FAR = 6.0
"""Standard errors that two fits of the same events may lie apart: a sound one does so in 1 of 10^8."""


class WrittenTables(Target):
    """Text files by a grammar, most with a cell or a row that is wrong: read rightly or refused, never otherwise."""

    name = "written tables"

    def inputs(self) -> st.SearchStrategy:
        rows = st.integers(2, 3).flatmap(lambda d: st.lists(st.tuples(*[VALUES] * d), min_size=3, max_size=6))
        faults = st.sampled_from(["", "longer", "shorter", "word", "thousands", "two points", "unit", "other sign"])
        return st.tuples(rows, FORMS, faults, st.integers(1, 2), st.integers(0, 1))

    def given(self, made: tuple) -> bool:
        rows, form, fault, row, column = made
        cells = [list(map(str, each)) for each in rows]
        wrong = {"word": "broken", "two points": "1.2.3", "unit": "1.5 keV", "other sign": "1.5-"}
        if fault in wrong:
            cells[row][column] = wrong[fault]
        elif fault == "thousands":
            cells[row][column] = "1,234.5"
        elif fault == "longer":
            cells[row].append("7")
        elif fault == "shorter":
            cells[row].pop()
        text, numbers = written([tuple(each) for each in cells], form)
        path = self.folder / ("x.csv.gz" if form["gz"] else "x.csv")
        path.write_bytes(gzip.compress(text.encode()) if form["gz"] else text.encode())
        try:
            x = read_events(str(path))
        except UsageError as error:
            if not fault:
                raise AssertionError(f"a sound table was refused: {error}") from error
            said = f"line {numbers[row]} has {len(cells[row])} cells"
            if fault in ("longer", "shorter") and form["header"] and not form["trailing"] and said not in str(error):
                raise AssertionError(f"{said}, and is not told: {error}") from error
            return refused(error)
        finally:
            path.unlink()
        right = np.array(rows)
        if fault == "thousands":
            right[row, column] = 1234.5
        assert not fault or fault == "thousands", f"a table with a fault was taken: {fault}"
        np.testing.assert_array_equal(x, right)
        assert not form["header"] or list(x.columns) == list("abc")[: right.shape[1]]
        return True


def located(theta: NDArray, rng: np.random.Generator) -> NDArray:
    return theta + rng.normal(size=(len(theta), 1))


def fitted(task: avobench.Task, x: NDArray, seed: int = 0) -> tuple[float, float, int]:
    """The location that is found, its standard error, and the simulated events."""
    found = avobench.infer(task, x, "smm", budget=BUDGET, seed=seed)
    return found.theta["location"], found.std["location"], found.num_simulations


def _raise(error: BaseException) -> Any:
    raise error


BREACHES = {
    "none": lambda x, theta, rng: x,
    "flat": lambda x, theta, rng: x[:, 0],
    "wider": lambda x, theta, rng: np.hstack([x, x]),
    "fewer": lambda x, theta, rng: x[:-1],
    "one": lambda x, theta, rng: x[:1],
    "scalar": lambda x, theta, rng: float(x[0, 0]),
    "nothing": lambda x, theta, rng: None,
    "list": lambda x, theta, rng: x.tolist(),
    "texts": lambda x, theta, rng: x.astype(str),
    "objects": lambda x, theta, rng: x.astype(object),
    "complex": lambda x, theta, rng: x + 1j,
    "truth values": lambda x, theta, rng: x > 0,
    "single": lambda x, theta, rng: x.astype(np.float32),
    "wide floats": lambda x, theta, rng: x.astype(np.longdouble),
    "masked": lambda x, theta, rng: np.ma.array(x, mask=x > 1),
    "nan": lambda x, theta, rng: np.where(np.arange(len(x))[:, None] % 2, x, np.nan),
    "infinite": lambda x, theta, rng: x / 0.0,
    "huge": lambda x, theta, rng: x * 1e308,
    "constant": lambda x, theta, rng: np.ones_like(x),
    "first row": lambda x, theta, rng: located(np.broadcast_to(theta[:1], theta.shape), rng),
    "no theta": lambda x, theta, rng: rng.normal(size=x.shape),
    "own seed": lambda x, theta, rng: located(theta, np.random.default_rng(1)),
    "own entropy": lambda x, theta, rng: located(theta, np.random.default_rng()),
    "shuffled": lambda x, theta, rng: x[::-1],
    "read-only": lambda x, theta, rng: np.broadcast_to(x, x.shape),
    "every other": lambda x, theta, rng: np.repeat(x, 2, axis=0)[::2],
    "changes theta": lambda x, theta, rng: (theta.fill(9), x)[1],
    "returns theta": lambda x, theta, rng: theta,
    "raises": lambda x, theta, rng: _raise(RuntimeError("on fire")),
    "speechless": lambda x, theta, rng: _raise(Speechless()),
    "leaves": lambda x, theta, rng: _raise(SystemExit(0)),
    "stops": lambda x, theta, rng: _raise(StopIteration()),
}
"""What a simulator returns in place of sound events, or does beside making them."""
SILENT = ("constant", "first row", "no theta", "own seed", "returns theta", "shuffled")
"""Ways whose events are sound one by one. They are looked for at the first calls alone, so none begins later here."""


class Simulators(Target):
    """Simulators that break the contract from some call on: refused, or the answer is that of a sound one.

    The events that a fit says it took are those that a counter in the simulator saw.
    """

    name = "simulators"

    def prepare(self) -> None:
        self.x = np.random.default_rng(0).normal(TRUTH, 1, (4000, 1))
        self.value, self.error, _ = fitted(avobench.task(located, prior={"location": (-1, 1)}, name="sound"), self.x)

    def inputs(self) -> st.SearchStrategy:
        return st.tuples(st.sampled_from(sorted(BREACHES)), st.integers(0, 6), st.integers(0, 9))

    def given(self, made: tuple) -> bool:
        how, sound, seed = made
        sound *= how not in SILENT
        calls = 0
        rows = 0

        def simulate(theta: NDArray, rng: np.random.Generator) -> Any:
            nonlocal calls, rows
            calls, rows = calls + 1, rows + len(theta)
            x = located(theta, rng)
            return x if calls <= sound else BREACHES[how](x, theta, rng)

        try:
            task = avobench.task(simulate, prior={"location": (-1, 1)}, name="odd")
            rows = 0
            value, error, used = fitted(task, self.x, seed)
        except AvobenchError as error:
            if how == "none" or rows > BUDGET:
                raise AssertionError(f"refused after {rows} of {BUDGET} events: {error}") from error
            return refused(error)
        assert used == rows <= BUDGET, f"{used} events are told, {rows} were made"
        assert abs(value - self.value) < FAR * np.hypot(error, self.error), (how, value, error, self.value)
        return True


def process_state() -> tuple[Any, ...]:
    """All that a cell may change of its process."""
    return (
        *(torch.get_default_dtype(), torch.is_grad_enabled(), torch.get_default_device(), torch.get_rng_state().sum()),
        *(np.geterr(), np.random.get_state()[1].tolist(), random.getstate(), len(warnings.filters)),
        *(dict(os.environ), os.getcwd()),
    )


class Methods(Target):
    """Methods that do several dirty things: each costs its own cell at most, and the next is as it would be alone."""

    name = "dirty methods"

    def prepare(self) -> None:
        self.alone = self.numbers(execute(self.cell("toys:Moment")))

    def cell(self, method: str, *settings: str) -> Any:
        return plan(["toys:Normal"], [method], "0", 1, 400, 100, 0, list(settings))[0]

    def numbers(self, record: dict[str, Any]) -> dict[str, Any]:
        return without_clocks({name: value for name, value in record.items() if name != "versions"})

    def inputs(self) -> st.SearchStrategy:
        return st.lists(st.sampled_from(sorted(WAYS)), min_size=1, max_size=4)

    def given(self, made: list[str]) -> bool:
        before = process_state()
        record = execute(self.cell("dirty:Dirty", f"dirty.how={'+'.join(made)}"))
        assert process_state() == before
        assert self.numbers(execute(self.cell("toys:Moment"))) == self.alone
        store = Store(self.folder / "store", create=True)
        store.write(record)
        assert store.read() == ([record], {})
        code, said = ended(["status", "--results", "store"])
        assert code == 0, said
        shutil.rmtree(store.path)
        assert (record["theta_hat"] is None) == bool(set(made) & set(LOST)), record
        return record["theta_hat"] is not None


RUN = "run --task toys:Normal --method toys:Moment --targets 0 --budget 400 --observations 100 --in-process"


class Stores(Target):
    """Results folders from elsewhere, in which any name may be a link or a pipe: nothing behind a link is touched."""

    name = "linked stores"

    def prepare(self) -> None:
        self.rows = list(read_rows(REFERENCE / "records.parquet"))[:3]
        self.home = self.folder / "home"

    def inputs(self) -> st.SearchStrategy:
        kinds = st.sampled_from(["file", "folder", "dangling", "itself", "pipe", "device"])
        places = (*NAMES, *(f"records/{row.file}" for row in self.rows), "running/mark", "damaged/x.json")
        places += ("records/.x.tmp",)
        command = st.sampled_from(["status", "pack", "export --format csv --out t.csv", RUN])
        return st.tuples(st.dictionaries(st.sampled_from(places), kinds, max_size=4), command)

    def given(self, made: tuple[dict[str, str], str]) -> bool:
        odd, command = made
        store = self.folder / "store"
        for folder in (store, self.home):
            shutil.rmtree(folder, ignore_errors=True)
        made_store = Store(store, create=True)
        for row in self.rows:
            made_store.records.mkdir(exist_ok=True)
            (made_store.records / row.file).write_text(row.text)
        self.home.mkdir()
        (self.home / "thesis.json").write_bytes((store / "store.json").read_bytes())
        for name, kind in odd.items():
            self._place(store / name, kind)
        before = self._state()
        arguments = [*command.split(), "--results", "store"]
        code, said = ended(arguments)
        assert self._state() == before, "what lies behind a link was changed"
        ours = {name for name in odd if name in NAMES}
        assert code or not ours, f"{ours} was taken: {said}"
        return code == 0

    def _place(self, path: Path, kind: str) -> None:
        if not path.parent.is_dir() or path.parent.is_symlink():
            if path.parent.exists() or path.parent.is_symlink():
                return
            path.parent.mkdir()
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        path.unlink(missing_ok=True)
        if kind == "pipe":
            os.mkfifo(path)
        else:
            target = {"file": self.home / "thesis.json", "folder": self.home, "dangling": self.home / "new"}
            path.symlink_to(target.get(kind, Path("/dev/zero") if kind == "device" else path))

    def _state(self) -> dict[str, bytes]:
        return {str(path): path.read_bytes() if path.is_file() else b"" for path in self.home.rglob("*")}


KINDS = (WrittenTables, Simulators, Methods, Stores)
