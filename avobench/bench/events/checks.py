"""Faults of measured events, or of the simulator, are told before anything is inferred from them."""

import re
from collections import Counter
from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.bench.events.files import seconds
from avobench.effects.contract import Simulate
from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.copies import copies
from avobench.tasks.errors import SimulatorError, UsageError, if_uneven
from avobench.tasks.sample import SampleTask

MIN_EVENTS = 200
"""A diagnosis needs so many: fewer fill no bins in which an effect could be told from another."""
LARGEST = 2.0**53
"""Double precision does not tell a whole number beyond this from the next."""
SMALLEST = 1e-30
"""Methods that count in single precision lose numbers below this."""
FAR = 100
"""A value that lies so many widths of what the simulator makes outside of it is another quantity."""
ALIKE = 1e-12
"""Values that differ by less than this share of the width of what the simulator makes lie at one place in it."""
NUM_REFERENCE = 20_000
"""So many simulated events tell which values the simulator can make; a tenth of it does for images."""
FEW_REFERENCE = 4000
"""So many of them do for few measured events: more are made only where more are measured."""
LEAST_REFERENCE = 100
"""Fewer simulated events do not tell which values the simulator can make."""
STARTED = 100
"""Thetas of these, at most, where a simulator must be started for each; the tails are then known less well."""
SHARE = 20
"""The checks take one in so many of the simulated events that are allowed, at most."""
CERTAIN = 1e-9
"""A p-value below this is no chance, in whatever many runs of an honest simulator."""
TAIL = 0.001
"""A tail is what lies beyond all but this share of the simulated values, and beyond ten of them at least."""
BY_CHANCE = 0.01
"""The probability that the largest of all measured values lies beyond the range though the simulator made it."""
TRUTH = "truth values are taken as 0 and 1"
MANY_REPEATS = 0.01
"""A larger share of repeated events is worth a warning."""


def check_events(
    task: Task,
    x: ArrayLike,
    *,
    drop_invalid: bool = False,
    diagnosis: bool = True,
    made: Callable[[], NDArray] | None = None,
) -> tuple[NDArray, list[str]]:
    """The events (n, d), or (n,) of one number each, as an array (n, d) of the task's type, and warnings.

    Where a table of events and the task both name their columns, the names say which is which. Raises UsageError where
    an inference would be meaningless: no numbers, another number of columns, rows that are not finite (unless
    `drop_invalid` drops them), fractions for counts, none at all, numbers beyond 2^53, or a feature of which most
    values lie far from all that the simulator makes. A `diagnosis` also takes neither fewer than MIN_EVENTS nor a
    feature of which all values are alike. Real numbers that happen to be whole are taken: rounding is an effect.
    Raises SimulatorError for a task whose simulator does not make what it declares, or breaks the contract.

    `made` gives events as those of `reference`; NUM_REFERENCE are simulated where it is None. Where it gives none, a
    warning says so.
    """
    x, warnings = by_name(task, x)
    x, dropped = _finite(task, x[:, None] if x.ndim == 1 else x, drop_invalid)
    least = MIN_EVENTS if diagnosis else 1
    if len(x) < least:
        raise UsageError(f"{len(x)} events are too few, at least {least} are needed; a row is an event, not a bin")
    _require_exact(task, x)
    warnings += dropped
    simulated = made() if made else reference(task, partial(checked_events, task), NUM_REFERENCE)
    if len(simulated):
        warnings += _outside(task, x, simulated, diagnosis)
    else:
        warnings.append(
            f"the events were not compared with what the simulator makes: {SHARE * LEAST_REFERENCE} simulated events "
            "would allow it"
        )
    if isinstance(task, SampleTask) and task.worth < 1:
        n = len(task.events)
        warnings.append(f"{n} simulated events with weights or copies are worth {n * task.worth:.0f} of equal weight")
    if task.event_shape or set(task.kinds_of_features) != {"count"}:
        repeated = num_repeated(x)
        if repeated > MANY_REPEATS * len(x):
            message = f"{repeated} of {len(x)} events repeat an earlier one"
            if diagnosis and not task.event_shape and copies(x, x[:, :0]) is not None:
                raise UsageError(f"{message}, which no rounding of values explains; drop the copies")
            warnings.append(f"{message}: unless the values were rounded, repeated events falsify every test")
    return _cast(task, x), warnings


