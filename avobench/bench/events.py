"""Measured events from a file of any common format, and what may be wrong with them."""

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.errors import UsageError

MIN_EVENTS = 200
"""A diagnosis needs so many: fewer fill no bins in which an effect could be told from another."""
LARGEST = 2.0**53
"""Double precision does not tell a whole number beyond this from the next."""
FAR = 100
"""A value that lies so many widths of what the simulator makes outside of it is another quantity."""
ALIKE = 1e-12
"""Values that differ by less than this share of the width of what the simulator makes lie at one place in it."""
NUM_REFERENCE = 20_000
"""So many simulated events tell which values the simulator can make; a tenth of it does for images."""
TAIL = 0.001
"""A tail is what lies beyond all but this share of the simulated values."""
BY_CHANCE = 0.01
"""The probability that the largest of all measured values lies beyond the range though the simulator made it."""
MANY_REPEATS = 0.01
"""A larger share of repeated events is worth a warning."""


def read_events(path: str, columns: Sequence[str] | None = None) -> NDArray:
    """The events of a file: `read_timed` without a time."""
    return read_timed(path, columns)[0]


def read_timed(
    path: str, columns: Sequence[str] | None = None, time: str | None = None
) -> tuple[NDArray, NDArray | None]:
    """The events of a .npy, .npz, .csv or .parquet file, or of a tree `file.root:tree`: (n, d), one row an event.

    `columns` chooses columns, branches, or arrays of a .npz, in this order; without it all are read. A one-dimensional
    array is one feature; what has more than two dimensions, such as images, is flattened row by row. Also the column
    `time` (n,), if one is named, which is then none of the events'; dates become seconds. Raises UsageError for what
    cannot be read as numbers, and for pickled content, which could run code.
    """
    file, _, tree = path.rpartition(":") if re.search(r"\.root:[^:]+$", path) else (path, "", "")
    if not Path(file).is_file():
        raise UsageError(f"there is no file {file}")
    suffix = Path(file).suffix
    if suffix == ".root" and not tree:
        raise UsageError(f"a ROOT file needs the name of a tree: {file}:TREE")
    if suffix not in (".npy", *_READERS):
        raise UsageError(f"{file}: events are read from .npy, .npz, .csv, .parquet, or .root:TREE")
    if (columns or time) and suffix == ".npy":
        raise UsageError(f"{file}: the columns of a .npy file have no names to choose from")
    try:
        when = None
        if suffix == ".npy":
            x = np.load(file, allow_pickle=False)
        else:
            wanted = [*(name for name in columns if name != time), *([time] if time else [])] if columns else None
            arrays = _READERS[suffix](file, tree, wanted)
            if time is not None:
                _chosen(file, list(arrays), [time])
                when = _seconds(arrays.pop(time), f"{file}: '{time}'")
                _chosen(file, list(arrays), None)
            if suffix == ".npz" and len(arrays) == 1:
                (x,) = arrays.values()
            elif suffix == ".npz" and columns is None:
                raise UsageError(f"{file} holds several arrays, choose by --columns: {', '.join(arrays)}")
            else:
                x = _stack(file, arrays)
    except UsageError:
        raise
    except Exception as error:  # every reader has its own exceptions, and a damaged file may raise any
        if "allow_pickle" in str(error):
            raise UsageError(f"{file} is no plain array; it may hold pickled objects, which could run code") from error
        raise UsageError(f"{file} cannot be read: {type(error).__name__}: {error}") from error
    if x.dtype == bool:
        x = x.astype(np.uint8)
    if not (np.issubdtype(x.dtype, np.integer) or np.issubdtype(x.dtype, np.floating)):
        raise UsageError(f"{file} holds {x.dtype} instead of real numbers")
    if x.ndim == 0:
        raise UsageError(f"{file} holds a single number")
    if when is not None and len(when) != len(x):
        raise UsageError(f"{file}: the columns differ in length")
    return x.reshape(len(x), math.prod(x.shape[1:])), when


