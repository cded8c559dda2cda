"""The visibility of an injection to the best test, which is independent of the diagnosis."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, ncx2

from avobench.effects.contract import Simulate
from avobench.tasks import Task

ALPHA = 0.05
"""Level of the test, which is the default of a diagnosis."""
STEP = 0.02
"""Step of numerical derivatives, in widths of the prior."""
NUM_ROUNDS = 3
"""Rounds of fitting theta again. They make an effect invisible that a change of theta can imitate."""
FACTOR = 2.0
"""Factor by which the strength of another effect may change in the fit, up and down."""
NUM_COVARIANCE = 20_000
"""Events from which the covariance is taken."""


@dataclass(frozen=True)
class Visibility:
    """The visibility of an effect in the chi-square test of binned events, with theta fitted."""

    distance: float
    """Noncentrality over degrees of freedom: expected chi2/ndf - 1."""
    power: float
    """Probability to reject at ALPHA."""


def visibility(
    task: Task,
    x: NDArray,
    theta: NDArray[np.float64],
    num_events: int,
    rng: np.random.Generator,
    other: Callable[[float], Simulate] | None = None,
) -> Visibility:
    """The visibility of the effect in events x (n, d), measured at theta (p,), if there were `num_events` of them.

    `other` gives the simulator with another effect, of which a factor of its strength is fitted like theta.

    Theta is fitted to the binned events by Gauss-Newton steps, from its true value and from where the means agree; the
    better fit counts. The fluctuations of x and of the simulation are subtracted on average. With as many events in x
    as `num_events` the distance is uncertain by about 1.5 sqrt(2 / ndf).
    """
    fitted = Fitted.of(task, other)
    start = np.append(theta, 0.0) if other else theta
    starts = [start] if task.event_shape else [start, _where_means_agree(fitted, x, start, rng)]
    return min((_from(task, fitted, x, start, num_events, rng) for start in starts), key=lambda each: each.distance)


@dataclass(frozen=True)
class Fitted:
    """What the test fits: theta, and the logarithm of a factor of another effect's strength where there is one."""

    simulate: Simulate
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    step: NDArray[np.float64]
    """The step of a numerical derivative."""

    @classmethod
    def of(cls, task: Task, other: Callable[[float], Simulate] | None) -> "Fitted":
        low, high, step = np.array(task.support.low), np.array(task.support.high), STEP * task.prior.width
        if other is None:
            return cls(task.simulate, low, high, step)

        def simulate(at: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
            return other(float(np.exp(at[0, -1])))(at[:, :-1], rng)

        most = np.log(FACTOR)
        return cls(simulate, np.append(low, -most), np.append(high, most), np.append(step, 0.1 * most))


def _where_means_agree(
    fitted: Fitted, x: NDArray, theta: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """The point (p,) nearest to theta at which the mean of each feature is that of x, as far as there is one."""
    low, high, step = fitted.low, fitted.high, fitted.step
    spread = x.std(axis=0)
    scale = np.where(spread > 0, spread, 1)

    def mean(at: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        events = fitted.simulate(np.tile(np.clip(at, low, high), (len(x), 1)), np.random.default_rng(seed))
        return events.mean(axis=0) / scale

    for seed in rng.integers(2**63, size=NUM_ROUNDS):
        slopes = [(mean(theta + change, seed) - mean(theta - change, seed)) / 2 for change in np.diag(step)]
        residual = x.mean(axis=0) / scale - mean(theta, seed)
        theta = np.clip(theta + step * np.linalg.lstsq(np.stack(slopes, axis=1), residual, rcond=0.02)[0], low, high)
    return theta


def _from(
    task: Task, fitted: Fitted, x: NDArray, theta: NDArray[np.float64], num_events: int, rng: np.random.Generator
) -> Visibility:
    simulate, low, high, step = fitted.simulate, fitted.low, fitted.high, fitted.step
    n, m = len(x), len(x) if task.event_shape else 2 * len(x)
    simulated = simulate(np.tile(theta, (m, 1)), rng)
    bins, half = Bins(task, x), NUM_COVARIANCE // 2
    # Of both together: where one of them has next to no event, its own covariance says nothing.
    value, vector = np.linalg.eigh(bins.covariance(np.concatenate([x[:half], simulated[:half]])))
    kept = value > 1e-6 * value[-1]
    whiten = vector[:, kept] / np.sqrt(value[kept])

    def mean(at: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
        events = simulate(np.tile(at, (n // 4, 1)), np.random.default_rng(seed))
        return bins.mean(events) @ whiten

    for round in range(num_rounds := 1 if task.event_shape else NUM_ROUNDS):
        slopes, seed = [], int(rng.integers(2**63))  # the same at both ends, so that fluctuations cancel
        for change in np.diag(step):
            up, down = np.clip(theta + change, low, high), np.clip(theta - change, low, high)
            slopes.append((mean(up, seed) - mean(down, seed)) / (up - down).sum() * change.sum())
        jacobian = np.stack(slopes, axis=1)
        residual = (bins.mean(x) - bins.mean(simulated)) @ whiten
        move, _, rank, _ = np.linalg.lstsq(jacobian, residual, rcond=0.02)
        remaining = residual - jacobian @ move
        if round + 1 < num_rounds:
            theta = np.clip(theta + move * step, low, high)
            simulated = simulate(np.tile(theta, (m, 1)), rng)
    ndf = int(kept.sum() - rank)
    if ndf < 1:  # as many numbers are fitted as there are bins
        return Visibility(0.0, ALPHA)
    noncentrality = max(0.0, float(remaining @ remaining) - ndf * (1 / n + 1 / m)) * num_events
    return Visibility(noncentrality / ndf, float(ncx2.sf(chi2.isf(ALPHA, ndf), ndf, noncentrality)))


class Bins:
    """What the test sees of events, made from measured ones: bins of each feature and each pair of them.

    Of an image the sums of rows, columns and blocks of 4 x 4, and bins of its total.
    """

    def __init__(self, task: Task, x: NDArray) -> None:
        self.shape = task.event_shape
        features = self._features(x)
        fine = 30 if features.shape[1] == 1 else 12
        self.fine, self.coarse = ([_edges(feature, k) for feature in features.T] for k in (fine, 4))

    def mean(self, x: NDArray) -> NDArray[np.float64]:
        """Share of the events in each bin, after the mean sums: (n, d) -> (k,)."""
        counts = [np.bincount(index, minlength=size) for index, size in self._indices(x)]
        return np.concatenate([self._sums(x).mean(axis=0), *(count / len(x) for count in counts)])

    def covariance(self, x: NDArray) -> NDArray[np.float64]:
        """The covariance of the sums and bins of one event: (n, d) -> (k, k)."""
        return np.cov(np.hstack([self._sums(x), *(np.eye(size)[index] for index, size in self._indices(x))]).T)

    def _features(self, x: NDArray) -> NDArray:
        return x.sum(axis=1, keepdims=True) if self.shape else x

    def _sums(self, x: NDArray) -> NDArray[np.float64]:
        if not self.shape:
            return np.empty((len(x), 0))
        rows, columns = self.shape
        image = x.reshape(-1, rows, columns).astype(float)
        blocks = image.reshape(-1, rows // 4, 4, columns // 4, 4).sum(axis=(2, 4))
        return np.hstack([image.sum(axis=2), image.sum(axis=1), blocks.reshape(len(x), -1)])

    def _indices(self, x: NDArray) -> list[tuple[NDArray[np.intp], int]]:
        """The bin of each event, (n,), and the number of bins, for each feature and each pair."""

        def bins(feature: int, edges: list[NDArray]) -> tuple[NDArray[np.intp], int]:
            return np.searchsorted(edges[feature], features[:, feature], side="right"), len(edges[feature]) + 1

        features = self._features(x)
        indices = [bins(i, self.fine) for i in range(features.shape[1])]
        for i, j in combinations(range(features.shape[1]), 2):
            (first, n), (second, m) = bins(i, self.coarse), bins(j, self.coarse)
            indices.append((first * m + second, n * m))
        return indices


def _edges(feature: NDArray, num_bins: int) -> NDArray:
    """The edges of bins with equal shares of the events. If the values are counts, each whole number has a bin."""
    if np.issubdtype(feature.dtype, np.integer):
        low, high = np.quantile(feature, [0.005, 0.995]).round()
        return np.arange(low, high + 2)
    return np.unique(np.quantile(feature, np.arange(1, num_bins) / num_bins))