def _finite(task: Task, x: NDArray, drop_invalid: bool) -> tuple[NDArray, list[str]]:
    """The events that are real numbers (n, d), and what was dropped. Raises UsageError where some are not."""
    if x.dtype.kind not in "biuf":
        raise UsageError(f"events must be real numbers, got {x.dtype}")
    if x.ndim != 2 or x.shape[1] != task.num_features:
        got = x.shape[1] if x.ndim == 2 else f"an array of shape {x.shape}"
        raise UsageError(f"an event of {task.name} has {task.num_features} columns, the data have {got}")
    void = ~np.isfinite(x).any(axis=0)
    if len(x) and void.any() and not task.event_shape:
        names = ", ".join(name for name, each in zip(task.labels, void, strict=True) if each)
        raise UsageError(f"all values of {names} are NaN or infinite; choose a column that holds it")
    finite = ~task.broken(x)
    if finite.all():
        return x, []
    count = f"{(~finite).sum()} of {len(x)} rows hold NaN or infinite values"
    if not drop_invalid:
        raise UsageError(f"{count}; mend them, drop them (drop_invalid), or say which features may be `missing`")
    return x[finite], [f"{count} and were dropped"]


def _require_exact(task: Task, x: NDArray) -> None:
    """Raise UsageError for numbers beyond 2^53, or all below SMALLEST, and for fractions of counts."""
    largest = max(float(np.nanmax(x)), float(np.nanmin(x)), key=abs)
    if abs(largest) > LARGEST:
        raise UsageError(f"the data reach to {largest:.3g}, beyond 2^53 numbers are not exact; give another unit")
    if 0 < abs(largest) < SMALLEST:
        raise UsageError(f"the data reach to {largest:.3g} only, too little for single precision; give another unit")
    whole = np.issubdtype(np.dtype(task.dtype), np.integer)
    counts = np.array([whole or kind == "count" for kind in task.kinds_of_features])
    fractions = counts & (x != np.rint(x)) & ~np.isnan(x)
    if broken := int(fractions.any(axis=1).sum()):
        names = [name for name, some in zip(task.labels, fractions.any(axis=0), strict=True) if some]
        what = "" if counts.all() else f" of {', '.join(names)}"
        raise UsageError(f"{task.name} makes whole numbers{what}, {broken} of {len(x)} rows hold fractions")


def _as_meant(names: list[str], features: list[str]) -> list[str]:
    """The names of columns, where one is that of a feature but for capitals, spaces or a unit in brackets."""

    def plain(name: str) -> str:
        return re.sub(r"[\s_]|[\[(][^\[(]*[\])]\s*$", "", name).casefold()

    lacking = Counter(plain(name) for name in features if name not in names)
    rest = Counter(plain(name) for name in names if name not in features)
    alike = {plain(name): name for name in features if lacking[plain(name)] == rest[plain(name)] == 1}
    return [name if name in features else alike.get(plain(name), name) for name in names]


def by_name(task: Task, x: ArrayLike) -> tuple[NDArray, list[str]]:
    """The columns of events in the order of the features of `task`, as an array, and remarks. Raises UsageError."""
    if not isinstance(x, pd.DataFrame):
        if np.ma.is_masked(x):
            raise UsageError(f"{np.ma.count_masked(x)} values of the events are masked; drop their rows, or fill them")
        try:
            return _counted(np.asarray(x))
        except ValueError as error:
            raise UsageError(f"the rows of the events differ in length{if_uneven(x)}") from error
    given, wanted = [str(name) for name in x.columns], list(task.labels)
    names = _as_meant(given, wanted)
    remarks = [f"{a} is taken as {b}" for a, b in zip(given, names, strict=True) if a != b]
    if set(wanted) <= set(names):
        extra = [name for name in names if name not in wanted]
        remarks += [f"{', '.join(map(repr, extra))} is no feature of {task.name} and was left out"] if extra else []
        x = x.set_axis(names, axis=1)[wanted]
    elif task.feature_names and set(wanted) & set(names):
        missing = [name for name in wanted if name not in names]
        raise UsageError(f"the data have no {', '.join(missing)}; they have: {', '.join(names)}")
    elif len(names) != task.num_features:
        raise UsageError(
            f"an event of {task.name} has {task.num_features} features, {', '.join(task.labels)}, and the data have "
            f"{len(names)} columns: {', '.join(names)}; choose by name which are meant"
        )
    elif not task.event_shape and len(names) > 1 and list(x.columns) != list(range(len(names))):
        remarks = [f"the columns {', '.join(names)} are taken as {', '.join(wanted)}, in this order"]
    for name, column in x.items():
        if not pd.api.types.is_numeric_dtype(column) or pd.api.types.is_complex_dtype(column):
            raise UsageError(f"the column {name} holds {column.dtype} instead of real numbers{if_uneven(column)}")
    truth = [name for name, column in x.items() if pd.api.types.is_bool_dtype(column)]
    if truth and len(truth) < len(x.columns):
        remarks.append(f"{', '.join(truth)}: {TRUTH}")
    kinds = {pd.api.types.is_float_dtype(column) or column.hasnans for _, column in x.items()}
    x, more = _counted(x.to_numpy(float if kinds == {True} or len(kinds) > 1 else None))
    return x, remarks + more


