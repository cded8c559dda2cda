"""Where to begin a fit: a coarse search of the whole range, or of what lies near a point."""

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.fit.surrogate import CLEAR
from avobench.diagnosis.summary.target import Target
from avobench.effects.model import Model

SEARCHED = 0.2
"""How far from where it may be, in cube coordinates, a point is looked for."""
LESS = 10
"""How many times fewer events suffice to see where it is hopeless."""


def scan(
    model: Model,
    target: Target,
    rng: np.random.Generator,
    *,
    fixed: NDArray[np.float64] | None = None,
    around: NDArray[np.float64] | None = None,
    size: tuple[int, int] = (200, 300),
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A point (P,) of the unit cube near the best, and how near in each coordinate that was searched, from three
    searches, each around the last best.

    `fixed` are values of the last coordinates, which are then not searched; the others within SEARCHED of `around`, if
    that is given, and else everywhere. `size` is the number of points of a search and of events at each. As far as
    points lie that are not clearly worse than the best, it may be off.
    """
    points, events = size
    fixed = np.empty(0) if fixed is None else fixed
    p = model.dim - len(fixed)

    def distances(u: NDArray[np.float64], events: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        params = model.from_cube(np.hstack([u, np.tile(fixed, (len(u), 1))]))
        means = target.summary.mean(model.simulate(np.repeat(params, events, axis=0), rng), len(u))
        q, noise = (target.whiten(target.mean - means) ** 2).sum(axis=1), target.num_events / events
        return q, np.sqrt(2 * target.rank * noise**2 + 4 * q * noise)

    centre, half = (np.full(p, 0.5), np.full(p, 0.5)) if around is None else (around, np.full(p, SEARCHED))
    for _ in range(3):
        u = rng.uniform(np.maximum(centre - half, 0), np.minimum(centre + half, 1), (points, p))
        q, error = distances(u, max(events // LESS, 1))
        u = u[q - q.min() <= CLEAR * error]
        q, error = distances(u, events)
        centre, alike = u[q.argmin()], u[q - q.min() <= error]
        half = np.maximum(half * 3 * points ** (-1 / p), np.abs(alike - centre).max(axis=0))
    return np.concatenate([centre, fixed]), half
