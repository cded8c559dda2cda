"""What shapes of continuous features share."""

import numpy as np
from numpy.typing import NDArray

from avobench.challenge.shapes.contract import Place


def continuous(place: Place) -> bool:
    """Whether the features there are numbers without steps, and few."""
    return not place.task.event_shape and not bool((place.reference == np.rint(place.reference)).all())


class OfOne:
    """What acts on one continuous feature."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return isinstance(place.feature, int) and continuous(place)


class OfTwo:
    """What acts on one continuous feature and depends on another."""

    @classmethod
    def suits(cls, place: Place) -> bool:
        return isinstance(place.feature, int) and place.task.num_features > 1 and continuous(place)


def partner(place: Place, which: float) -> Place:
    """Of another feature, numbered by `which` in [0, 1)."""
    others = [k for k in range(place.task.num_features) if k != place.feature]
    return Place(place.task, others[int(which * len(others))], place.reference)


def unit(place: Place, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """The place's own columns on the scale where the range is [-1, 1]: (n, k) -> (n, k)."""
    return (x - place.centre) / place.half_range


def restored(place: Place, u: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of `unit`; a cosine stays one."""
    x = place.centre + place.half_range * u
    return np.clip(x, -1, 1) if place.cosine else x


def moved(place: Place, x: NDArray[np.float64], by: NDArray[np.float64]) -> NDArray[np.float64]:
    """Columns moved by so many half ranges; of a cosine, the angle is turned by so many radians."""
    return np.cos(np.arccos(np.clip(x, -1, 1)) - by) if place.cosine else x + by * place.half_range
