"""The Fisher information of the alignment tasks, by which their floors were measured: `python -m paper.information`."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from avobench.tasks.alignment import Alignment, Particles
from avobench.tasks.alignment_3 import HEIGHTS, RADII, Alignment3

STEP = 0.1
"""Step of the numerical derivative along the beam [mm], a tenth of a cell."""
STEP_3 = 0.2
"""Step of the numerical derivative in three dimensions [mm]: with half of it, what is learnt has twice the noise."""
RIDGE = 1e-3
"""Added to every variance, as a share of their mean, when weights are learnt: some cells are seldom hit."""
NUM_EVENTS = 64_000
"""Number of events by which FLOORS were measured; half of them tell the weights."""
AZIMUTH = 0.75
"""Azimuth at which FLOORS were measured [rad]: the detector depends on it by its columns alone."""


def of_rows(
    task: Alignment, theta: NDArray[np.float64], num_events: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Linear Fisher information on theta in the row sums of one image: theta (k,) [mm] -> (k,) [1/mm^2].

    I = m'^T C^-1 m' with m' the derivative of the mean of the 32 row sums and C their covariance. The derivative is a
    central difference over the same `num_events` generated events, so that their fluctuations cancel; all k points
    share them too. Raises ValueError within STEP of the support's end.
    """
    rows, columns = task.event_shape
    total, outer = np.zeros((len(theta), rows)), np.zeros((len(theta), rows, rows))
    rise = np.zeros((len(theta), rows))
    for particles in task.generate(num_events, rng):
        for i, t in enumerate(theta):
            low, here, high = (
                task.detect(particles, np.full((len(particles), 1), at))
                .reshape(-1, rows, columns)
                .sum(axis=2, dtype=float)
                for at in (t - STEP, t, t + STEP)
            )
            total[i] += here.sum(axis=0)
            outer[i] += here.T @ here
            rise[i] += (high - low).sum(axis=0)
    mean, slope = total / num_events, rise / (2 * STEP * num_events)
    covariance = outer / num_events - mean[:, :, None] * mean[:, None, :]
    # A row that no event hits has no variance, and tells nothing: the pseudo-inverse leaves it out.
    return np.einsum("ki,kij,kj->k", slope, np.linalg.pinv(covariance, hermitian=True), slope)


def of_cells(
    task: Alignment3, theta: NDArray[np.float64], num_events: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Fisher information on theta in three linear statistics of an image: theta (k, 3) [mm] -> (k, 3, 3) [1/mm^2].

    Half of the events tell the weights w = C^-1 m', with C the covariance of the cells and m' the slope of their mean.
    The other half tell how the means of the three statistics w move with theta and how these vary: whatever the weights
    are, an image holds no less than that, and what they were learnt from does not flatter them. The slopes are central
    differences over the same generated events, so that their fluctuations cancel; all k points share the events too.
    Raises ValueError within STEP_3 of the support's end.
    """
    learning, measuring = (list(task.generate(num_events // 2, rng)) for _ in range(2))
    found = []
    for point in theta:
        slope, covariance = _moments(task, learning, point, np.eye(task.num_features))
        ridge = RIDGE * covariance.diagonal().mean()
        weights = np.linalg.solve(covariance + ridge * np.eye(len(covariance)), slope)
        slope, covariance = _moments(task, measuring, point, weights)
        found.append(slope.T @ np.linalg.solve(covariance, slope))
    return np.array(found)


def _moments(
    task: Alignment3, pieces: list[Particles], theta: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Slope of the mean in theta (3,), (k, 3), and covariance (k, k) of k sums of cells with weights (d, k)."""

    def seen(particles: Particles, at: NDArray[np.float64]) -> NDArray[np.float64]:
        return task.detect(particles, np.tile(at, (len(particles), 1))) @ weights

    n, total, outer, rise = sum(map(len, pieces)), 0.0, 0.0, 0.0
    for particles in pieces:
        here = seen(particles, theta)
        total, outer = total + here.sum(axis=0), outer + here.T @ here
        moved = [seen(particles, theta + step) - seen(particles, theta - step) for step in STEP_3 * np.eye(3)]
        rise = rise + np.stack(moved, axis=2).sum(axis=0)
    mean = total / n
    return rise / (2 * STEP_3 * n), outer / n - np.outer(mean, mean)


def measured(num_events: int = NUM_EVENTS, seed: int = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """FLOORS of `alignment_3`, and each parameter's share of the first of them, with no offset: (3, 3), (3,)."""
    points = np.array([(r * np.cos(AZIMUTH), r * np.sin(AZIMUTH), z) for r, z in product(RADII, HEIGHTS)])
    inverse = np.linalg.inv(of_cells(Alignment3(), points, num_events, np.random.default_rng(seed)))
    floors = np.trace(inverse, axis1=1, axis2=2)
    return floors.reshape(len(RADII), len(HEIGHTS)), inverse[0].diagonal() / floors[0]


if __name__ == "__main__":
    print(*(np.array2string(array, precision=3) for array in measured()), sep="\n")
