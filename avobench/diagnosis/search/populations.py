"""Where two populations of events may be.

The mean of a mixture is the weighted mean of those of its two populations. So each theta is simulated once, and every
pair of thetas follows without further events. A grid over both thetas would be too coarse. A fit that begins where
there is one population goes astray if the second one is large.
"""

import numpy as np
from numpy.typing import NDArray

from avobench.diagnosis.effort import Effort
from avobench.diagnosis.fit.fit import Fit
from avobench.diagnosis.search.screening import Start
from avobench.diagnosis.settings import SEARCH
from avobench.diagnosis.summary.target import Target
from avobench.effects import Effect


def populations(fit: Fit, target: Target, effect: Effect, rng: np.random.Generator, effort: Effort) -> list[Start]:
    """Starts for a mixture in all parameters of a fitted simulator: the pairs of thetas whose events together fit best.

    Thetas are drawn where the second one may lie, then around those of the best pairs, ever closer. Of the last pairs
    each is simulated once more, since the best of many is so by chance.
    """
    model, p, (points, events) = fit.model.plus(effect), fit.model.dim, effort.pairs
    low, width = fit.model.low, fit.model.high - fit.model.low
    ends = (np.array([(other.low, other.high) for other in effect.parameters[1:]]).T - low) / width
    noise = target.num_events / events * target.rank

    def residuals(u: NDArray[np.float64], more: int = 1) -> NDArray[np.float64]:
        x = fit.model.simulate(np.repeat(low + u * width, more * events, axis=0), rng)
        return target.whiten(target.mean - target.summary.mean(x, len(u)))

    near = rng.standard_normal((points, p)) * SEARCH.apart ** rng.uniform(0, 2, (points, 1))
    u = np.clip(np.concatenate([rng.uniform(*ends, (points, p)), fit.point + near, fit.point[None]]), *ends)
    misfits = residuals(u)
    for k in range(SEARCH.pairings):
        pairs, _, _ = best_pairs(misfits, noise, inside(u))
        around = np.unique(pairs[: SEARCH.pairs])
        beside = u[np.resize(around, points)]
        beside = np.clip(beside + SEARCH.apart ** (1 + k / 2) * rng.standard_normal(beside.shape), *ends)
        u, misfits = np.concatenate([u, beside]), np.concatenate([misfits, residuals(beside)])
    pairs, _, _ = best_pairs(misfits, noise, inside(u))
    starts = []
    for two in u[pairs[: SEARCH.pairs]]:
        misfits, noise_of_two = residuals(two, SEARCH.final_events), noise / SEARCH.final_events
        (pair, *_), (share, *_), (q, *_) = best_pairs(misfits, noise_of_two, inside(two))
        first, second = low + two[pair] * width
        point = model.to_cube(np.r_[first, max(share, 0.01), second])
        half = np.full(model.dim, SEARCH.apart ** (1 + SEARCH.pairings / 2))
        starts.append(Start(model, np.clip(point, 0, 1), float(q), half[p], half=half))
    return sorted(starts, key=lambda start: start.expected)[: SEARCH.modes]


def inside(u: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points (m, p) lie in the unit cube. The theta of the larger population must."""
    return ((u >= 0) & (u <= 1)).all(axis=1)


def best_pairs(
    residuals: NDArray[np.float64], noise: float, may_be_first: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """The pairs of means whose mixtures are nearest to what was measured (k, 2), the second's share (k,), and Q (k,).

    `residuals` (m, r) are the measured mean less each simulated one, whitened, with a square of `noise` by simulation.
    The share is at most one half. For each first mean only its best partner is kept.
    """
    products = residuals @ residuals.T
    squares = np.diag(products) - noise
    length = np.maximum(squares[:, None] + squares - 2 * products, 1e-12)
    share = np.clip((squares[:, None] - products) / length, 0, 0.5)
    q = (1 - share) ** 2 * squares[:, None] + 2 * share * (1 - share) * products + share**2 * squares
    np.fill_diagonal(q, np.inf)
    second = q.argmin(axis=1)
    least = q[np.arange(len(q)), second]
    first = np.argsort(np.where(may_be_first, least, np.inf))[: int(may_be_first.sum())]
    second = second[first]
    return np.column_stack([first, second]), share[first, second], least[first]
