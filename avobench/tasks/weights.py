"""Weighted events: how many of equal weight they are worth, and the same events without weights."""

from collections.abc import Sequence
from typing import Any
from warnings import warn

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.arguments import checked, distinct, numbers
from avobench.tasks.errors import UsageError, whole

NEIGHBOURS = 32
"""So many events next to one of negative weight are looked up at first; most cells are smaller."""


def weights_of(what: str, weights: ArrayLike, n: int) -> NDArray[np.float64]:
    """The weights of n events as an array (n,). Raises UsageError, which names `what`, for what are none."""
    w = numbers(f"the weights of {what}", weights).astype(float)
    if w.shape != (n,):
        raise UsageError(f"{n} {what} need as many weights, got {w.shape}")
    if not w.any():
        raise UsageError(f"all weights of {what} are zero")
    return w


def column(table: Any, name: str) -> NDArray:
    """A column of a table. Raises UsageError, with the names that there are, where it has none of this name."""
    names = getattr(table, "columns", ())
    if name not in names:
        raise UsageError(f"there is no column '{name}'; the columns are {', '.join(map(str, names)) or 'none'}")
    return table[name].to_numpy()


def named(table: Any) -> tuple[str, ...]:
    """The names of the columns of a table; none where they are only numbered. Raises UsageError for two of one name."""
    if all(isinstance(each, int) for each in table.columns):
        return ()
    distinct("columns of the simulated events", table.columns)
    return tuple(map(str, table.columns))


def chosen(table: Any, names: Sequence[str]) -> Any:
    """The columns of a table that have these names, in this order; all where none is given, or columns have no names.

    Raises UsageError as `column` does.
    """
    if not len(names) or all(isinstance(each, int) for each in table.columns):
        return table
    for name in names:
        column(table, name)
    return table[list(names)]


def effective(w: NDArray[np.float64]) -> float:
    """How many events of equal weight tell as much as these, of weights w (n,): (sum w)^2 / sum w^2."""
    return float(w.sum() ** 2 / (w**2).sum())


def without_negative(x: NDArray, w: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights (n,) of events x (n, d) of which none is negative, by cell resampling.

    An event of negative weight and its nearest neighbours, as many as it takes for their sum not to be negative, form
    a cell. Each of them gets its share of this sum by the size of its weight. So sums change over no region that is
    large against the cells (J. R. Andersen, A. Maier, Eur. Phys. J. C 82 (2022) 433). Distances are those of the ranks
    of each feature; a missing value is next to other missing ones. The sum of all weights must be positive.
    """
    from scipy.spatial import cKDTree

    if not len(negative := np.flatnonzero(w < 0)):
        return w
    # Equal values have ranks one after the other, so that no place holds many events.
    ranks = pd.DataFrame(x).rank(method="first", na_option="top").to_numpy() / len(x)
    tree, w = cKDTree(ranks), w.copy()
    near = tree.query(ranks[negative], range(1, min(NEIGHBOURS, len(x)) + 1))[1]
    for i, cell in zip(negative[order := np.argsort(w[negative])], near[order], strict=True):
        if w[i] >= 0:  # it was in the cell of another one
            continue
        while (sums := np.cumsum(w[cell])).max() < 0:
            cell = tree.query(ranks[i], range(1, min(4 * len(cell), len(x)) + 1))[1]
        cell = cell[: np.argmax(sums >= 0) + 1]
        sizes = np.abs(w[cell])
        w[cell] = sizes * max(sums[len(cell) - 1], 0) / sizes.sum()
    return w


def drawn(w: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.intp]:
    """The rows that weights w (n,), none negative, draw n times, in random order: each as often as its share says."""
    steps = (np.arange(len(w)) + rng.random()) / len(w)
    rows = np.searchsorted(np.cumsum(w) / w.sum(), steps)
    return rng.permutation(np.minimum(rows, len(w) - 1))


def effective_drawn(w: NDArray[np.float64], positive: NDArray[np.float64]) -> float:
    """How many events of equal weight tell as much as those drawn: n^2 over the sum of E[c^2], c copies of an event.

    An event's share k = n w / sum w of the rows is rounded down or up to c, which is k on average, and f (1 - f) is the
    variance of c where f is the fraction of k. The `positive` weights (n,) are drawn, in place of those given, w (n,).
    """
    k, fraction = len(w) * w / w.sum(), len(w) * positive / positive.sum() % 1
    return float(len(w) ** 2 / (k**2 + fraction * (1 - fraction)).sum())


@checked
def unweighted(events: ArrayLike, weights: ArrayLike | str, *, seed: int = 0) -> NDArray | pd.DataFrame:
    """Measured events of which each is kept with a probability as its weight: a sample without weights.

    A warning tells how many are left, and how many of equal weight the weighted ones were worth: where these are many
    more, few large weights decide. Weights of simulated events are given to `avobench.bank`.

    Parameters
    ----------
    events
        Measured events: an array (N, d) or (N,), or a DataFrame.
    weights
        Weights of the events (N,), or the name of their column, which is left out then.
    seed
        Of the draw.

    Raises
    ------
    UsageError
        For weights that are negative, not finite, or all zero. What negative ones leave of a region is no number of
        events; a table of their sums has errors that say so.

    Examples
    --------
    >>> import pandas as pd
    >>> unweighted(pd.DataFrame({"energy": [1.0, 2.0, 3.0], "w": [1.0, 0.0, 1.0]}), "w")["energy"].tolist()
    [1.0, 3.0]
    """
    x = events if isinstance(events, pd.DataFrame) else numbers("the measured events", events)
    if isinstance(weights, str):
        weights, x = column(x, weights), x.drop(columns=weights)
    w = weights_of("measured events", weights, len(np.atleast_1d(x)))
    if (w < 0).any():
        raise UsageError(
            f"{(w < 0).sum()} weights of measured events are negative, and no sample has such: histogram them, and "
            "give avobench.Table(edges, sums, errors=root of the sums of squared weights, normalised=True, feature=...)"
        )
    kept = np.random.default_rng(whole("seed", seed, 0)).random(len(w)) * w.max() < w
    warn(
        f"{len(w)} measured events with weights are worth {effective(w):.0f} of equal weight; {kept.sum()} of them are "
        "kept, with probabilities in proportion to the weights",
        stacklevel=3,
    )
    return x[kept]
