"""Tables of numbers from text files: what separates the columns, where the names are, and which cell is no number."""

import csv
import gzip
import io
import re
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pyarrow.csv
from pyarrow import ArrowInvalid

from avobench.tasks.errors import UsageError

SUFFIXES = (".csv", ".tsv", ".txt", ".dat")
"""Text files that are read, also with .gz behind."""
SEPARATORS = (";", "\t", "|", ",")
"""Columns are separated by one of these, looked for in this order: in a line with semicolons, commas are decimal."""
LINES = 200
"""Lines from which the form of a file is found out."""
VOID = ("", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None", "-")
"""A cell holds one of these where a value is missing."""
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?|[-+]?(inf|infinity)", re.IGNORECASE)


@dataclass(frozen=True)
class Form:
    separator: str
    decimal: str
    names: list[str] | None
    """Of the columns; None where the file does not name them."""
    skip: int
    """Lines of names and units before the first event."""
    trailing: bool
    """True if every event ends with a separator behind which there is nothing."""


def read_text(path: str) -> tuple[pd.DataFrame, bool]:
    """The table of a text file, whose index is the number of each line, and whether the file names the columns.

    Its attribute `decimal` is the point or comma of its numbers. Columns are separated by
    commas, semicolons, tabs, bars or blanks; beside all but the first a decimal comma is one. Blank lines, comments (#)
    and a line of units below the names are left out. Raises UsageError, with the number of the line, for an event with
    another number of cells, and for a first line that may be names or an event.
    """
    raw = Path(path).read_bytes()
    try:
        text = (gzip.decompress(raw) if path.endswith(".gz") else raw).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not a text in UTF-8 (byte {error.start}): save it as that") from error
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    comments = [line.lstrip("# ").strip() for _, line in lines if line.lstrip().startswith("#")]
    lines = [(number, line) for number, line in lines if not line.lstrip().startswith("#")]
    if not lines:
        raise UsageError(f"{path} is empty")
    separator = _separator([line for _, line in lines[:LINES]])
    if separator == " ":
        lines, separator = [(number, re.sub(r"[ \t]+", "\t", line.strip())) for number, line in lines], "\t"
        comments = [re.sub(r"[ \t]+", "\t", line) for line in comments]
    form = _form(path, [line for _, line in lines[:LINES]], comments, separator)
    events = lines[form.skip :]
    if not events:
        raise UsageError(f"{path} has names of columns, but no events")
    return _parsed(path, events, form), form.names is not None


def _separator(lines: list[str]) -> str:
    for separator in SEPARATORS:
        if separator in _unquoted(lines[0]) or all(separator in _unquoted(line) for line in lines[1:] or [""]):
            return separator
    return " " if any(re.search(r"\S\s+\S", _unquoted(line)) for line in lines) else ","


def _unquoted(line: str) -> str:
    return re.sub(r'"[^"]*"', "", line)


def _form(path: str, lines: list[str], comments: list[str], separator: str) -> Form:
    rows = [next(csv.reader([line], delimiter=separator, skipinitialspace=True)) for line in lines]
    named = not all(_number(cell) for cell in rows[0]) or _numbered(path, rows)
    names = [cell.strip() for cell in rows[0]] if named else None
    skip = int(named)
    if named and len(rows) > 2:
        skip += _units(rows[1], rows[2])
    events = rows[skip:]
    width = len(rows[0])
    if not named and comments:
        header = next(csv.reader([comments[-1]], delimiter=separator, skipinitialspace=True))
        if len(header) == width and not any(map(_number, header)):
            names = [cell.strip() for cell in header]
    longer = width + 1 if named and rows[0][-1].strip() else width
    trailing = bool(events) and longer > 1 and all(len(row) == longer and not row[-1].strip() for row in events)
    if trailing and names is not None and not names[-1]:
        names = names[:-1]
    if named and {len(row) for row in events} == {width + 1} and {line[0] for line in lines[skip:]} == {'"'}:
        names = ["", *names]  # R does not name the column of its names of rows
    if names is not None and len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise UsageError(f"{path} has two columns of the name '{twice}'")
    cells = [cell.strip() for row in events for cell in row]
    comma = separator != "," and any(re.fullmatch(NUMBER, cell) and "," in cell for cell in cells)
    if comma and any(re.fullmatch(NUMBER, cell) and "." in cell for cell in cells):
        raise UsageError(f"{path} has numbers with decimal commas and others with points; write all of them in one way")
    return Form(separator, "," if comma else ".", names, skip, trailing)


def _number(cell: str) -> bool:
    return cell.strip() in VOID or NUMBER.fullmatch(cell.strip()) is not None


def _units(row: list[str], event: list[str]) -> bool:
    """Tell whether a row below the names holds units: words and no number, with a number below at least one word."""
    words = [k for k, cell in enumerate(row) if not _number(cell)]
    numbers = any(_number(cell) and cell.strip() not in VOID for cell in row)
    return not numbers and any(k < len(event) and _number(event[k]) and event[k].strip() for k in words)


def _numbered(path: str, rows: list[list[str]]) -> bool:
    """Tell whether the first line numbers the columns 0, 1, ..., as pandas does, and is no event."""
    first = [cell.strip() for cell in rows[0]]
    if len(rows) < 2 or first != [str(k) for k in range(len(first))]:
        return False
    if any(re.search(r"[.,eE]", cell) for cell in rows[1]):
        return True
    if len(first) > 1:
        raise UsageError(f"{path}: the first line, {', '.join(first)}, may be names or an event; name the columns")
    return False


def _parsed(path: str, events: list[tuple[int, str]], form: Form) -> pd.DataFrame:
    width = len(next(csv.reader([events[0][1]], delimiter=form.separator))) - form.trailing
    names = form.names or [str(k) for k in range(width)]
    ends = form.separator if form.trailing else ""
    body = "\n".join(line.rstrip("\r") for _, line in events)
    try:
        table = pyarrow.csv.read_csv(
            io.BytesIO(body.encode()),
            pyarrow.csv.ReadOptions(column_names=[*names, ""] if ends else names, use_threads=False),
            pyarrow.csv.ParseOptions(delimiter=form.separator),
            pyarrow.csv.ConvertOptions(
                null_values=list(VOID), strings_can_be_null=True, decimal_point=form.decimal, check_utf8=False
            ),
        )
    except ArrowInvalid as error:
        raise UsageError(f"{path}: {_with_line(str(error), events)}") from error
    frame = (table.drop_columns([""]) if ends else table).to_pandas(date_as_object=False)
    frame.index = pd.Index([number for number, _ in events], name="line")
    frame.attrs["decimal"] = form.decimal
    return frame if form.names else frame.set_axis(range(width), axis=1)


def _with_line(error: str, events: list[tuple[int, str]]) -> str:
    """The message of the parser, with the line of the file."""
    match = re.search(r"Row #(\d+): Expected (\d+) columns, got (\d+)", error)
    if not match:
        return error
    row, wanted, got = map(int, match.groups())
    return f"line {events[row - 1][0]} has {got} cells and the columns are {wanted}"
