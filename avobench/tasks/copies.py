"""Copies of events within a sample, as a bootstrap or hit-or-miss leaves them, told from values that were rounded."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

REPEATED = 0.3
"""There are copies where more than this share of the distinct events is repeated; a bootstrap repeats 0.42."""
FEW = 400
"""Fewer distinct events do not tell copies from rounded values."""
SAME = 1e-14
"""Values that differ by a smaller share lie at one place of a grid, computed in two ways."""
ALL_APART = 0.99
"""Fewer values than this share that lie apart from others are no random ones."""
LAG = 20
"""Steps between distinct values whose lengths are compared."""
RANDOM = 0.7
"""Steps vary so much of what they do between random values, at least; of a grid with as many repeats 0.5 at most."""
BLOCKS = 8
"""Parts of the range of a feature, of equal numbers of events."""
EVEN = 2
"""In no part has an event more than so many times the copies that it has in another."""


def copies(x: NDArray, theta: NDArray[np.float64]) -> NDArray[np.intp] | None:
    """A number for each of events x (n, d), made at theta (n, p), that its copies share: (n,). None without copies.

    Whole numbers repeat by themselves, and so do values that were rounded to a grid, or to several. Then the distinct
    values lie at steps that are more even than random ones, or an event is repeated more often where events are dense.
    Events are copies only where one of their features shows neither.
    """
    if x.dtype.kind != "f":
        return None
    rows = pd.util.hash_pandas_object(pd.DataFrame(np.c_[theta, x] + 0), index=False)  # -0 + 0 is 0
    _, first, source, counts = np.unique(rows, return_index=True, return_inverse=True, return_counts=True)
    if len(first) < FEW or (counts > 1).mean() < REPEATED:
        return None
    return source if any(_shows_copies(values, counts) for values in x[first].T) else None


def _shows_copies(values: NDArray[np.float64], counts: NDArray[np.intp]) -> bool:
    """Whether values (m,) of a feature of distinct events, that came so often (m,), cannot come of rounding."""
    order = np.argsort(values)[: np.isfinite(values).sum()]  # NaN is last
    values, counts = values[order], counts[order]
    if len(values) < FEW or (values == np.rint(values)).all():
        return False
    apart = values[1:][np.diff(values) > SAME * np.abs(values[1:])]
    if len(apart) < ALL_APART * len(values):
        return False
    steps = apart[LAG:] - apart[:-LAG]
    variance = np.mean(np.log(steps[LAG:] / steps[:-LAG]) ** 2)
    part = BLOCKS * (np.cumsum(counts) - counts) // counts.sum()
    extra = np.bincount(part, counts - 1, BLOCKS) / np.maximum(np.bincount(part, minlength=BLOCKS), 1)
    return bool(variance > RANDOM * 2 / LAG and extra.max() <= EVEN * extra.min())
