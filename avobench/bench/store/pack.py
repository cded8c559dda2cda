"""A finished store in few files: its records folded into one table, and only then removed as single files."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from avobench.bench.store.files import disk_errors, sync_folder
from avobench.bench.store.packed import Row, Unreadable, read_rows, write_rows
from avobench.bench.store.store import Store
from avobench.tasks.errors import StoreError


@dataclass(frozen=True)
class Packed:
    rows: int
    """Records in the table now."""
    folded: int
    """Files that became rows."""
    damaged: dict[Path, str]
    """Files and rows that were left as they are, with what is wrong with each."""


def pack(store: Store) -> Packed:
    """Fold the records of `store` that are files into its table; a file wins over the row of the same cell.

    The table is put in its place before the first file is removed, so a kill loses nothing, and packing again goes on.
    Raises UsageError while a sweep writes to the store, StoreError when a table cannot be read or written.
    """
    with store.lock():
        store.remove_leftovers()
        before, damaged, files = _rows(store), {}, []
        rows = dict(before)
        for entry in store.entries():
            if entry.path == store.table:
                raise StoreError(f"{entry.path} {entry.fault}; {store.remedy(entry.path, entry.fault)}")
            if entry.record is None:
                damaged[entry.path] = entry.fault
            elif entry.path.parent == store.records:
                rows[entry.path.name] = Row(entry.path.name, entry.content.decode())
                files.append(entry.path)
        if not rows and not damaged:
            raise StoreError(f"there are no records in {store.path} to pack")
        with disk_errors(f"{store.path} could not be packed"):
            if rows != before:
                write_rows(store.table, [rows[name] for name in sorted(rows)])
            sync_folder(store.path)  # the table is in its folder for good before the first file goes
            for path in files:
                path.unlink()
        with suppress(OSError):  # not empty, or not there
            store.records.rmdir()
    return Packed(len(rows), len(files), damaged)


def _rows(store: Store) -> dict[str, Row]:
    """The rows of the table by name. Raises StoreError when some cannot be read: a new table would lose them."""
    try:
        return {row.file: row for row in read_rows(store.table)}
    except Unreadable as error:
        raise StoreError(f"{store.table} {error}; {store.remedy(store.table, str(error))}") from error
