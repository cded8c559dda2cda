"""A bank of simulated events that is kept in a folder, so that a later question costs nothing."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from avobench.bench.plugins.registry import made_of, settings_of
from avobench.bench.plugins.source import fingerprint, source_hash
from avobench.bench.store.files import locked, not_plain, require_folder, write_file
from avobench.effects.bank import Bank
from avobench.tasks import Task
from avobench.tasks.errors import UsageError
from avobench.tasks.meter import Meter
from avobench.tasks.region import recall, regions

SCHEMA = "avobench-bank"
"""The kind that bank.json gives of its folder."""
VERSION = 1
"""Of the format of the folder."""
WORKED = "worked.json"
"""The file that says, of simulators that fail at some parameters, at which of those that were tried they worked."""
EVENTS, ASIDE = "events", "aside"
"""What files of events are called, and those of events that are kept aside."""
MERGED = 64
"""So many files of one kind become one: a method that asks for each theta apart would write thousands."""
NODE = "node of "
"""The columns of a node's coordinates begin with this; those of theta and of the features have their own names."""


class KeptBank(Bank):
    """A bank whose events are also Parquet files of a folder: one for each time that events were made, or several.

    Events of the folder are handed out before any is simulated, and are not counted by the meter. A file is written
    whole before its events are used, so what ends the process loses what was being simulated and no more. A file is
    named by the number of its time, or by the first and the last of those that it was merged from. One process at a
    time may use a folder: the events of two would take each other's place, and be made by the same random numbers.
    """

    def __init__(self, task: Task, meter: Meter, seed: int, jobs: int, folder: Path) -> None:
        """Raises UsageError where the folder cannot be used, or holds events of another simulator."""
        require_folder(folder)
        self.folder, self.task = folder, task
        taken = f"another process simulates into {folder}; wait for it, or choose another folder"
        self._lock = locked(folder, taken, thread_local=False, is_singleton=True)
        self._claim()
        self._recall()
        super().__init__(task, meter, seed, jobs)
        if learnt_regions := regions(task):
            contents = [region.learnt for region in learnt_regions]
            write_file(folder / WORKED, (json.dumps(contents) + "\n").encode())
        self._single: dict[str, list[Path]] = {EVENTS: [], ASIDE: []}
        """The files that were not merged yet."""
        for kind, single in self._single.items():
            files = sorted(folder.glob(f"{kind}-*.parquet"))
            merged = [_numbers(path) for path in files if len(set(_numbers(path))) > 1]
            for path in files:
                first, last = _numbers(path)
                if first == last and any(a <= first <= b for a, b in merged):
                    path.unlink()  # what merged it was ended before this
                    continue
                self._read(path, kind == ASIDE)
                single += [path] if first == last else []
        self.fills = self._next()

    def _next(self) -> int:
        """The number of the next file: where a damaged one was deleted there are fewer than their numbers say."""
        return max((_numbers(path)[1] + 1 for path in self.folder.glob("*-*.parquet")), default=0)

    def _claim(self) -> None:
        """Write whose events the folder holds, or raise UsageError if they are another simulator's."""
        path, ours = self.folder / "bank.json", _identity(self.task)
        if why := not_plain(path):
            raise UsageError(f"{path} {why}")
        if not path.exists():
            if any(self.folder.glob(f"{EVENTS}-*.parquet")):
                raise UsageError(f"{self.folder} has events, but no bank.json that says of which simulator")
            write_file(path, (json.dumps(ours, indent=1) + "\n").encode())
            return
        try:
            theirs = json.loads(path.read_text())
        except (ValueError, RecursionError) as error:
            raise UsageError(f"{path} is damaged: {error}") from error
        if theirs != ours:
            differ = [name for name in ours if not isinstance(theirs, dict) or theirs.get(name) != ours[name]]
            raise UsageError(
                f"{self.folder} holds events of another simulator than {self.task.name} as it is now (its "
                f"{', '.join(differ) or 'bank.json'} differs); choose another folder"
            )

    def _recall(self) -> None:
        """Tell the task where its simulators worked when this was learnt. Raises UsageError."""
        path = self.folder / WORKED
        if not path.exists():
            return
        try:
            recall(self.task, json.loads(path.read_text()))
        except (KeyError, TypeError, ValueError, RecursionError) as error:
            raise UsageError(f"{path} is damaged ({error}); delete it, and that is learnt again") from error

    def _columns(self) -> tuple[list[str], list[str], list[str]]:
        names = list(self.task.parameter_names)
        return [NODE + name for name in names], names, [f"event: {label}" for label in self.task.labels]

    def _read(self, path: Path, aside: bool) -> None:
        nodes, _, features = self._columns()
        try:
            if why := not_plain(path):
                raise ValueError(f"it {why}")
            table = pd.read_parquet(path, columns=[*nodes, *features])
            x = table[features].to_numpy(self.task.dtype)
            at = table[nodes].to_numpy(np.int64)
        except Exception as error:  # a damaged file may raise anything
            raise UsageError(
                f"{path} cannot be read ({error}); delete it, and its events are simulated again"
            ) from error
        self.add(at, x, aside)

    def _make(self, rows: NDArray[np.int64], aside: bool) -> None:
        if len(rows) and self._next() != self.fills:
            raise UsageError(f"{self.folder} was filled or emptied since it was read; ask again")
        super()._make(rows, aside)

    def _keep(self, nodes: NDArray[np.int64], theta: NDArray[np.float64], x: NDArray, aside: bool) -> None:
        columns, names, features = self._columns()
        if (region := getattr(self.task, "region", None)) is not None:
            theta = region.within(theta)  # where its events were made
        table = pd.DataFrame(dict(zip(columns, nodes.T, strict=True)) | dict(zip(names, theta.T, strict=True)))
        table = pd.concat([table, pd.DataFrame(x, columns=features)], axis=1)
        kind = ASIDE if aside else EVENTS
        path = self.folder / f"{kind}-{self.fills:06d}.parquet"
        write_file(path, table.to_parquet(index=False))
        super()._keep(nodes, theta, x, aside)
        self._single[kind].append(path)
        if len(single := self._single[kind]) >= MERGED:
            whole = self.folder / f"{kind}-{_numbers(single[0])[0]:06d}-{_numbers(single[-1])[1]:06d}.parquet"
            write_file(whole, pd.concat([pd.read_parquet(each) for each in single]).to_parquet(index=False))
            for each in single:
                each.unlink()
            self._single[kind] = []


def _numbers(path: Path) -> tuple[int, int]:
    """The first and the last time that the events of a file were simulated. Raises UsageError for other names."""
    try:
        numbers = [int(number) for number in path.stem.split("-")[1:]]
    except ValueError as error:
        raise UsageError(f"{path} is none of the files of this folder: move it elsewhere") from error
    return numbers[0], numbers[-1]


def _identity(task: Task) -> dict[str, Any]:
    """All that decides which events a task makes. Raises UsageError where its source cannot be read."""
    try:
        source = source_hash(made_of(task))
    except (OSError, TypeError) as error:
        raise UsageError(f"a bank can only be kept of a task whose source is in a file ({error})") from error
    identity = {
        "schema": SCHEMA,
        "version": VERSION,
        "task": task.name,
        "task version": task.version,
        "source": source,
        "support": [list(task.support.low), list(task.support.high)],
        "parameters": list(task.parameter_names),
        "features": list(task.labels),
    }
    if settings := settings_of(task):
        identity["settings"] = json.loads(json.dumps(settings, default=fingerprint))  # as the file has them
    return identity