def _counted(x: NDArray) -> tuple[NDArray, list[str]]:
    """Truth values as 0 and 1, and a sentence that says so; all else as it is."""
    return (x.astype(np.int64), [TRUTH]) if x.dtype.kind == "b" else (x, [])


def num_repeated(x: NDArray) -> int:
    """The number of events (n, d) that repeat an earlier one. A hash of 64 bits stands for each, to save memory."""
    return int(pd.util.hash_pandas_object(pd.DataFrame(x + 0), index=False).duplicated().sum())  # -0 + 0 is 0


def with_times(
    x: ArrayLike, time: ArrayLike, *, drop_invalid: bool = False
) -> tuple[NDArray, NDArray[np.float64], list[str]]:
    """Events (n, ...) and their times (n,), without those of no finite time if `drop_invalid` says so; and warnings.

    Times are numbers or dates. Which events are valid their task alone knows, see `valid`. Raises UsageError for other
    times, and for those that are not one an event, not finite, or all alike.
    """
    try:
        x, time = x if isinstance(x, pd.DataFrame) else np.asarray(x), np.asarray(time)
    except ValueError as error:
        raise UsageError("events and their times must be arrays, with rows of one length") from error
    if time.shape != x.shape[:1]:
        raise UsageError(f"times must be one number for each of {len(x)} events, got {time.dtype} {time.shape}")
    time, warnings = seconds(time, "time"), []
    keep = np.isfinite(time)
    if not keep.all():
        count = f"{(~keep).sum()} of {len(time)} times are NaN or infinite"
        if not drop_invalid:
            raise UsageError(f"{count}; mend them, or drop them (drop_invalid)")
        warnings.append(f"{count}, and their events were dropped")
    require_order(time[keep])
    return x[keep], time[keep], warnings


def require_order(time: NDArray[np.float64]) -> None:
    """Raise UsageError for times (n,) that are all alike."""
    if len(np.unique(time)) < 2:
        raise UsageError("all times are equal, so that the order of the events cannot be tested")


def valid(task: Task, x: ArrayLike) -> NDArray[np.bool_]:
    """Which rows of events that `check_events` takes it keeps where it drops those that are not finite: (n,)."""
    x, _ = by_name(task, x)
    return ~task.broken(x[:, None] if x.ndim == 1 else x)


def _cast(task: Task, x: NDArray) -> NDArray:
    dtype = np.dtype(task.dtype)
    if np.issubdtype(dtype, np.integer) and not np.iinfo(dtype).min <= x.min() <= x.max() <= np.iinfo(dtype).max:
        dtype = np.dtype(np.int64)
    return x.astype(dtype)


