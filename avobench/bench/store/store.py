"""Records on disk: one JSON file per cell, or many packed in one table. docs/records.md describes them."""

import json
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from avobench.bench.store.claim import claim
from avobench.bench.store.damage import DamagedRecord
from avobench.bench.store.files import NAMES, disk_errors, locked, not_plain, sync_folder, within, write_atomically
from avobench.bench.store.packed import Row, Unreadable, read_rows, write_rows
from avobench.bench.store.record import NEWER, SCHEMA_VERSION, UNREAD, decode_record, encode, file_name
from avobench.tasks.errors import StoreError, UsageError

SCHEMA = {"schema": "avobench-records", "version": SCHEMA_VERSION}


@dataclass(frozen=True)
class Entry:
    path: Path
    """Its file; of a packed record, the table's path and within it the name of the file that it had."""
    content: bytes
    record: dict[str, Any] | None
    """The record; None where it is damaged."""
    fault: str = ""


@dataclass(frozen=True)
class Packed:
    rows: int
    """Records in the table now."""
    folded: int
    """Files that became rows."""
    damaged: dict[Path, str]
    """Files and rows that were left as they are, with what is wrong with each."""


class Store:
    """A folder of records: `store.json` names the schema, `records/` holds one file per cell, `records.parquet` others.

    A cell has a file until the store is packed; then it has a row of the table. A file wins over the row of the same
    cell, which it was made to replace. Only the process that holds `lock()` writes.
    """

    def __init__(self, path: Path, *, create: bool = False) -> None:
        """Open the store at `path`. Raises UsageError when the folder cannot be one, or is none and not to be made."""
        self.path = path
        self.records = path / "records"
        self.table = path / "records.parquet"
        self.running = path / "running"
        marker = path / "store.json"
        if not create and not path.exists():
            raise UsageError(f"there is no results folder {path}; `avobench run --results {path}` makes one")
        if path.exists() and not path.is_dir():
            raise UsageError(f"the results folder {path} is a file; choose a folder with --results")
        try:
            for name in NAMES:
                if why := not_plain(path / name):
                    raise UsageError(f"{path / name} {why}; a results folder holds plain files and folders alone")
            if not marker.exists():
                if path.exists() and any(not inside.name.startswith(".") for inside in path.iterdir()):
                    raise UsageError(f"{path} holds other files and no store.json; choose an empty or new folder")
                if not create:
                    raise UsageError(f"{path} is empty; `avobench run --results {path}` fills it")
                path.mkdir(parents=True, exist_ok=True)
                write_atomically(marker, (json.dumps(SCHEMA) + "\n").encode())
            schema = json.loads(marker.read_text())
        except (ValueError, RecursionError) as error:
            raise UsageError(f"{marker} is not readable as JSON; restore it to {json.dumps(SCHEMA)}") from error
        except OSError as error:
            raise UsageError(f"the results folder {path} cannot be used: {error.strerror or error}") from error
        if schema != SCHEMA:
            raise UsageError(f"{path} holds the schema {schema}, this version of avobench reads {SCHEMA}")
        if create and not os.access(path, os.W_OK):
            raise UsageError(f"the results folder {path} is read-only; choose another with --results")

    @contextmanager
    def lock(self) -> Iterator[None]:
        """A lock that one sweep at a time can hold; it goes with its process. Raises UsageError if it is taken.

        Some network file systems have no locks, or grant one to everyone who asks, so who writes leaves its name too.
        """
        lock = locked(self.path, f"another avobench run is writing to {self.path}; wait for it or stop it")
        try:
            with claim(self.path / ".writer"):
                yield
        finally:
            lock.release()

    def write(self, record: dict[str, Any]) -> Path:
        """Write one record, whole or not at all. Raises StoreError when the disk or a reader would not take it."""
        path = self.place(record)
        try:
            content = encode(record)
            decode_record(content)
        except (TypeError, ValueError) as error:
            raise StoreError(f"{path.name} is not written: {error}") from error
        if why := not_plain(path):
            raise StoreError(f"{path} {why}; remove it")
        if not (self.path / "store.json").exists():
            raise StoreError(f"the results folder {self.path} was removed while it was in use, and its records with it")
        with disk_errors(f"a record could not be written to {self.records}"):
            self.records.mkdir(exist_ok=True)
            return write_atomically(path, content)

    def place(self, record: dict[str, Any]) -> Path:
        """The file of a record, of which the identity and id are enough. Raises UsageError for a name that is none."""
        return within(self.records, file_name(record))

    def log_sweep(self, entry: dict[str, Any]) -> None:
        """Add a line to `sweeps.jsonl`, which tells how the records were made. Raises StoreError."""
        path = self.path / "sweeps.jsonl"
        with disk_errors(f"{path} could not be written"), path.open("a+b") as file:
            torn = file.tell() > 0 and (file.seek(-1, os.SEEK_END), file.read(1))[1] != b"\n"
            file.write(b"\n" * torn + json.dumps(entry).encode() + b"\n")

    def sweeps(self) -> list[dict[str, Any]]:
        """The lines of `sweeps.jsonl`, oldest first, without those that a crash cut short."""
        path, sweeps = self.path / "sweeps.jsonl", []
        for line in path.read_text(errors="replace").splitlines() if path.exists() else []:
            with suppress(ValueError, RecursionError):
                sweeps.append(json.loads(line))
        return [sweep for sweep in sweeps if isinstance(sweep, dict)]

    def entries(self) -> Iterator[Entry]:
        """The entries, one per cell: files first, then the rows of the table; last a table not all readable.

        A reader needs no lock. What is packed meanwhile is gone as a file, but then in the table, which is read after.
        """
        names = set()
        for path in self._files():
            try:
                if why := not_plain(path):
                    raise OSError(why)
                content = path.read_bytes()
            except FileNotFoundError:
                continue
            except OSError as error:
                yield Entry(path, b"", None, f"{UNREAD}: {error.strerror or error}")
            else:
                yield _entry(path, content)
            names.add(path.name)
        try:
            for row in read_rows(self.table):
                if row.file not in names:
                    yield _entry(within(self.table, row.file), row.text.encode())
                names.add(row.file)
        except (Unreadable, UsageError) as error:
            yield Entry(self.table, b"", None, str(error))

    def _files(self) -> list[Path]:
        """The files of records. Raises StoreError when the folder cannot be listed: it would seem to be empty."""
        with (
            disk_errors(f"{self.records} cannot be listed"),
            suppress(FileNotFoundError),
            os.scandir(self.records) as listing,
        ):
            return [self.records / each.name for each in listing if fnmatch(each.name, "[!.]*.json")]
        return []

    def read(self, *, traces: bool = True) -> tuple[list[dict[str, Any]], dict[Path, str]]:
        """All sound records, ordered by file name, and the damaged files and rows with what is wrong with each.

        Without `traces`, which are most of a record, many more have room in memory; then there is no such field.
        """
        sound, damaged = {}, {}
        once: dict[Any, Any] = {}
        for entry in self.entries():
            if entry.record is None:
                damaged[entry.path] = entry.fault
            else:
                sound[entry.path.name] = {
                    sys.intern(name): _once(value, once)
                    for name, value in entry.record.items()
                    if traces or name != "trace"
                }
        return [sound[name] for name in sorted(sound)], {path: damaged[path] for path in sorted(damaged)}

    def read_all(self, *, traces: bool = True) -> list[dict[str, Any]]:
        """All sound records, ordered by file name, with a warning DamagedRecord for each other one.

        Raises StoreError when there are none.
        """
        sound, damaged = self.read(traces=traces)
        for path, fault in damaged.items():
            warnings.warn(f"{path} {fault}; {self.remedy(path, fault)}", DamagedRecord, stacklevel=2)
        if not sound:
            raise StoreError(
                f"there are no sound records in {self.path}; `avobench run --results {self.path}` makes them"
            )
        return sound

    def remedy(self, path: Path, fault: str) -> str:
        """The sentence that says what to do about a damaged file, row or table."""
        if fault.startswith(NEWER):
            return "use the avobench that wrote it, or another results folder"
        if path.parent == self.records and fault.startswith(UNREAD):
            return "look at the disk and at the file's permissions, or move it away and `avobench run` makes it again"
        if path == self.table:
            return "restore it from a copy, or move it away and `avobench run` makes its records again"
        return "`avobench run` sets it aside and makes it again" + ", or delete it" * (path.parent == self.records)

    def set_aside(self, path: Path) -> Path:
        """Keep a damaged record in `damaged/`, never over another file, and move it out of the way.

        A row stays in the table, unread, until the store is next packed. Raises StoreError.
        """
        folder, row = self.path / "damaged", None
        if path.parent == self.table:
            row = next(entry.content for entry in self.entries() if entry.path == path)
        with disk_errors(f"{path} could not be set aside"):
            folder.mkdir(exist_ok=True)
            target, number = within(folder, path.name), 1
            while target.exists():
                if row is not None and target.read_bytes() == row:
                    return target  # by a run that was stopped before it had made the cell again
                target = within(folder, f"{path.name}.{number}")
                number += 1
            return path.rename(target) if row is None else write_atomically(target, row)

    def pack(self) -> Packed:
        """Fold the records that are files into the table; a file wins over the row of the same cell.

        The table is put in its place before the first file is removed, so a kill loses nothing, and packing again goes
        on. Raises UsageError while a sweep writes to the store, StoreError when a table cannot be read or written.
        """
        with self.lock():
            self.remove_leftovers()
            try:
                before = {row.file: row for row in read_rows(self.table)}
            except Unreadable as error:  # a new table would lose what cannot be read
                raise StoreError(f"{self.table} {error}; {self.remedy(self.table, str(error))}") from error
            rows, damaged, files = dict(before), {}, []
            for entry in self.entries():
                if entry.path == self.table:
                    raise StoreError(f"{entry.path} {entry.fault}; {self.remedy(entry.path, entry.fault)}")
                if entry.record is None:
                    damaged[entry.path] = entry.fault
                elif entry.path.parent == self.records:
                    rows[entry.path.name] = Row(entry.path.name, entry.content.decode())
                    files.append(entry.path)
            if not rows and not damaged:
                raise StoreError(f"there are no records in {self.path} to pack")
            with disk_errors(f"{self.path} could not be packed"):
                if rows != before:
                    write_rows(self.table, [rows[name] for name in sorted(rows)])
                sync_folder(self.path)  # the table is in its folder for good before the first file goes
                for path in files:
                    path.unlink()
            with suppress(OSError):  # not empty, or not there
                self.records.rmdir()
        return Packed(len(rows), len(files), damaged)

    def remove_leftovers(self) -> None:
        """Delete what a killed run left half-done. Needs the lock. Raises StoreError."""
        leftovers = [*self.path.glob(".*.tmp"), *self.path.glob(".writer.*"), *self.records.glob(".*.tmp")]
        with disk_errors(f"{self.path} could not be tidied up"):
            for leftover in [*leftovers, *self.running.glob("*")]:
                leftover.unlink(missing_ok=True)  # the workers of a killed run may still be ending


def _once(value: Any, once: dict[Any, Any]) -> Any:
    """An equal text that is in memory already, in place of this one: much is the same in all records of a sweep."""
    if isinstance(value, str):
        return once.setdefault(value, value)
    if isinstance(value, dict):
        return {_once(name, once): _once(inner, once) for name, inner in value.items()}
    return value


def _entry(path: Path, content: bytes) -> Entry:
    try:
        record = decode_record(content)
        if path.name != file_name(record):
            raise ValueError(f"is a copy of {file_name(record)}, or was renamed")
    except ValueError as error:
        return Entry(path, content, None, str(error))
    return Entry(path, content, record)
