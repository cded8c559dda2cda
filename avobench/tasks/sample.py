"""A task from events that were simulated before: a sample is a simulator, at the parameters that it was made at."""

import hashlib
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avobench.tasks.arguments import box_of, checked, distinct, numbers, reals
from avobench.tasks.contract import Box, Task, histogram
from avobench.tasks.copies import copies
from avobench.tasks.errors import UsageError, whole
from avobench.tasks.weights import chosen, column, drawn, effective_drawn, weights_of, without_negative

ASIDE = 5
"""One in so many events of each theta is kept aside, for whoever needs events that nothing has learned from."""
DRAWS = 1000
"""Draws that tell of which nodes events at one theta are."""
LEAST = 200
"""Events at each theta, at least: fewer fill no bins."""


class SampleTask(Task):
    """A simulator whose events were all made before, at a few values of theta; made by `bank`.

    Between these nodes an event is one of a node around it, drawn with the weights of linear interpolation.
    """

    source = "a sample of simulated events"
    by_default = False

    def __init__(
        self,
        events: NDArray,
        theta: NDArray[np.float64],
        source: NDArray[np.intp],
        parameters: Sequence[str],
        features: Sequence[str],
        prior: Box,
        worth: float,
        total: float,
        name: str,
        missing: Sequence[str],
    ) -> None:
        """Events (M, d) without weights, in random order, at theta (M, p).

        Copies of one event have the same `source` (M,), a number without a meaning. Events with weights or copies were
        `worth` so many each, and their weights added up to a `total`.
        """
        self.name, self.events, self.worth, self.total = name, events, worth, total
        self.parameter_names, self.parameter_units = tuple(parameters), ("1",) * len(parameters)
        self.prior = self.support = prior
        self.num_features, self.dtype, self.feature_names = events.shape[1], events.dtype, tuple(features)
        self.missing = tuple(self.labels.index(one) for one in missing)
        self.nodes, which = np.unique(theta, axis=0, return_inverse=True)
        order = np.argsort(which, kind="stable")
        self.groups: list[NDArray[np.intp]] = []
        """The rows of the events of each node, but for those kept aside."""
        self.aside: list[NDArray[np.intp]] = []
        """The rows of those. They have no event in common with the others: all copies of one are on the same side."""
        for group in np.split(order, np.cumsum(np.bincount(which, minlength=len(self.nodes)))[:-1]):
            distinct = np.unique(source[group])
            aside = source[group] < distinct[len(distinct) // ASIDE]
            self.groups.append(group[~aside])
            self.aside.append(group[aside])
        self.sizes = np.array([len(group) for group in self.groups])
        """How many events of each node there are, but for those kept aside: (k,)."""
        self._grouped = np.concatenate(self.groups)
        self.num_aside = min(map(len, self.aside))
        """So many of them may be asked for at any theta, and none comes twice."""

    @property
    def parts(self) -> tuple[object, ...]:
        values = (self.events, self.nodes, self._grouped, self.sizes)
        return tuple(hashlib.sha256(each.tobytes()).hexdigest() for each in values)

    def corner(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.intp]:
        """The number of a random node around each row of theta: (n, p) -> (n,)."""
        n, p = theta.shape
        if len(self.nodes) == 1:
            return np.zeros(n, np.intp)
        at = self.scaled(theta)
        if p == 1:
            positions = self.scaled(self.nodes)[:, 0]  # in rising order
            above = np.clip(np.searchsorted(positions, at[:, 0]), 1, len(positions) - 1)
            share = (at[:, 0] - positions[above - 1]) / (positions[above] - positions[above - 1])
            return above - 1 + (share > rng.random(n))
        triangles = self._triangles
        simplex = triangles.find_simplex(at)
        inside = simplex >= 0
        corner = self._nearest.query(at)[1]
        transform = triangles.transform[simplex[inside]]
        weights = np.einsum("nij,nj->ni", transform[:, :p], at[inside] - transform[:, p])
        drawn = (np.cumsum(weights, axis=1) < rng.random((len(weights), 1))).sum(axis=1)
        corner[inside] = triangles.simplices[simplex[inside], drawn]
        return corner

    def corners(self, theta: NDArray[np.float64]) -> NDArray[np.intp]:
        """The numbers of the nodes around theta (p,), or of some at the nearest node where it is outside: (p + 1,)."""
        at = self.scaled(theta)
        if len(theta) == 1:
            order = np.argsort(self.scaled(self.nodes)[:, 0])
            above = np.clip(np.searchsorted(self.scaled(self.nodes)[order, 0], at[0]), 1, len(order) - 1)
            return order[[above - 1, above]]
        simplex = int(self._triangles.find_simplex(at))
        if simplex < 0:
            simplex = int(self._triangles.vertex_to_simplex[self._nearest.query(at)[1]])
        return self._triangles.simplices[simplex]

    def in_bins(self, rows: NDArray[np.intp]) -> NDArray[np.float64]:
        """In which bins of the summary these events are: (n, k), of 0 and 1."""
        bins = [np.searchsorted(edges, x, "right") for edges, x in zip(self._edges, self.events[rows].T, strict=True)]
        return np.hstack([np.eye(len(edges) + 1)[each] for edges, each in zip(self._edges, bins, strict=True)])

    def around(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        """The share of events at theta (p,) that is of each node: (k,), from DRAWS of them."""
        corner = self.corner(np.tile(theta, (DRAWS, 1)), np.random.default_rng(0))
        return np.bincount(corner, minlength=len(self.nodes)) / DRAWS

    def simulate(self, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        """One event of the sample per row: theta (n, p) -> (n, d). Raises ValueError outside the support."""
        self.require_support(theta)
        corner = self.corner(theta, rng)
        place = (rng.random(len(theta)) * self.sizes[corner]).astype(np.intp)
        return self.events[self._grouped[(np.cumsum(self.sizes) - self.sizes)[corner] + place]]

    def summary(self, x: NDArray) -> NDArray[np.float64]:
        """Shares of the events in twenty bins of each feature that hold equal shares of the sample: (n, d) -> (k,)."""
        return np.concatenate([histogram(x[:, [j]], edges, overflow=True) for j, edges in enumerate(self._edges)])

    def scaled(self, theta: NDArray[np.float64]) -> NDArray[np.float64]:
        return (theta - self.prior.low) / self.prior.width

    @cached_property
    def _triangles(self) -> Any:
        from scipy.spatial import Delaunay, QhullError

        try:
            return Delaunay(self.scaled(self.nodes))
        except QhullError as error:
            p = self.nodes.shape[1]
            raise UsageError(f"the {len(self.nodes)} thetas of {self.name} do not span {p} parameters") from error

    @cached_property
    def _nearest(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self.scaled(self.nodes))

    @cached_property
    def spacing(self) -> float:
        """How far a node is from the nearest other one, in shares of the range of theta; the median of all."""
        return float(np.median(self._nearest.query(self.scaled(self.nodes), k=2)[0][:, 1]))

    @cached_property
    def _edges(self) -> list[NDArray[np.float64]]:
        return [np.unique(np.nanquantile(feature, np.arange(1, 20) / 20)) for feature in self.events.T]


@checked
def bank(
    events: ArrayLike,
    *,
    theta: ArrayLike | Mapping[str, ArrayLike] | Sequence[str] | str | None = None,
    weights: ArrayLike | str | None = None,
    prior: Mapping[str, tuple[float, float]] | None = None,
    features: Sequence[str] = (),
    name: str = "sample",
    missing: Sequence[str] = (),
    seed: int = 0,
) -> SampleTask:
    """A task from events that were simulated before, wherever that was done.

    Parameters
    ----------
    events
        Simulated events: an array (M, d), or (M,) where an event is one number, or a DataFrame. Copies of one event, as
        a bootstrap makes them, count as its weight, where they are surely no values that were rounded.
    theta
        Parameters at which each event was made: an array (M, p), columns by name of the parameter, as of a DataFrame,
        or the names of columns of `events`. None where all were made at the same, unknown or fixed parameters.
    weights
        Weights of the events (M,), or the name of their column. Events are drawn by them once; what that costs in
        precision is taken into account. Negative ones are first balanced by those of the nearest events.
    prior
        Ends of each parameter by its name; those of theta where None.
    features
        A name for each of the d numbers of an event; of a DataFrame the columns that are taken, all by default.
    name
        What pages call the task.
    missing
        Names of features (x1, x2, ... where they have none) that an event may lack: it holds NaN there.
    seed
        Of the order of the events, and of the draw by weights.

    Raises
    ------
    UsageError
        For events that are no finite numbers, weights that are not finite or do not add up to a positive number, thetas
        outside the prior, and at one theta fewer events, or weighted ones that are worth fewer, than 200.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> simulated = bank(rng.exponential(2.0, 10_000), features=["lifetime"])
    >>> simulated.simulate(np.empty((3, 0)), rng).shape
    (3, 1)
    """
    rng = np.random.default_rng(whole("seed", seed, 0))
    theta = [theta] if isinstance(theta, str) else theta
    if hasattr(events, "columns"):
        distinct("columns of the simulated events", events.columns)
        if isinstance(weights, str):
            weights, events = column(events, weights), events.drop(columns=weights)
        if isinstance(theta, Sequence) and len(theta) and all(isinstance(each, str) for each in theta):
            theta = {each: column(events, each) for each in theta}
            events = events.drop(columns=list(theta))
        events = chosen(events, features)
        features = features or [str(each) for each in events.columns]
    distinct("features", features)
    listed = missing and isinstance(events, list)  # which may hold None
    x = reals("the simulated events", np.asarray(events, float) if listed else events)
    x = x[:, None] if x.ndim == 1 else x
    x = x.astype(np.int64) if x.dtype.kind in "bui" else x.astype(np.float64)
    if x.ndim != 2 or (features and len(features) != x.shape[1]):
        raise UsageError(f"simulated events must be (M, d) with d = {len(features) or 'features'}, got {x.shape}")
    labels = list(features or [f"x{j + 1}" for j in range(x.shape[1])])
    if unknown := [one for one in missing if one not in labels]:
        raise UsageError(f"missing names '{unknown[0]}'; the features are {', '.join(labels)}")
    for one, values in zip(labels, x.T, strict=True):
        if one not in missing:
            numbers(f"the values of {one} of the simulated events", values)
    if np.isinf(x).any():
        raise UsageError("the simulated events hold infinite values: mend or drop them")
    names, columns, box = _parameters(theta, prior, len(x))
    if weights is None:
        rows, worth, total = rng.permutation(len(x)), 1.0, float(len(x))
        source = np.arange(len(x))
    else:
        rows, worth, total = _drawn(x, columns, weights, rng)
        source = rng.permutation(len(x))[rows]
    if (same := copies(x, columns)) is not None:
        num_distinct = same.max() + 1
        source = rng.permutation(num_distinct)[same][rows]
        worth = min(worth, len(x) / float((np.bincount(source) ** 2).sum()))
        warn(
            f"{len(x) - num_distinct} of {len(x)} simulated events are copies of others, and count as weights of "
            f"these: all are worth {worth * len(x):.0f} of equal weight",
            stacklevel=3,
        )
    made = SampleTask(x[rows], columns[rows], source, names, features, box, worth, total, name, missing)
    least = min(range(len(made.groups)), key=lambda k: len(made.groups[k]))
    if (few := len(made.groups[least]) + len(made.aside[least])) < LEAST:
        where = f" at theta = {made.nodes[least].tolist()}" if names else ""
        more = ": round theta to fewer values" if len(made.nodes) * LEAST > len(x) else ""
        raise UsageError(f"{few} simulated events{where} are too few, at least {LEAST} are needed at each theta{more}")
    return made


def require_enough(task: Task, theta: NDArray[np.float64], num_measured: int) -> None:
    """Raise UsageError where a sample has fewer events near theta (p,) than half of so many measured ones.

    Those kept aside do not count. The scatter of so few is not known well enough, so that tests reject what is right.
    """
    if not isinstance(task, SampleTask):
        return
    needed = num_measured / 2 * task.around(theta)
    used, aside = task.sizes, np.array([len(group) for group in task.aside])
    k = int(np.argmax(needed - task.worth * used))
    if needed[k] > task.worth * used[k]:
        at = [f"{n} = {value:.4g}" for n, value in zip(task.parameter_names, task.nodes[k], strict=True)]
        where = f" at {', '.join(at)}, near the fit," if at else ""
        raise UsageError(
            f"{used[k] + aside[k]} simulated events{where} are too few for {num_measured} measured ones: "
            f"at least {np.ceil(needed[k] / task.worth / used[k] * (used[k] + aside[k])):.0f} are needed"
        )


def _parameters(
    theta: ArrayLike | Mapping[str, ArrayLike] | None, prior: Mapping[str, tuple[float, float]] | None, n: int
) -> tuple[list[str], NDArray[np.float64], Box]:
    if hasattr(theta, "columns") and not all(isinstance(each, int) for each in theta.columns):
        distinct("columns of theta", theta.columns)
        theta = {str(each): theta[each] for each in theta.columns}
    if isinstance(theta, Mapping):
        values = [numbers(f"the values of {name}", each) for name, each in theta.items()]
        names, columns = list(theta), numbers("theta", values).astype(float).T
    else:
        columns = np.empty((n, 0)) if theta is None else numbers("theta", theta).astype(float)
        columns = columns[:, None] if columns.ndim == 1 else columns
        names = list(prior or [f"theta{j + 1}" for j in range(columns.ndim and columns.shape[-1])])
    if columns.shape != (n, len(names)):
        raise UsageError(f"{n} events need as many rows of {len(names)} parameters, got {columns.shape}")
    constant = [one for one, column in zip(names, columns.T, strict=True) if np.ptp(column) == 0]
    if constant:
        raise UsageError(f"all events were made at one {constant[0]}: leave it out of theta")
    ends = prior or {one: (c.min(), c.max()) for one, c in zip(names, columns.T, strict=True)}
    if set(ends) != set(names):
        raise UsageError(f"the prior is of {', '.join(ends)}, theta of {', '.join(names)}")
    box = box_of({one: ends[one] for one in names})
    if outside := int((~box.contains(columns)).sum()):
        raise UsageError(f"{outside} of {n} events were made outside the prior of theta: widen it, or drop them")
    return names, columns, box


def _drawn(
    x: NDArray, theta: NDArray[np.float64], weights: ArrayLike, rng: np.random.Generator
) -> tuple[NDArray[np.intp], float, float]:
    """The rows of events x (n, d) that their weights draw, what a row is worth, and the sum of weights.

    At each theta as many are drawn as there are. Raises UsageError.
    """
    w, rows, worth = weights_of("simulated events", weights, len(x)), [], 0.0
    nodes, which = np.unique(theta, axis=0, return_inverse=True)
    for k, node in enumerate(nodes):
        index = np.flatnonzero(which.ravel() == k)
        where = f" at theta = {node.tolist()}" if node.size else ""
        if not w[index].sum() > 0:
            raise UsageError(f"the weights of simulated events{where} do not add up to a positive number")
        positive = without_negative(x[index], w[index])
        if (tell := effective_drawn(w[index], positive)) < LEAST:
            raise UsageError(
                f"{len(index)} weighted events{where} are worth {tell:.1f} of equal weight; at least {LEAST} are needed"
            )
        rows.append(index[drawn(positive, rng)])
        worth += tell / len(x)
    return rng.permutation(np.concatenate(rows)), worth, float(w.sum())
