"""Effects hidden in measured data, written independently of the catalogue: other shapes of the same physics."""

from collections.abc import Sequence

import numpy as np

from avobench.challenge.shapes import eighth, fifth, first, fourth, ninth, second, seventh, sixth, third
from avobench.challenge.shapes.contract import Injection, Place, Simulate
from avobench.tasks import Task

__all__ = ["DEVELOPED", "FAMILIES", "SERIES", "Injection", "Place", "Simulate", "kind_of_events", "shapes"]

ONE_FAMILY = {
    ("counts", "after_pulses"): "double_counting",
    ("counts", "heaping"): "quantisation",
    ("counts", "spread"): "overdispersion",
    ("continuous", "heaping"): "quantisation",
    ("continuous", "censoring"): "saturation",
    ("continuous", "truncation"): "edge_acceptance",
    ("continuous", "turn_on"): "edge_acceptance",
}
"""What shapes were called, by the kind of events, where the catalogue has one family of two that data cannot tell."""
SERIES: dict[int, dict[str, tuple[type[Injection], ...]]] = {
    1: first.FAMILIES,
    2: second.FAMILIES,
    3: {kind: (*shapes, *third.NEW_FAMILIES[kind]) for kind, shapes in third.FAMILIES.items()},
    4: fourth.FAMILIES,
    5: fifth.FAMILIES,
    6: sixth.FAMILIES,
    7: seventh.FAMILIES,
    8: eighth.FAMILIES,
    9: ninth.FAMILIES,
}
"""The shapes of each series, by the kind of events."""
DEVELOPED = (1, 2)
"""The series that the search for effects was developed on, which are hidden unless others are asked for."""
FAMILIES: dict[str, tuple[type[Injection], ...]] = {
    kind: tuple(shape for each in SERIES.values() for shape in each[kind]) for kind in first.FAMILIES
}
"""All shapes, by the kind of events."""
for _kind, _shapes in FAMILIES.items():
    for _shape in _shapes:
        _shape.name = ONE_FAMILY.get((_kind, _shape.name), _shape.name)


def kind_of_events(task: Task) -> str:
    """counts, continuous or images."""
    if task.event_shape:
        return "images"
    return "counts" if np.issubdtype(np.dtype(task.dtype), np.integer) else "continuous"


def shapes(place: Place, series: Sequence[int] = DEVELOPED) -> list[type[Injection]]:
    """The shapes of these series that make sense at `place`."""
    kind = kind_of_events(place.task)
    return [shape for each in series for shape in SERIES[each][kind] if shape.suits(place)]
