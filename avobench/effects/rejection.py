"""Events that a detector does not record: others are drawn in their place."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Simulate
from avobench.tasks.errors import SimulatorError

MAX_ROUNDS = 200
"""Rounds of rejection: of a detector that records one event in ten, all but 1e-9 have been recorded by then."""
DRAWN = 12
"""Draws for one recorded event, at most and on average: enough where one in ten is recorded."""
FEW = 100
"""What fewer events count as in that average."""
NEAREST = (1, 30, 1000)
"""So many recorded events next to a row that has none are tried for it, one after the other."""
TIE = 1e-9
"""In shares of the range of theta: so far rows are moved at random, that equal ones do not all have the same event."""

_must_record: ContextVar[bool] = ContextVar("must_record", default=False)


@contextmanager
def must_record() -> Iterator[None]:
    """Within this, a detector that records nothing at all is an error; a fit that tries such parameters goes on."""
    token = _must_record.set(True)
    try:
        yield
    finally:
        _must_record.reset(token)


def accepted(
    simulate: Simulate,
    theta: NDArray[np.float64],
    keep: Callable[[NDArray, NDArray[np.intp]], NDArray[np.float64]],
    rng: np.random.Generator,
) -> NDArray:
    """Events that a detector records: drawn anew, row by row, until recorded: theta (n, p) -> (n, d).

    `keep(x, rows)` is the chance that the events x, of these rows of theta, are recorded. It is NaN where a value is
    missing; then the mean chance of the others counts, since a selection does not change how often values are missing.
    What a detector hardly ever records cannot be waited for: such a row gets the event of the nearest other row in
    theta that can be recorded there. Where none near can, it gets that of the nearest row that was recorded. So a fit
    that tries such parameters goes on. Where no row was recorded, the events stay as they are; within `must_record`,
    SimulatorError is raised.
    """
    x = simulate(theta, rng)
    rows, remaining = np.arange(len(theta)), DRAWN * max(len(theta), FEW)
    for _ in range(MAX_ROUNDS):
        chance = keep(x[rows], rows)
        if (missing := np.isnan(chance)).any():
            chance = np.where(missing, chance[~missing].mean() if not missing.all() else 1.0, chance)
        rows = rows[rng.random(len(rows)) >= chance]
        remaining -= len(rows)
        if len(rows) == 0:
            return x
        if remaining < 0:
            break
        x[rows] = simulate(theta[rows], rng)

    from scipy.spatial import cKDTree

    recorded = np.setdiff1d(np.arange(len(x)), rows)
    if not len(recorded) and not _must_record.get():
        return x
    if not len(recorded):
        raise SimulatorError(
            f"a detector records none of the events that were simulated for {len(x)} rows of parameters, the first "
            f"at {theta[0].tolist()}: give parameters at which events are recorded"
        )
    width = np.ptp(theta, axis=0)
    at = np.c_[(theta - theta.min(axis=0)) / np.where(width > 0, width, 1), np.zeros(len(x))]
    at += TIE * rng.standard_normal(at.shape)
    tree = cKDTree(at[recorded])
    for most in NEAREST:
        near = recorded[tree.query(at[rows], range(1, min(most, len(recorded)) + 1))[1]]
        chance = keep(x[near.ravel()], np.repeat(rows, near.shape[1])).reshape(near.shape)
        suits = ~(chance <= 0)  # nor is it 0 where it is NaN
        x[rows] = x[near[np.arange(len(rows)), suits.argmax(axis=1)]]
        rows = rows[~suits.any(axis=1)]
        if not len(rows):
            break
    return x
