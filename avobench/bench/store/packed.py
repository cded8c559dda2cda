"""Many records in one Parquet file: one row per record, with its JSON text byte for byte.

A record's checksum is over the digits of its numbers, and its settings may nest as they like, so only the text comes
back as it was. `avobench export` makes a table of the fields. Earlier tables had columns of them too, which are left.
"""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import NEWER

SCHEMA = {"schema": "avobench-packed-records", "version": "1"}
"""The metadata of the file tell this."""
NUM_ROWS = "rows"
"""The metadata tell the number of rows too, as the part of a Parquet file that does has no checksum."""
ROWS_A_GROUP = 128
"""Rows that are compressed together, and that a damaged place in the file takes with it; 256 save 3 % of its size."""
COMPRESSION_LEVEL = 9
"""The level of zstd: 360 records take 0.2 s. The highest, 19, saves a fifth of the room in twenty times the time."""
UNREADABLE = (OSError, ValueError, KeyError, NotImplementedError, MemoryError, pa.ArrowException)
"""PyArrow raises one of these on a file whose bytes were changed."""


@dataclass(frozen=True)
class Row:
    """A record as the table has it."""

    file: str
    """The name of the file that it had."""
    text: str
    """The content of that file."""


class Unreadable(Exception):
    """Why a table, or a part of it, cannot be read, so that it is not known which records it holds."""


def read_rows(path: Path) -> Iterator[Row]:
    """The rows of a table, none where there is no table. Raises Unreadable, after all rows that can be read."""
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as table:
            yield from _rows(table)
    except FileNotFoundError:
        return
    except UNREADABLE as error:
        raise Unreadable(f"cannot be read ({_first_line(error)})") from error


def _rows(table: pq.ParquetFile) -> Iterator[Row]:
    metadata = {key.decode(): value.decode() for key, value in (table.schema_arrow.metadata or {}).items()}
    version = metadata.get("version", "")
    if metadata.get("schema") == SCHEMA["schema"] and version.isdecimal() and int(version) > int(SCHEMA["version"]):
        raise Unreadable(f"{NEWER}: it has version {version}, and {SCHEMA['version']} is known here")
    texts = all(table.schema_arrow.field(name).type == pa.string() for name in ("file", "record"))
    if not texts or {key: metadata.get(key) for key in SCHEMA} != SCHEMA:
        raise Unreadable(f"is not a table of records of version {SCHEMA['version']}")
    read, reason = 0, "they are not there"
    for group in range(table.num_row_groups):
        try:
            columns = table.read_row_group(group, ["file", "record"]).to_pydict()
        except UNREADABLE as error:
            reason = _first_line(error)
            continue
        for file, text in zip(columns["file"], columns["record"], strict=True):
            yield Row(file or "", text or "")
            read += 1
    if read != int(metadata[NUM_ROWS]):
        raise Unreadable(f"is damaged: {read} of {metadata[NUM_ROWS]} rows can be read ({reason})")


def write_rows(path: Path, rows: list[Row]) -> None:
    """Write a table of `rows`, whole or not at all, and only once it was read back as it is to be. Raises OSError."""
    content = io.BytesIO()
    columns = {"file": [row.file for row in rows], "record": [row.text for row in rows]}
    metadata = {**SCHEMA, NUM_ROWS: str(len(rows))}
    pq.write_table(
        pa.table(columns, pa.schema(dict.fromkeys(columns, pa.string()), metadata)),
        content,
        row_group_size=ROWS_A_GROUP,
        compression="zstd",
        compression_level=COMPRESSION_LEVEL,
        write_page_checksum=True,
    )

    def check(written: Path) -> None:
        try:
            same = all(stored == row for stored, row in zip_longest(read_rows(written), rows))
        except Unreadable as error:
            raise OSError(f"what was written {error}") from error
        if not same:
            raise OSError("what was written is not what is read back")

    write_atomically(path, content.getvalue(), check)


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]
