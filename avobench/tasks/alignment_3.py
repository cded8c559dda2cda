"""Alignment in three dimensions: where is the interaction point, beside the beams as well as along them?

`python -m paper.information` measures FLOORS, from which the floor is interpolated.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import interpn

from avobench.tasks.alignment import Alignment
from avobench.tasks.contract import Box

RADII = (0.0, 1.07, 2.13)
"""Distances from the beam axis [mm] at which the floor was measured; the prior's corners are at 2.12."""
HEIGHTS = (0.0, 0.75, 1.5)
"""Distances from the centre plane [mm], on one side: the detector is symmetric."""
FLOORS = ((3.429, 3.126, 2.221), (3.09, 2.837, 1.959), (1.889, 1.712, 1.035))
"""Trace of the inverse information in one event [mm^2], by RADII and HEIGHTS, with the default settings.

Too high by some per cent: with an eighth of the 64 000 events the information without an offset is a third less, so
weights from 32 000 events still miss about 6 % of it."""


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
        half = 0.99 * self.radius / np.sqrt(3)
        return Box((-half,) * 3, (half,) * 3)

    def floor(self, theta: NDArray[np.float64], num_observations: int, num_simulations: int | None) -> float:
        """(1/N + 1/n) times the trace of the inverse information in one event [mm^2]; N observations, n simulations.

        An upper bound: an image may hold more than linear statistics of it tell. NaN where it was not measured.
        """
        if self != type(self)():
            return np.nan
        at = np.hypot(theta[0], theta[1]), abs(theta[2])
        per_event = interpn((RADII, HEIGHTS), np.array(FLOORS), at, bounds_error=False, fill_value=np.nan)[0]
        return float((1 / num_observations + (0 if num_simulations is None else 1 / num_simulations)) * per_event)
