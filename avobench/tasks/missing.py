"""Values that an event lacks, such as those of a detector that did not fire: NaN in features that may be missing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


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
