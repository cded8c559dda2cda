"""Published tables from CSV, from HEPData's CSV and YAML, from ROOT, and from histograms of Python's libraries."""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avobench.tables.table import Table
from avobench.tasks.arguments import checked
from avobench.tasks.errors import UsageError, optional

KINDS = "text (.csv), HEPData's .csv, .yaml and .yml, or .root:HISTOGRAM"
"""Formats that tables are read from, for messages."""
SEPARATORS = (",", ";", "\t")
DECIMAL = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?%?")
"""A number with a decimal comma."""


@dataclass(frozen=True)
class Published:
    """The bins of one table as they are written."""

    name: str
    column: str
    low: list[float]
    high: list[float]
    values: list[float]
    errors: list[float] | None
    """The errors; None where none are written: then the values are counts."""
    unit: str = ""
    """Of the edges."""

    def table(self, **settings: Any) -> Table:
        """The table, with what its file does not say. Raises UsageError for bins that do not lie side by side."""
        for i, (end, start) in enumerate(zip(self.high, self.low[1:], strict=False), start=1):
            if not np.isclose(end, start, rtol=1e-9, atol=1e-12):
                raise UsageError(f"table {self.name}: bin {i} ends at {end:g}, but bin {i + 1} begins at {start:g}")
        errors = None if "covariance" in settings else self.errors
        given = {"name": self.name, "errors": errors, "unit": self.unit, **settings}
        return Table([*self.low, *self.high[-1:]], self.values, **given)


@checked
def read_table(source: Any, table: str | None = None, **settings: Any) -> Table:
    """A published table from a file or a histogram.

    `source` is one of

    - a .csv file with the columns low, high, value and error, without the last of counts, separated by commas, or by
      semicolons or tabs, where numbers may have decimal commas. Further columns are left out, but numbers behind the
      value are refused if no column is called error, and so are further errors of two sides if one is; a column `table`
      says which of several tables a row is of;
    - a .csv, .yaml or .yml file of a table from HEPData. Errors are added in quadrature, the two sides of asymmetric
      ones averaged. YAML tells the unit of the edges too;
    - a one-dimensional histogram in a ROOT file, `file.root:histogram`;
    - a histogram with the PlottableHistogram protocol, such as those of hist, boost-histogram and uproot. On an axis of
      whole numbers each has a bin around it.

    `table` chooses one of several by its name; where a table of HEPData has several columns of values, by the column's.
    `settings` are those of `Table` that a file does not tell, such as `of`, `density` and `normalised`.

    Raises UsageError for what cannot be read, a table that is not there, and bins with gaps between them.
    """
    if not isinstance(source, str | Path):
        return _of_histogram(source, "histogram").table(**settings)
    file, _, tree = str(source).rpartition(":") if re.search(r"\.root:[^:]+$", str(source)) else (str(source), "", "")
    suffix = Path(file).suffix.lower()
    if not Path(file).is_file():
        raise UsageError(f"there is no file {file}")
    if suffix == ".root":
        return _of_root(file, tree).table(**settings)
    if suffix not in (".csv", ".yaml", ".yml"):
        raise UsageError(f"{file}: tables are read from {KINDS}")
    try:
        published = list(_of_csv(file) if suffix == ".csv" else _of_yaml(file))
    except UnicodeDecodeError as error:
        raise UsageError(f"{file} is not a text in UTF-8 (byte {error.start})") from error
    tables = [each.name for each in published]
    names = [each.name if tables.count(each.name) == 1 else each.column for each in published]
    chosen = [each for each, name in zip(published, names, strict=True) if table in (None, name)]
    if len(chosen) != 1:
        if not published:
            raise UsageError(f"{file} holds no table")
        asked = "holds several tables" if table is None else f"has no table '{table}'"
        raise UsageError(f"{file} {asked}; choose one of: {', '.join(names)}")
    return chosen[0].table(**settings)


