"""Values that an event lacks, such as those of a detector that did not fire: NaN in features that may be missing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.contract import Task, twin


def filled(x: NDArray, seed: int = 0) -> NDArray:
    """Events (n, d) with a random one of the recorded values of a feature in place of each that is missing.

    So each feature by itself is as it was recorded, for whoever cannot use NaN. None is taken twice before all were
    once, so that it does not look as if values repeat. Zero where none was recorded.
    """
    lacking = np.isnan(x) if x.dtype.kind == "f" else np.zeros(x.shape, bool)
    if not lacking.any():
        return x
    x, rng = x.copy(), np.random.default_rng(seed)
    for j in np.flatnonzero(lacking.any(axis=0)):
        recorded = x[~lacking[:, j], j]
        x[lacking[:, j], j] = np.resize(rng.permutation(recorded), lacking[:, j].sum())
    return x


class Recorded:
    """A task without NaN, for methods that know none: each feature that may be missing has one more, 1 where it is.

    There the feature itself is the median of what was measured. So the joint distribution is kept, with how often
    and beside what a value is missing. A task of which nothing may be missing, and its events, are left as they are.
    """

    def __init__(self, task: Task, x: NDArray) -> None:
        """The features that `task` says may be missing, as they are in measured events x (n, d)."""
        self._columns = list(task.missing)
        self._fill = np.nanmedian(x, axis=0) if self._columns else None

    def events(self, x: NDArray) -> NDArray:
        """Events (n, d) with NaN -> (n, d + k) without."""
        if not self._columns:
            return x
        lacking = np.isnan(x[:, self._columns])
        return np.hstack([np.where(np.isnan(x), self._fill, x), lacking])

    def bare(self, x: NDArray) -> NDArray:
        """The inverse of `events`."""
        k, x = len(self._columns), x.copy()
        x[:, self._columns] = np.where(x[:, -k:] == 1, np.nan, x[:, self._columns])
        return x[:, :-k]

    def task(self, task: Task) -> Task:
        """A twin of the task that makes such events."""
        if not self._columns:
            return task
        more = tuple(f"{task.labels[j]} is missing" for j in self._columns)
        return twin(
            task,
            num_features=task.num_features + len(more),
            feature_names=(*task.labels, *more),
            feature_kinds=(*task.kinds_of_features, *["continuous"] * len(more)),
            feature_units=task.feature_units and (*task.feature_units, *["1"] * len(more)),
            missing=(),
            simulate=lambda theta, rng: self.events(task.simulate(theta, rng)),
            summary=lambda x: np.r_[task.summary(self.bare(x)), x[:, task.num_features :].mean(axis=0)],
            with_reference=lambda x: self.task(task.with_reference(self.bare(x))),
        )


def missing_in_both(simulated: ArrayLike, measured: ArrayLike) -> list[str]:
    """The features of two samples that hold NaN in both, by the names of columns or as x1, x2, ..."""
    a, b = (_lacking(x) for x in (simulated, measured))
    return [name for name in a if name in b]


def _lacking(x: ArrayLike) -> list[str]:
    if hasattr(x, "columns"):
        return [str(name) for name, column in x.items() if column.isna().any()]
    try:
        x = np.asarray(x)
    except ValueError:  # rows of different lengths are refused where they are read
        return []
    if x.dtype.kind != "f" or x.ndim not in (1, 2):
        return []
    x = x[:, None] if x.ndim == 1 else x
    return [f"x{j + 1}" for j in np.flatnonzero(np.isnan(x).any(axis=0))]
