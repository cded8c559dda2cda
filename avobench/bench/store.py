"""Records on disk: one JSON file a cell, written whole or not at all. The schema is described in docs/records.md."""

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pandas as pd
from filelock import FileLock, Timeout

from avobench.bench.record import SCHEMA_VERSION
from avobench.tasks.errors import StoreError, UsageError

SCHEMA = {"schema": "avobench-records", "version": SCHEMA_VERSION}


class Store:
    """A folder of records: `store.json` names the schema, `records/` holds one file a cell.

    Every record carries a checksum of its content, so that a truncated or edited one is noticed. Only the process that
    holds `lock()` writes.
    """

    def __init__(self, path: Path, *, create: bool = False) -> None:
        """Open the store at `path`; raises UsageError when the folder cannot be one, or is none and not to be made."""
        self.path = path
        self.records = path / "records"
        self.running = path / "running"
        marker = path / "store.json"
        if not create and not path.exists():
            raise UsageError(f"there is no results folder {path}; `avobench run --results {path}` makes one")
        if path.exists() and not path.is_dir():
            raise UsageError(f"the results folder {path} is a file; choose a folder with --results")
        try:
            if not marker.exists():
                if path.exists() and any(not inside.name.startswith(".") for inside in path.iterdir()):
                    raise UsageError(f"{path} holds other files and no store.json; choose an empty or new folder")
                if not create:
                    raise UsageError(f"{path} is empty; `avobench run --results {path}` fills it")
                path.mkdir(parents=True, exist_ok=True)
                write_atomically(marker, (json.dumps(SCHEMA) + "\n").encode())
            found = json.loads(marker.read_text())
        except ValueError as error:
            raise UsageError(f"{marker} is not readable as JSON; restore it to {json.dumps(SCHEMA)}") from error
        except OSError as error:
            raise UsageError(f"the results folder {path} cannot be used: {error.strerror or error}") from error
        if found != SCHEMA:
            raise UsageError(f"{path} holds the schema {found}, this version of avobench reads {SCHEMA}")
        if create and not os.access(path, os.W_OK):
            raise UsageError(f"the results folder {path} is read-only; choose another with --results")

    def lock(self) -> AbstractContextManager[Any]:
        """A lock that one sweep at a time can hold; it goes with its process. Raises UsageError if it is taken."""
        lock = FileLock(self.path / ".lock")
        try:
            return lock.acquire(timeout=0)
        except Timeout as error:
            raise UsageError(f"another avobench run is writing to {self.path}; wait for it or stop it") from error

    def write(self, record: dict[str, Any]) -> Path:
        """Write one record, whole or not at all. Raises StoreError when the disk does not take it."""
        try:
            self.records.mkdir(exist_ok=True)
            return write_atomically(self.records / file_name(record), encode(record))
        except OSError as error:
            raise StoreError(f"a record could not be written to {self.records}: {error.strerror or error}") from error

    def log_sweep(self, entry: dict[str, Any]) -> None:
        """Add a line to `sweeps.jsonl`, which tells how the records were made: command, time taken, versions."""
        with (self.path / "sweeps.jsonl").open("a") as file:
            file.write(json.dumps(entry) + "\n")

    def sweeps(self) -> list[dict[str, Any]]:
        """The lines of `sweeps.jsonl`, oldest first; a last line cut short by a crash is left out."""
        path = self.path / "sweeps.jsonl"
        lines = path.read_text().splitlines(keepends=True) if path.exists() else []
        return [json.loads(line) for line in lines if line.endswith("\n")]

    def read(self) -> tuple[list[dict[str, Any]], dict[Path, str]]:
        """All sound records, ordered by file name, and the damaged files with what is wrong with each."""
        sound, damaged = [], {}
        for path in sorted(self.records.glob("*.json")):
            try:
                record = decode(path.read_bytes())
                if path.name != file_name(record):
                    raise ValueError(f"is a copy of {file_name(record)}, or was renamed")
                sound.append(record)
            except ValueError as error:
                damaged[path] = str(error)
        return sound, damaged

    def read_all(self) -> list[dict[str, Any]]:
        """All records; raises StoreError when one is damaged or when there are none."""
        sound, damaged = self.read()
        for path, reason in damaged.items():
            raise StoreError(f"{path} {reason}; `avobench run` sets it aside and makes it again, or delete it")
        if not sound:
            raise StoreError(f"there are no records in {self.path}; `avobench run --results {self.path}` makes them")
        return sound

    def set_aside(self, path: Path) -> Path:
        """Move a damaged record out of the way, to `damaged/`, never over another file."""
        folder = self.path / "damaged"
        folder.mkdir(exist_ok=True)
        target = folder / path.name
        number = 1
        while target.exists():
            target = folder / f"{path.name}.{number}"
            number += 1
        return path.rename(target)

    def remove_leftovers(self) -> None:
        """Delete what a killed run left half-done: temporary files and marks of running cells. Needs the lock."""
        for leftover in [*self.records.glob(".*.tmp"), *self.running.glob("*")]:
            leftover.unlink(missing_ok=True)  # the workers of a killed run may still be ending