def _of_csv(file: str) -> Iterator[Published]:
    """The tables of a text file, each with a line of names, from which on there are numbers."""
    name, header, rows = Path(file).stem, None, []
    for number, cells in enumerate(_cells(file), start=1):
        if not any(cells):
            continue
        if cells[0].startswith("#"):
            if title := re.match(r"#: *name: *(.+)", ",".join(cells)):
                yield from _of_rows(file, name, header, rows)
                name, header, rows = title[1].strip(), None, []
        elif header is None or (len(cells) > 1 and not any(map(_is_number, cells))):
            yield from _of_rows(file, name, header, rows)
            header, rows = cells, []
        elif len(cells) != len(header):
            raise UsageError(f"{file}: line {number} has {len(cells)} cells and the columns are {len(header)}")
        else:
            rows.append((number, dict(zip(header, cells, strict=True))))
    yield from _of_rows(file, name, header, rows)


def _cells(file: str) -> list[list[str]]:
    """The cells of each line of a text file, with decimal points.

    They are separated by commas, semicolons or tabs: by that which makes a column of lower edges and one of upper ones.
    Beside the last two a decimal comma is one. Raises UsageError where other numbers have points.
    """
    with open(file, encoding="utf-8-sig", newline="") as stream:
        lines = stream.read().splitlines(keepends=True)
    read = {separator: list(csv.reader(lines, delimiter=separator)) for separator in SEPARATORS}
    by_separator = {separator: [[cell.strip() for cell in row] for row in rows] for separator, rows in read.items()}
    separator = next(
        (one for one, rows in by_separator.items() if any(_end(row, "low") and _end(row, "high") for row in rows)), ","
    )
    rows = by_separator[separator]
    if separator == "," or not any(DECIMAL.fullmatch(cell) for row in rows for cell in row):
        return rows
    if any("." in cell and _is_number(cell) for row in rows for cell in row):
        raise UsageError(f"{file} has numbers with decimal commas and others with points; write all of them in one way")
    return [[cell.replace(",", ".") if DECIMAL.fullmatch(cell) else cell for cell in row] for row in rows]


def _of_rows(
    file: str, name: str, header: list[str] | None, rows: list[tuple[int, dict[str, str]]]
) -> Iterator[Published]:
    if header is None:
        return
    low, high = _column(file, header, "low"), _column(file, header, "high")
    behind = header[header.index(high) + 1 :]
    named = {column.lower(): column for column in header}
    value = named.get("value", next(iter(behind), None))
    if value is None:
        raise UsageError(f"{file} has no column of values behind '{high}'")
    # HEPData has two columns an error, for its upper and its lower side.
    sides = [column for column in behind if column.endswith((" +", " -"))]
    if [column[:-2] for column in sides[::2]] != [column[:-2] for column in sides[1::2]]:
        raise UsageError(f"{file}: errors have two sides, ' +' and ' -' side by side, got: {', '.join(sides)}")
    if sides and "error" in named:
        message = f"{file} has the column '{named['error']}' beside {', '.join(sides)}"
        raise UsageError(f"{message}: drop these if it is the total, else make it two, 'error +' and 'error -'")
    errors = [[named["error"]]] if "error" in named else list(zip(sides[::2], sides[1::2], strict=True))
    others = [
        column
        for column in header[header.index(value) + 1 :]
        if column not in (low, high, named.get("table")) and any(_is_number(row[column]) for _, row in rows)
    ]
    if others and not errors:
        raise UsageError(f"{file} has no column 'error' beside '{', '.join(others)}': call it error, or drop it")
    of = named.get("table", "")
    for one in dict.fromkeys(row.get(of, name) for _, row in rows):
        bins = []
        for number, row in rows:
            if row.get(of, name) == one:
                where = f"{file}: line {number}"
                at = _number(row[value], where)
                row_errors = [[_number(row[c], where, at) for c in pair if row[c] not in ("", "-")] for pair in errors]
                if "error" in named and min(row_errors[0], default=0) < 0:
                    raise UsageError(f"{where} has an error of {row_errors[0][0]:g}: errors must be positive")
                error = np.sqrt(sum(np.mean(np.square(pair)) for pair in row_errors if pair))
                bins.append((_number(row[low], where), _number(row[high], where), at, float(error)))
        lows, highs, values, sizes = map(list, zip(*bins, strict=True))
        yield Published(one, value, lows, highs, values, sizes if errors else None)


def _end(header: list[str], end: str) -> str | None:
    return next((name for name in header if name.lower() == end or name.lower().endswith(f" {end}")), None)


