"""What the maps of a diagnosis of images are drawn from."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task


@dataclass(frozen=True)
class Maps:
    """Mean images and, cell by cell, pulls: (measured - simulated) / standard error. Each (rows, columns)."""

    measured: NDArray[np.float64]
    before: NDArray[np.float64]
    pulls_before: NDArray[np.float64]
    after: NDArray[np.float64] | None
    pulls_after: NDArray[np.float64] | None

    @classmethod
    def of(cls, task: Task, x: NDArray, before: NDArray, after: NDArray | None) -> Self:
        """From measured events x (n, d), simulated ones (m, d) at the fitted theta, and those of the mended model."""
        mended = (None, None) if after is None else _compared(task, x, after)
        return cls(x.mean(axis=0).reshape(task.event_shape), *_compared(task, x, before), *mended)


def _compared(task: Task, x: NDArray, simulated: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean simulated image and pulls; 0 where neither ever varies."""
    difference = x.mean(axis=0) - simulated.mean(axis=0)
    error = np.sqrt(x.var(axis=0) / len(x) + simulated.var(axis=0) / len(simulated))
    pulls = np.divide(difference, error, out=np.zeros(len(error)), where=error > 0)
    return simulated.mean(axis=0).reshape(task.event_shape), pulls.reshape(task.event_shape)
