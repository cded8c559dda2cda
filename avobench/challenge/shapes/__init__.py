"""Effects hidden in measured data, written independently of the catalogue: other shapes of the same physics."""

import numpy as np

from avobench.challenge.shapes import first, second
from avobench.challenge.shapes.contract import Injection, Place, Simulate
from avobench.tasks import Task

__all__ = ["FAMILIES", "Injection", "Place", "Simulate", "kind_of_events", "shapes"]

FAMILIES: dict[str, tuple[type[Injection], ...]] = {
    kind: (*shapes, *second.FAMILIES[kind]) for kind, shapes in first.FAMILIES.items()
}
"""All shapes, by the kind of events; each series lists its own."""


def kind_of_events(task: Task) -> str:
    """counts, continuous or images."""
    if task.event_shape:
        return "images"
    return "counts" if np.issubdtype(np.dtype(task.dtype), np.integer) else "continuous"


def shapes(place: Place) -> list[type[Injection]]:
    """The shapes that make sense at `place`."""
    return [shape for shape in FAMILIES[kind_of_events(place.task)] if shape.suits(place)]