def _column(file: str, header: list[str], end: str) -> str:
    if column := _end(header, end):
        return column
    raise UsageError(f"{file} has no column '{end}'; it has: {', '.join(header)}")


def _of_yaml(file: str) -> Iterator[Published]:
    """The tables of HEPData's YAML: each column of values is one."""
    yaml = optional("yaml", f"{file}, as all YAML,", "tables")
    try:
        with open(file, encoding="utf-8") as stream:
            documents = [each for each in yaml.safe_load_all(stream) if isinstance(each, dict)]
    except yaml.YAMLError as error:
        raise UsageError(f"{file} is no YAML: {' '.join(str(error).split())}") from error
    for document in documents:
        if not {"independent_variables", "dependent_variables"} <= set(document):
            continue
        if len(document["independent_variables"]) != 1:
            raise UsageError(f"{file} is binned by {len(document['independent_variables'])} variables: give one")
        variable = document["independent_variables"][0]
        places, unit = variable["values"], (variable.get("header") or {}).get("units") or ""
        if not all({"low", "high"} <= set(place) for place in places):
            raise UsageError(f"{file} has points in place of bins: each needs low and high")
        low, high = ([_number(place[end], file) for place in places] for end in ("low", "high"))
        for column in document["dependent_variables"]:
            name = column["header"]["name"]
            cells = column["values"]
            if len(cells) != len(places):
                raise UsageError(f"{file}: '{name}' has {len(cells)} values for {len(places)} bins")
            values = [_number(cell["value"], f"{file}: '{name}'") for cell in cells]
            errors = [_total(cell.get("errors", []), value, file) for cell, value in zip(cells, values, strict=True)]
            if not any(cell.get("errors") for cell in cells):
                errors = None
            yield Published(name, name, low, high, values, errors, str(unit))


def _total(errors: list[dict[str, Any]], value: float, file: str) -> float:
    square = 0.0
    for error in errors:
        sides = [error["symerror"]] * 2 if "symerror" in error else list(error["asymerror"].values())
        square += sum(_number(side, file, value) ** 2 for side in sides) / 2
    return float(np.sqrt(square))


def _is_number(cell: str) -> bool:
    try:
        float(cell.removesuffix("%"))
    except ValueError:
        return False
    return True


def _number(cell: Any, where: str, value: float = np.nan) -> float:
    """A number, or a percentage of a value."""
    text = str(cell).strip()
    if not _is_number(text):
        raise UsageError(f"{where} has '{text}' in place of a number: leave the bin out")
    return float(text[:-1]) / 100 * value if text.endswith("%") else float(text)


def _of_root(file: str, name: str) -> Published:
    with optional("uproot", "a ROOT file", "root").open(file) as opened:
        histograms = [key.partition(";")[0] for key, kind in opened.classnames().items() if kind.startswith("TH1")]
        if name not in histograms:
            raise UsageError(f"{file} has no TH1 '{name}'; it has: {', '.join(dict.fromkeys(histograms)) or 'none'}")
        return _of_histogram(opened[name], name)


def _of_histogram(histogram: Any, name: str) -> Published:
    if not (hasattr(histogram, "axes") and hasattr(histogram, "values") and hasattr(histogram, "variances")):
        raise UsageError(f"a table is read from {KINDS} or a histogram, got {type(histogram).__name__}")
    if len(histogram.axes) != 1:
        raise UsageError(f"a table has one axis, the histogram {len(histogram.axes)}: project it")
    if histogram.kind != "COUNT":
        raise UsageError(f"the histogram holds a {str(histogram.kind).lower()} in each bin: give one of counts")
    axis = histogram.axes[0]
    bins = [axis[i] for i in range(len(axis))]
    if all(isinstance(at, int) for at in bins):  # of whole numbers, around which a bin has its edges
        bins = [(at - 0.5, at + 0.5) for at in bins]
    if any(np.size(ends) != 2 for ends in bins):
        raise UsageError("the axis of the histogram has names in place of bins with edges")
    low, high = ([float(ends[k]) for ends in bins] for k in (0, 1))
    values, variances = np.asarray(histogram.values(), float), histogram.variances()
    counts = variances is None or np.array_equal(values, variances)
    return Published(name, name, low, high, values.tolist(), None if counts else np.sqrt(variances).tolist())
