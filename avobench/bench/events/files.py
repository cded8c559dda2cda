"""Measured events from a file of any common format."""

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
from numpy.typing import NDArray

from avobench.bench.events.text import SUFFIXES as TEXT
from avobench.bench.events.text import read_text
from avobench.tasks.arguments import checked
from avobench.tasks.errors import UsageError, if_uneven, optional

KINDS = ".npy, .npz, .csv, .tsv, .txt, .dat (also .gz), .parquet, or .root:TREE"
"""Formats that events are read from, for messages."""


@checked
def read_events(path: str, columns: Sequence[str] | None = None) -> NDArray | pd.DataFrame:
    """The events of a file: `read_timed` without a time."""
    return read_timed(path, columns)[0]


def read_timed(
    path: str, columns: Sequence[str] | None = None, time: str | None = None
) -> tuple[NDArray | pd.DataFrame, NDArray[np.float64] | None]:
    """The events of a .npy, .npz, text or .parquet file, or of a tree `file.root:tree`: (n, d), one row per event.

    What has columns with names is a table, the rest an array. `columns` chooses columns, branches, or arrays of a .npz;
    without it all are read. More than two dimensions are flattened row by row. Also returns the column `time` (n,), if
    one is named, which is then none of the events'. Raises UsageError for what cannot be read as numbers, and for
    pickled content, which could run code.
    """
    file, _, tree = path.rpartition(":") if re.search(r"\.root:[^:]+$", path) else (path, "", "")
    if not Path(file).is_file():
        raise UsageError(f"there is no file {file}")
    suffix = Path(file.removesuffix(".gz")).suffix
    if suffix == ".root" and not tree:
        raise UsageError(f"a ROOT file needs the name of a tree: {file}:TREE")
    if suffix not in (".npy", *_READERS):
        raise UsageError(f"{file}: events are read from {KINDS}")
    if (columns or time) and suffix == ".npy":
        raise UsageError(f"{file}: the columns of a .npy file have no names to choose from")
    try:
        if suffix == ".npy":
            return _flat(file, np.load(file, allow_pickle=False)), None
        wanted = [*(name for name in columns if name != time), *([time] if time else [])] if columns else None
        arrays = _READERS[suffix](file, tree, wanted)
        when = None
        if time is not None:
            _chosen(file, list(arrays), [time])
            when = seconds(np.asarray(arrays.pop(time)), f"{file}: '{time}'")
            _chosen(file, list(arrays), None)
        if suffix == ".npz" and len(arrays) > 1 and columns is None:
            raise UsageError(f"{file} holds several arrays, choose by --columns: {', '.join(arrays)}")
        x = _flat(file, *arrays.values()) if suffix == ".npz" and len(arrays) == 1 else _table(file, arrays)
    except UsageError:
        raise
    except Exception as error:  # every reader has its own exceptions, and a damaged file may raise any
        if "allow_pickle" in str(error):
            raise UsageError(f"{file} is no plain array; it may hold pickled objects, which could run code") from error
        raise UsageError(f"{file} cannot be read: {type(error).__name__}: {error}") from error
    if when is not None and len(when) != len(x):
        raise UsageError(f"{file}: the columns differ in length")
    return x, when


def _read_npz(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    with np.load(file, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in _chosen(file, arrays.files, columns)}


def _read_csv(file: str, tree: str, columns: list[str] | None) -> dict[str, pd.Series]:
    frame, named = read_text(file)
    if columns and not named:
        raise UsageError(f"{file} has no line of column names to choose from")
    return dict(frame[_chosen(file, list(frame.columns), columns)].items())


def _read_parquet(file: str, tree: str, columns: list[str] | None) -> dict[str, pd.Series]:
    with pyarrow.parquet.ParquetFile(file) as opened:
        names = [name for name in opened.schema_arrow.names if columns or not name.startswith("__index_level_")]
        frame = opened.read(_chosen(file, names, columns)).to_pandas(ignore_metadata=True)
    return {str(name): values for name, values in frame.items()}


def _read_root(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    with optional("uproot", "a ROOT file", "root").open(file) as opened:
        trees = [
            name.partition(";")[0] for name, kind in opened.classnames().items() if kind in ("TTree", "ROOT::RNTuple")
        ]
        if tree not in trees:
            raise UsageError(f"{file} has no tree '{tree}'; it has: {', '.join(dict.fromkeys(trees)) or 'none'}")
        names = _chosen(file, opened[tree].keys(), columns)
        arrays = opened[tree].arrays(names, library="np")
    return {name: arrays[name] for name in names}  # uproot has an order of its own


_READERS: dict[str, Callable[[str, str, list[str] | None], dict[str, NDArray | pd.Series]]] = {
    ".npz": _read_npz,
    **dict.fromkeys(TEXT, _read_csv),
    ".parquet": _read_parquet,
    ".root": _read_root,
}


def _chosen(file: str, names: list, columns: list[str] | None) -> list:
    missing = [name for name in columns or [] if name not in names]
    if missing:
        raise UsageError(f"{file} has no {', '.join(missing)}; it has: {', '.join(map(str, names))}")
    if not names:
        raise UsageError(f"{file} is empty")
    return names if columns is None else columns


def _flat(file: str, x: NDArray) -> NDArray:
    if x.dtype == bool:
        x = x.astype(np.uint8)
    if x.dtype.kind not in "iuf":
        raise UsageError(f"{file} holds {x.dtype} instead of real numbers")
    if x.ndim == 0:
        raise UsageError(f"{file} holds a single number")
    return x.reshape(len(x), math.prod(x.shape[1:]))


def _table(file: str, arrays: dict[str, NDArray | pd.Series]) -> pd.DataFrame:
    """Columns of numbers side by side: (n, d). Raises UsageError for another column, and names the first wrong cell."""
    for name, values in arrays.items():
        if values.ndim != 1 or values.dtype.kind not in "biuf":
            raise UsageError(
                f"{file}: '{name}' does not hold one real number per event{_first_text(values) or if_uneven(values)}"
            )
    if len({len(values) for values in arrays.values()}) > 1:
        raise UsageError(f"{file}: the columns differ in length")
    return pd.DataFrame(arrays).reset_index(drop=True)


def _first_text(values: NDArray | pd.Series) -> str:
    """The first cell of a column of text that is no number, where the column comes from a text file."""
    if not isinstance(values, pd.Series) or "decimal" not in values.attrs or values.dtype.kind == "M":
        return ""
    swapped = str.maketrans(f".{values.attrs['decimal']}", f"{values.attrs['decimal']}.")
    cells = values.astype(str).str.translate(swapped)
    wrong = values[pd.to_numeric(cells, errors="coerce").isna() & values.notna()]
    return f": line {wrong.index[0]} has '{wrong.iloc[0]}'; mend it, or choose other columns" if len(wrong) else ""


def seconds(time: NDArray, what: str) -> NDArray[np.float64]:
    """Times (n,) as numbers: dates as seconds since 1970, of UTC where they name no zone; NaN where one is missing.

    Raises UsageError for what is neither.
    """
    if time.ndim == 1 and time.dtype.kind in "biuf":
        return time.astype(float)
    try:
        dates = pd.to_datetime(pd.Series(time), format="ISO8601", utc=True)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{what} holds neither a number nor a date such as 2012-07-04T09:00 for each event") from error
    return ((dates - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(seconds=1)).to_numpy(float)
