"""What the figures of a diagnosis are drawn from: binned events, measured and simulated before and after."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task

MAX_BINS = 40
TOTAL = "sum of all cells"


@dataclass(frozen=True)
class Histogram:
    """Events of one feature in bins; what lies beyond the ends counts in the first and the last."""

    feature: str
    edges: NDArray[np.float64]
    """(b + 1,)"""
    measured: NDArray[np.int64]
    """(b,) events."""
    before: NDArray[np.float64]
    """(b,) events expected from the simulator, scaled to the number of measured events."""
    after: NDArray[np.float64] | None
    """The same with the missing effects added; None if none was."""
    pulls_before: NDArray[np.float64]
    """(b,) (measured - expected) / standard deviation, that of the finite simulation included."""
    pulls_after: NDArray[np.float64] | None


@dataclass(frozen=True)
class Maps:
    """Mean images, (rows, columns), and cell by cell the pulls of the measured one."""

    measured: NDArray[np.float64]
    before: NDArray[np.float64]
    pulls_before: NDArray[np.float64]
    pulls_after: NDArray[np.float64] | None


@dataclass(frozen=True)
class Pictures:
    """Histograms of the features, or maps where events are images of two dimensions."""

    histograms: tuple[Histogram, ...]
    maps: Maps | None

    @classmethod
    def of(cls, task: Task, x: NDArray, before: NDArray, after: NDArray | None) -> "Pictures":
        """From measured events x (n, d), simulated ones (m, d) at the fitted theta, and those of the mended model."""
        if len(task.event_shape) == 2:
            total = _histogram(
                TOTAL, *(None if events is None else events.sum(axis=1) for events in (x, before, after))
            )
            return cls((total,), _maps(task, x, before, after))
        names = task.feature_names or [f"x{i + 1}" for i in range(task.num_features)]
        return cls(
            tuple(
                _histogram(name, x[:, i], before[:, i], None if after is None else after[:, i])
                for i, name in enumerate(names)
            ),
            None,
        )


def _histogram(name: str, x: NDArray, before: NDArray, after: NDArray | None) -> Histogram:
    edges = _edges(x, before)
    measured = _counts(x, edges)
    expected, pulls = _expected(measured, before, edges)
    mended, pulls_after = (None, None) if after is None else _expected(measured, after, edges)
    return Histogram(name, edges, measured, expected, mended, pulls, pulls_after)


def _edges(x: NDArray, simulated: NDArray) -> NDArray[np.float64]:
    """Equal bins over all but the outermost thousandths of both; counts have bins around whole numbers."""
    ends = np.array([np.quantile(events, [0.001, 0.999]) for events in (x, simulated)])
    low, high = ends[:, 0].min(), ends[:, 1].max()
    if np.issubdtype(x.dtype, np.integer):
        step = -(-(int(high) - int(low) + 1) // MAX_BINS)
        return np.arange(int(low), int(high) + step + 1, step) - 0.5
    return np.linspace(low, high, MAX_BINS + 1)


def _counts(values: NDArray, edges: NDArray[np.float64]) -> NDArray[np.int64]:
    inside = np.clip(values, (edges[0] + edges[1]) / 2, (edges[-2] + edges[-1]) / 2)
    return np.histogram(np.where((values > edges[0]) & (values < edges[-1]), values, inside), edges)[0]


def _expected(
    measured: NDArray[np.int64], simulated: NDArray, edges: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Expected events and pulls."""
    n, m = measured.sum(), len(simulated)
    counts = _counts(simulated, edges)
    share = (measured + counts) / (n + m)  # as for two samples of one distribution
    std = np.sqrt(n * share * (1 - share) * (1 + n / m))
    expected = counts * (n / m)
    return expected, np.divide(measured - expected, std, out=np.zeros(len(std)), where=std > 0)


def _maps(task: Task, x: NDArray, before: NDArray, after: NDArray | None) -> Maps:
    def pulls(simulated: NDArray) -> NDArray[np.float64]:
        difference = x.mean(axis=0) - simulated.mean(axis=0)
        std = np.sqrt(x.var(axis=0) / len(x) + simulated.var(axis=0) / len(simulated))
        return np.divide(difference, std, out=np.zeros(len(std)), where=std > 0).reshape(task.event_shape)

    return Maps(
        x.mean(axis=0).reshape(task.event_shape),
        before.mean(axis=0).reshape(task.event_shape),
        pulls(before),
        None if after is None else pulls(after),
    )