def file_name(record: dict[str, Any]) -> str:
    """Where a record is kept: what it is of, in words, and its id."""
    return "{task}_{method}_t{target:02d}_r{repetition}_{id}.json".format(**record)


def encode(record: dict[str, Any]) -> bytes:
    """A record as one line of JSON with its checksum."""
    return (json.dumps({**record, "sha256": _checksum(record)}, allow_nan=False) + "\n").encode()


def decode(content: bytes) -> dict[str, Any]:
    """The record in `content`; raises ValueError saying what is wrong with it."""
    try:
        record = json.loads(content)
        claimed = record.pop("sha256")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError("is truncated or not a record") from error
    if record.get("schema_version") != SCHEMA_VERSION:
        raise ValueError(f"has schema version {record.get('schema_version')}, not {SCHEMA_VERSION}")
    if _checksum(record) != claimed:
        raise ValueError("was changed after it was written (its checksum does not match)")
    return record


def to_frame(records: Iterable[dict[str, Any]]) -> pd.DataFrame:
    """One row a cell; lists over parameters become columns `theta_true_0`, `theta_true_1`, ...; no trace."""
    rows = []
    for record in records:
        row = dict(record)
        for name in ("theta_true", "theta_hat", "mean", "std"):
            values = row.pop(name) or [None] * len(record["theta_true"])
            row |= {f"{name}_{i}": value for i, value in enumerate(values)}
        for name in ("task_settings", "method_settings", "versions"):
            row[name] = json.dumps(row[name], sort_keys=True)
        row["parameter_names"] = " ".join(row["parameter_names"])
        row.pop("trace", None)  # a sweep keeps none
        rows.append(row)
    frame = pd.DataFrame(rows)
    per_parameter = frame.columns[frame.columns.str.fullmatch(r"(theta_true|theta_hat|mean|std)_\d+")]
    numbers = [*per_parameter, "squared_error", "floor", "floor_likelihood", "peak_memory_mib"]
    frame[numbers] = frame[numbers].astype(float)
    counts = [f"simulations_{what}" for what in ("requested", "used", "discarded", "refused")]
    frame[counts] = frame[counts].astype("Int64")
    leading = ["task", "method", "target", "repetition", "seed", "status", "message", *sorted(per_parameter)]
    leading += ["squared_error", "floor", "num_observations", "budget", "simulations_used"]
    leading += ["simulator_seconds", "method_seconds"]
    return frame[leading + [name for name in frame.columns if name not in leading]]


def labels(records: list[dict[str, Any]]) -> tuple[list[str], list[str]]:
    """A label for the task and for the method of each record: its name, and whatever else tells like-named ones apart.

    So records of two settings, versions, budgets or numbers of observations are never pooled. Settings and versions
    are told where they differ within a method, budget and observations where they differ within a task.
    """
    common = ("budget", "num_observations")
    tasks = _labels(records, "task", lambda record: record["task"], common)
    return tasks, _labels(records, "method", lambda record: (record["task"], record["method"]), ())


def _labels(
    records: list[dict[str, Any]], kind: str, group: Callable[[dict[str, Any]], Any], common: tuple[str, ...]
) -> list[str]:
    parts = [
        {"version": record[f"{kind}_version"], "source": record.get(f"{kind}_source_sha256", "built-in")[:8]}
        | {name: record[name] for name in common}
        | record[f"{kind}_settings"]
        for record in records
    ]
    seen: dict[Any, dict[str, set[str]]] = {}
    for record, part in zip(records, parts, strict=True):
        for name, value in part.items():
            seen.setdefault(group(record), {}).setdefault(name, set()).add(json.dumps(value))
    result = []
    for record, part in zip(records, parts, strict=True):
        values = seen[group(record)]
        extra = [f"{name}={value}".replace(" ", "") for name, value in part.items() if len(values[name]) > 1]
        result.append(" ".join([record[kind], *extra]))
    return result


def write_atomically(path: Path, content: bytes) -> Path:
    """Write `content` to `path` so that a reader, or a crash, sees all of it or nothing.

    A link stays a link; what is not a regular file, such as a terminal, is written to as it is.
    """
    target = path.resolve()
    if target.exists() and not target.is_file():
        target.write_bytes(content)
        return path
    handle, temporary = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise
    return path


def _checksum(record: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()
