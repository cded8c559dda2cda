"""Many records in one Parquet file: one row per record, its JSON text, and columns of its fields.

The text is what counts. A record's checksum is over the digits of its numbers and its settings may nest as they like,
so only the text comes back as it was; and text and columns together were measured to take a little less room
(690 kB for the 3.4 MB of results/reference) than columns with the trace as a list. The columns leave out the trace.
"""

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from avobench.bench.store.files import write_atomically
from avobench.bench.store.record import NEWER, Record, decode_record

SCHEMA = {"schema": "avobench-packed-records", "version": "1"}
"""The metadata of the file tell this."""
NUM_ROWS = "rows"
"""The metadata tell the number of rows too, as the part of a Parquet file that does has no checksum."""
ROWS_A_GROUP = 128
"""Rows that are compressed together, and that a damaged place in the file takes with it; 256 save 3 % of its size."""
COMPRESSION_LEVEL = 19
"""The level of zstd; a table is packed once and read often."""
QUICK_LEVEL = 6
"""The level of zstd for a large table: it is ten times as fast, and the file a fourth larger."""
LARGE = 5000
"""A table of so many rows is large: at the higher level it would take minutes."""
LEFT_OUT = ("schema_version", "trace")
"""Fields without a column: the one is that of the file, the other is most of a record and seldom read alone."""
TYPES = {"boolean": pa.bool_(), "integer": pa.int64(), "number": pa.float64(), "string": pa.string()}
AS_JSON = pa.string()
"""Objects, such as settings and versions, have other fields in other records."""
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
    pq.write_table(
        _table(rows),
        content,
        row_group_size=ROWS_A_GROUP,
        compression="zstd",
        compression_level=COMPRESSION_LEVEL if len(rows) < LARGE else QUICK_LEVEL,
        write_page_checksum=True,
    )

    def check(written: Path) -> None:
        try:
            same = all(found == row for found, row in zip_longest(read_rows(written), rows))
        except Unreadable as error:
            raise OSError(f"what was written {error}") from error
        if not same:
            raise OSError("what was written is not what is read back")

    write_atomically(path, content.getvalue(), check)


def _table(rows: list[Row]) -> pa.Table:
    shapes = {name: shape for name, shape in Record.model_json_schema()["properties"].items() if name not in LEFT_OUT}
    types = {"file": pa.string(), **{name: _arrow_type(shape) for name, shape in shapes.items()}, "record": pa.string()}
    return pa.Table.from_pylist(
        [{**_fields(row), "file": row.file, "record": row.text} for row in rows],
        pa.schema(types, {**SCHEMA, NUM_ROWS: str(len(rows))}),
    )


def _fields(row: Row) -> dict[str, Any]:
    """The fields of a row, objects as JSON; none of a damaged one, whose text is kept as it is."""
    try:
        record = decode_record(row.text.encode())
    except ValueError:
        return {}
    return {
        name: json.dumps(value, sort_keys=True) if isinstance(value, dict) else value for name, value in record.items()
    }


def _arrow_type(shape: dict[str, Any]) -> pa.DataType:
    """The column's type for a field's JSON schema; every column may hold nulls."""
    if "anyOf" in shape:
        return _arrow_type(shape["anyOf"][0])
    if shape.get("type") == "array":
        return pa.list_(_arrow_type(shape["items"]))
    return TYPES.get(shape.get("type", "string"), AS_JSON)


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]