def reference(task: Task, simulate: Simulate, num_events: int) -> NDArray:
    """Events over the prior, and as many at its ends (n, d), which show that the simulator keeps its contract.

    They are `num_events`, or NUM_REFERENCE where this is less; none where they were fewer than LEAST_REFERENCE. Two
    calls have the same parameters but for the first row. Raises SimulatorError where they give the same events, as of a
    seed within the simulator, or other distributions, as where one row's parameters serve all.
    """
    from scipy.stats import ks_2samp  # here, because SciPy's statistics take a second to load

    num_events = min(num_events, NUM_REFERENCE // (10 if task.event_shape else 1))
    if num_events < LEAST_REFERENCE:
        return np.empty((0, task.num_features), task.dtype)
    rng = np.random.default_rng(0)
    theta = task.prior.sample(num_events // 2, rng)
    # Where theta is at an end of the prior there are values that few others make: each coordinate is there for a third
    # of every second row. These thetas are also the first ones of any larger number, so that a bank has them.
    end = np.random.default_rng(1).integers(-1, 2, theta[1::2].shape)
    theta[1::2] = np.where(end == 0, theta[1::2], np.where(end < 0, task.prior.low, task.prior.high))
    if getattr(task, "per_theta", False):
        theta = theta[np.arange(len(theta)) % STARTED]
    halves = []
    for first in (task.prior.low, task.prior.high):
        theta[0] = first
        halves.append(simulate(theta, rng))
    one, other = (half[1:] for half in halves)
    # Where a call is for one theta, the first row is one more event of it, which moves its other ones.
    moved = np.any([(theta[1:] == end).all(axis=1) for end in (task.prior.low, task.prior.high)], axis=0)
    if np.array_equal(one[~moved], other[~moved], equal_nan=True) and len(np.unique(one[~moved], axis=0)) > 1:
        raise SimulatorError(
            f"the simulator of {task.name} makes the same events in each call; take all randomness from the generator "
            "that it is given"
        )
    pairs = [(one.sum(axis=1), other.sum(axis=1))] if task.event_shape else zip(one.T, other.T, strict=True)
    recorded = [[each[~np.isnan(each)] for each in pair] for pair in pairs]
    if any(len(a) and len(b) and ks_2samp(a, b, method="asymp").pvalue < CERTAIN for a, b in recorded):
        raise SimulatorError(
            f"the events of {task.name} depend on the parameters of the first row; each row of theta must make its own "
            "event"
        )
    return np.concatenate([x[k::2] for k in (0, 1) for x in halves])


def _outside(task: Task, x: NDArray, simulated: NDArray, diagnosis: bool = True) -> list[str]:
    """A sentence for each feature with values where the `simulated` events (m, d) have none.

    The features of an image are taken together. Raises UsageError where most values lie FAR outside, or, for a
    `diagnosis`, where those of one side differ and those of the other do not.
    """
    if task.event_shape:
        features = [("cells", simulated.ravel(), x.ravel())]
    else:
        features = list(zip(task.labels, simulated.T, x.T, strict=True))
    sentences = []
    for j in task.missing:
        name, lacking = task.labels[j], [np.isnan(each[:, j]) for each in (x, simulated)]
        shares = [f"{100 * each.mean():.3g} %" for each in lacking]
        sentences.append(f"{name} is missing in {shares[0]} of the events, and in {shares[1]} of simulated ones")
        if lacking[1].all():
            raise UsageError(f"the simulator never makes a value of {name}, which it says may be missing")
    features = [(name, *(each[~np.isnan(each)] for each in both)) for name, *both in features]
    for name, made, values in features:
        low, high = float(made.min()), float(made.max())
        width = high - low
        if diagnosis and width == 0:
            raise UsageError(
                f"the simulator makes {low:g} for every value of {name}; a diagnosis needs one that varies"
            )
        if diagnosis and 0 < np.ptp(values) < ALIKE * width:
            raise UsageError(
                f"all values of {name} are close to {np.median(values):.4g}, and the simulator makes values from "
                f"{low:.4g} to {high:.4g}; are they in another unit?"
            )
        below, above = _reach(made, len(values))
        count = int(((values < below) | (values > above)).sum())
        if count > len(values) / 2 and np.median(np.maximum(low - values, values - high)) > FAR * width > 0:
            raise UsageError(
                f"the simulator makes {name} from {low:.4g} to {high:.4g}, and most values lie more than {FAR} times "
                "this width outside; are they another quantity, or in another unit?"
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
    """The limits down and up to which n values may reach by chance, if they are like simulated ones (m,).

    From the last thousandth of the simulated ones to their end a tail grows by some factor about the median. It grows
    by the same again each time that as many times more values are drawn, at most: that is how a power falls, and all
    others fall faster. Where values crowd at an end, as a cosine does at 1, the factor is 1, and the range ends there.
    """
    tail = max(TAIL, 10 / len(made))
    low, near_low, middle, near_high, high = (float(q) for q in np.quantile(made, [0, tail, 0.5, 1 - tail, 1]))
    again = max(np.log(n / BY_CHANCE / len(made)) / np.log(tail * len(made)), 0)
    ends = []
    for near, end in ((near_low, low), (near_high, high)):
        grown = (end - middle) / (near - middle) if near != middle else 1.0
        ends.append(middle + (end - middle) * grown**again)
    return ends[0], ends[1]
