"""Alignment in three dimensions: where is the interaction point, beside the beams as well as along them?

`python -m avobench.tasks.alignment_3` measures FLOORS, from which the floor is interpolated.
"""

from dataclasses import dataclass
from itertools import product
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import interpn

from avobench.tasks.alignment import Alignment, Particles
from avobench.tasks.contract import Box

STEP = 0.2
"""Step of the numerical derivative [mm]: with half of it, what is learnt has twice the noise."""
RIDGE = 1e-3
"""Added to every variance, as a share of their mean, when weights are learnt: some cells are seldom hit."""
RADII = (0.0, 1.07, 2.13)
"""Distances from the beam axis [mm] at which the floor was measured; the prior's corners are at 2.12."""
HEIGHTS = (0.0, 0.75, 1.5)
"""Distances from the centre plane [mm], on one side: the detector is symmetric."""
FLOORS = ((3.429, 3.126, 2.221), (3.09, 2.837, 1.959), (1.889, 1.712, 1.035))
"""Trace of the inverse information in one event [mm^2], by RADII and HEIGHTS, with the default settings.

Too high by some per cent: with an eighth of NUM_EVENTS the information without an offset is a third less, so weights
from 32 000 events still miss about 6 % of it."""
NUM_EVENTS = 64_000
"""Number of events by which FLOORS were measured; half of them tell the weights."""
AZIMUTH = 0.75
"""Azimuth at which FLOORS were measured [rad]: the detector depends on it by its columns alone."""


@dataclass(frozen=True)
class Alignment3(Alignment):
    """Where is the interaction point? The task `alignment` with offsets along x, y and z, and an image of 16 x 8 cells.

    An offset beside the beams breaks the symmetry in azimuth, so no axis is cyclic and an image cannot be summed. The
    cells are larger than those of `alignment`, two by four of them, because 160 000 events do not tell how each of 1024
    cells depends on three offsets: there even the method of moments goes astray.
    """

    name = "alignment-3"
    parameter_names = ("x", "y", "z")
    parameter_units = ("mm", "mm", "mm")
    prior = Box((-1.5,) * 3, (1.5,) * 3)
    axes: ClassVar = (0, 1, 2)
    event_shape, num_features, cyclic_axes = (16, 8), 128, ()
    floor_shares = (0.317, 0.314, 0.369)  # without an offset
    by_default = False

    @property
    def support(self) -> Box:
        """A cube within the sphere."""
        half = 0.99 * self.radius / np.sqrt(3)
        return Box((-half,) * 3, (half,) * 3)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """(1/N + 1/n) times the trace of the inverse `information` in one event [mm^2].

        N observations, n simulations; without them no 1/n. An upper bound on the floor: an image may hold more than
        linear statistics of it tell. It was measured within the prior with the default settings, at some distances from
        the axis and from the centre plane; elsewhere it is unknown, and NaN.
        """
        if self != type(self)():
            return np.nan
        at = np.hypot(theta[0], theta[1]), abs(theta[2])
        per_event = interpn((RADII, HEIGHTS), np.array(FLOORS), at, bounds_error=False, fill_value=np.nan)[0]
        return float((1 / num_observations + (0 if num_simulations is None else 1 / num_simulations)) * per_event)


def information(
    task: Alignment3, theta: NDArray[np.float64], num_events: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Fisher information on theta in three linear statistics of an image: theta (k, 3) [mm] -> (k, 3, 3) [1/mm^2].

    Half of the events tell the weights w = C^-1 m', with C the covariance of the cells and m' the slope of their mean.
    The other half tell how the means of the three statistics w move with theta and how these vary: whatever the weights
    are, an image holds no less than that, and what they were learnt from does not flatter them. The slopes are central
    differences over the same generated events, so that their fluctuations cancel; all k points share the events too.
    Raises ValueError within STEP of the support's end.
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
        moved = [seen(particles, theta + step) - seen(particles, theta - step) for step in STEP * np.eye(3)]
        rise = rise + np.stack(moved, axis=2).sum(axis=0)
    mean = total / n
    return rise / (2 * STEP * n), outer / n - np.outer(mean, mean)


def measured(num_events: int = NUM_EVENTS, seed: int = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The numbers of FLOORS, and each parameter's share of the first of them, with no offset: (3, 3), (3,)."""
    points = np.array([(r * np.cos(AZIMUTH), r * np.sin(AZIMUTH), z) for r, z in product(RADII, HEIGHTS)])
    inverse = np.linalg.inv(information(Alignment3(), points, num_events, np.random.default_rng(seed)))
    floors = np.trace(inverse, axis1=1, axis2=2)
    return floors.reshape(len(RADII), len(HEIGHTS)), inverse[0].diagonal() / floors[0]


if __name__ == "__main__":
    print(*(np.array2string(array, precision=3) for array in measured()), sep="\n")