def _read_npz(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    with np.load(file, allow_pickle=False) as arrays:
        return {name: arrays[name] for name in _chosen(file, arrays.files, columns)}


def _read_csv(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    first = pd.read_csv(file, header=None, nrows=1, dtype=str).iloc[0]
    empty = first.isna() | first.str.strip().str.lower().isin(("nan", ""))
    named = pd.to_numeric(first[~empty], errors="coerce").isna().any()
    frame = pd.read_csv(file, header=0 if named else None)
    if columns and not named:
        raise UsageError(f"{file} has no line of column names to choose from")
    return _frame(file, frame, columns)


def _read_parquet(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    return _frame(file, pd.read_parquet(file), columns)


def _read_root(file: str, tree: str, columns: list[str] | None) -> dict[str, NDArray]:
    try:
        import uproot
    except ModuleNotFoundError as error:
        raise UsageError("ROOT files need uproot, which is not installed: pip install 'avobench[root]'") from error
    with uproot.open(file) as opened:
        trees = [
            name.partition(";")[0] for name, kind in opened.classnames().items() if kind in ("TTree", "ROOT::RNTuple")
        ]
        if tree not in trees:
            raise UsageError(f"{file} has no tree '{tree}'; it has: {', '.join(dict.fromkeys(trees)) or 'none'}")
        names = _chosen(file, opened[tree].keys(), columns)
        arrays = opened[tree].arrays(names, library="np")
    return {name: arrays[name] for name in names}  # uproot has an order of its own


_READERS: dict[str, Callable[[str, str, list[str] | None], dict[str, NDArray]]] = {
    ".npz": _read_npz,
    ".csv": _read_csv,
    ".parquet": _read_parquet,
    ".root": _read_root,
}


def _frame(file: str, frame: pd.DataFrame, columns: list[str] | None) -> dict[str, NDArray]:
    frame = frame[_chosen(file, list(frame.columns), columns)]
    return {str(name): values.to_numpy() for name, values in frame.items()}


def _chosen(file: str, names: list, columns: list[str] | None) -> list:
    missing = [name for name in columns or [] if name not in names]
    if missing:
        raise UsageError(f"{file} has no {', '.join(missing)}; it has: {', '.join(map(str, names))}")
    if not names:
        raise UsageError(f"{file} holds nothing")
    return names if columns is None else columns


def _stack(file: str, arrays: dict[str, NDArray]) -> NDArray:
    """One-dimensional arrays of numbers side by side: (n, d)."""
    for name, values in arrays.items():
        if values.ndim != 1 or values.dtype.kind not in "biuf":
            raise UsageError(f"{file}: '{name}' does not hold one real number an event")
    if len({len(values) for values in arrays.values()}) > 1:
        raise UsageError(f"{file}: the columns differ in length")
    return np.stack(list(arrays.values()), axis=1)


def _seconds(time: NDArray, what: str) -> NDArray[np.float64]:
    """Times (n,) as numbers: dates as seconds since 1970, of UTC where they name no zone; NaN where one is missing."""
    if time.ndim == 1 and time.dtype.kind in "biuf":
        return time.astype(float)
    try:
        dates = pd.to_datetime(pd.Series(time), format="ISO8601", utc=True)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{what} holds neither a number nor a date such as 2012-07-04T09:00 for each event") from error
    return ((dates - pd.Timestamp(0, tz="UTC")) / pd.Timedelta(seconds=1)).to_numpy(float)


def check_events(
    task: Task, x: ArrayLike, *, drop_invalid: bool = False, diagnosis: bool = True
) -> tuple[NDArray, list[str]]:
    """The events (n, d), or (n,) of one number each, as an array (n, d) of the task's type, and warnings.

    Raises UsageError where an inference would be meaningless: no numbers, another number of columns, rows that are not
    finite (unless `drop_invalid` drops them), fractions for counts, none at all, numbers beyond 2^53, or a feature of
    which most values lie far from all that the simulator makes. A `diagnosis` also takes neither fewer than MIN_EVENTS
    nor a feature of which all values are alike. Real numbers that happen to be whole are taken: rounding is an effect.
    Raises SimulatorError for a task whose simulator does not make what it declares.
    """
    x = np.asarray(x)
    x = x[:, None] if x.ndim == 1 else x
    if x.dtype.kind not in "biuf":
        raise UsageError(f"events must be real numbers, got {x.dtype}")
    if x.ndim != 2 or x.shape[1] != task.num_features:
        got = x.shape[1] if x.ndim == 2 else f"an array of shape {x.shape}"
        raise UsageError(f"an event of {task.name} has {task.num_features} columns, the data have {got}")
    warnings = []
    void = ~np.isfinite(x).any(axis=0)
    if len(x) and void.any() and not task.event_shape:
        names = ", ".join(name for name, each in zip(task.labels, void, strict=True) if each)
        raise UsageError(f"all values of {names} are NaN or infinite; choose a column that holds it, by --columns")
    finite = np.isfinite(x).all(axis=1)
    if not finite.all():
        count = f"{(~finite).sum()} of {len(x)} rows hold NaN or infinite values"
        if not drop_invalid:
            raise UsageError(f"{count}; mend them, or drop them with --drop-invalid")
        warnings.append(f"{count} and were dropped")
        x = x[finite]
    least = MIN_EVENTS if diagnosis else 1
    if len(x) < least:
        raise UsageError(f"{len(x)} events are too few, at least {least} are needed")
    if x.max() > LARGEST or x.min() < -LARGEST:
        largest = x.max() if x.max() > LARGEST else x.min()
        raise UsageError(f"the data reach to {largest:.3g}, beyond 2^53 numbers are not exact; give another unit")
    whole = np.issubdtype(np.dtype(task.dtype), np.integer)
    counts = np.array([whole or kind == "count" for kind in task.kinds_of_features])
    fractions = counts & (x != np.rint(x))
    if broken := int(fractions.any(axis=1).sum()):
        names = [name for name, some in zip(task.labels, fractions.any(axis=0), strict=True) if some]
        what = "" if counts.all() else f" of {', '.join(names)}"
        raise UsageError(f"{task.name} makes whole numbers{what}, {broken} of {len(x)} rows hold fractions")
    warnings += _outside(task, x, diagnosis)
    if task.event_shape or set(task.kinds_of_features) != {"count"}:
        repeated = num_repeated(x)
        if repeated > MANY_REPEATS * len(x):
            warnings.append(
                f"{repeated} of {len(x)} events repeat an earlier one: unless the values were rounded, "
                "repeated events falsify every test"
            )
    return _cast(task, x), warnings


def num_repeated(x: NDArray) -> int:
    """The number of events (n, d) that repeat an earlier one. A hash of 64 bits stands for each, to save memory."""
    return int(pd.util.hash_pandas_object(pd.DataFrame(x + 0), index=False).duplicated().sum())  # -0 + 0 is 0


def with_times(
    x: ArrayLike, time: ArrayLike, *, drop_invalid: bool = False
) -> tuple[NDArray, NDArray[np.float64], list[str]]:
    """Events (n, ...) and their times (n,), without rows that are not finite if `drop_invalid` says so; and warnings.

    Times are numbers or dates. Raises UsageError for others, for times that are not one an event, not finite, or all
    alike.
    """
    x, time = np.asarray(x), np.asarray(time)
    if time.shape != x.shape[:1]:
        raise UsageError(f"times must be one number for each of {len(x)} events, got {time.dtype} {time.shape}")
    time, warnings = _seconds(time, "time"), []
    keep = np.isfinite(time)
    if not keep.all():
        count = f"{(~keep).sum()} of {len(time)} times are NaN or infinite"
        if not drop_invalid:
            raise UsageError(f"{count}; mend them, or drop them with --drop-invalid")
        warnings.append(f"{count}, and their events were dropped")
    if drop_invalid and x.dtype.kind == "f":
        keep &= np.isfinite(x.reshape(len(x), -1)).all(axis=1)
    if len(np.unique(time[keep])) < 2:
        raise UsageError("all times are alike: they say nothing of the order")
    return x[keep], time[keep], warnings


def _cast(task: Task, x: NDArray) -> NDArray:
    """The events in the task's type, or a wider one where that does not hold the values."""
    dtype = np.dtype(task.dtype)
    if np.issubdtype(dtype, np.integer) and not np.iinfo(dtype).min <= x.min() <= x.max() <= np.iinfo(dtype).max:
        dtype = np.dtype(np.int64)
    return x.astype(dtype)


def _outside(task: Task, x: NDArray, diagnosis: bool = True) -> list[str]:
    """A sentence for each feature with values where the simulator makes none, whatever theta of its prior.

    The features of an image are taken together. Raises UsageError where most values lie FAR outside, or, for a
    `diagnosis`, where those of either side do not differ; SimulatorError where the simulator fails.
    """
    rng = np.random.default_rng(0)
    theta = task.prior.sample(NUM_REFERENCE // (10 if task.event_shape else 1), rng)
    # Where theta is at an end of the prior there are values that few others make: each coordinate is there for a third.
    end = rng.integers(-1, 2, theta.shape)
    theta = np.where(end == 0, theta, np.where(end < 0, task.prior.low, task.prior.high))
    simulated = checked_events(task, theta, rng)
    if task.event_shape:
        features = [("cells", simulated.ravel(), x.ravel())]
    else:
        features = list(zip(task.labels, simulated.T, x.T, strict=True))
    sentences = []
    for name, made, values in features:
        low, high = float(made.min()), float(made.max())
        width = high - low
        if diagnosis and width == 0:
            raise UsageError(
                f"the simulator makes {low:g} for every value of {name}; a diagnosis needs one that varies"
            )
        if diagnosis and 0 < np.ptp(values) < ALIKE * width:
            raise UsageError(
                f"all values of {name} are {np.median(values):.4g}, nearly at one place of what the simulator makes, "
                f"{low:.4g} to {high:.4g}; are they in another unit?"
            )
        below, above = _reach(made, len(values))
        count = int(((values < below) | (values > above)).sum())
        if count > len(values) / 2 and np.median(np.maximum(low - values, values - high)) > FAR * width > 0:
            raise UsageError(
                f"most values of {name} lie more than {FAR} times the width of {low:.4g} to {high:.4g} outside of it, "
                "where the simulator makes its events; are they another quantity, or in another unit?"
            )
        if diagnosis and values.min() == values.max():
            raise UsageError(f"all values of {name} are {values[0]:g}; a diagnosis needs values that differ")
        if count:
            sentences.append(
                f"{count} values of {name} lie outside {low:.4g} to {high:.4g}, where the simulator makes its events "
                f"(they reach from {values.min():.4g} to {values.max():.4g}); this may itself be the disagreement"
            )
    return sentences


def _reach(made: NDArray, n: int) -> tuple[float, float]:
    """How far down and up n values may reach by chance, if they are like simulated ones (m,).

    From the last thousandth of the simulated ones to their end a tail grows by some factor about the median. It grows
    by the same again each time that as many times more values are drawn, at most: that is how a power falls, and all
    others fall faster. Where values crowd at an end, as a cosine does at 1, the factor is 1, and the range ends there.
    """
    low, near_low, middle, near_high, high = (float(q) for q in np.quantile(made, [0, TAIL, 0.5, 1 - TAIL, 1]))
    again = max(np.log(n / BY_CHANCE / len(made)) / np.log(TAIL * len(made)), 0)
    ends = []
    for near, end in ((near_low, low), (near_high, high)):
        grown = (end - middle) / (near - middle) if near != middle else 1.0
        ends.append(middle + (end - middle) * grown**again)
    return ends[0], ends[1]
