"""What a hidden effect is: the shape that it has, what is random in it, and the place where it acts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Simulate
from avobench.tasks import Task


@dataclass(frozen=True)
class Place:
    """A place where an effect may act: one feature, all of them, or the event as a whole (None)."""

    task: Task
    feature: int | Literal["all"] | None
    reference: NDArray
    """Events without the effect, (m, d). They give the scale on which strengths are meant."""

    @property
    def kind(self) -> Literal["counts", "continuous", "images", "other"]:
        """The kind of events: counts are not negative, and images are of hits that have no size."""
        if self.task.event_shape:
            images = len(self.task.event_shape) == 2 and bool(np.isin(self.reference, (0, 1)).all())
            return "images" if images else "other"
        if set(self.task.kinds_of_features) == {"continuous"}:
            return "continuous"
        counts = self.task.kinds_of_features == ("count",) and bool((self.reference >= 0).all())
        return "counts" if counts else "other"

    @cached_property
    def columns(self) -> list[int]:
        return [self.feature] if isinstance(self.feature, int) else list(range(self.task.num_features))

    @property
    def cosine(self) -> bool:
        """Whether the feature is the cosine of an angle. Its name then begins with `cos`."""
        names = self.task.feature_names
        return isinstance(self.feature, int) and bool(names) and names[self.feature].startswith("cos")

    @cached_property
    def mean(self) -> NDArray[np.float64]:
        """The mean of each column of the reference, (k,); of counts at least 1."""
        mean = self.reference[:, self.columns].mean(axis=0)
        return np.maximum(mean, 1.0) if self.kind == "counts" else mean

    @cached_property
    def std(self) -> NDArray[np.float64]:
        """The standard deviation of each column of the reference, (k,)."""
        return self.reference[:, self.columns].std(axis=0)

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        return self._range.mean(axis=0)

    @cached_property
    def half_range(self) -> NDArray[np.float64]:
        """Half of the range that holds all but 1 % of the reference, (k,). It is 1 for a cosine."""
        return (self._range[1] - self._range[0]) / 2

    @cached_property
    def _range(self) -> NDArray[np.float64]:
        if self.cosine:
            return np.array([[-1.0], [1.0]])
        return np.quantile(self.reference[:, self.columns], [0.005, 0.995], axis=0)

    @cached_property
    def spread(self) -> NDArray[np.float64]:
        """The standard deviation of each column on the scale where the range is [-1, 1], (k,)."""
        return self.std / self.half_range

    def quantile(self, share: float) -> NDArray[np.float64]:
        """The value that a share of the reference does not exceed, as `read` gives it, (k,)."""
        return np.quantile(self.read(self.reference), share, axis=0)

    def read(self, x: NDArray) -> NDArray:
        """What an effect sees of events (n, d).

        Counts are (n, k) floats. Real features are (n, k) on the scale where the range is [-1, 1]. Images are
        (n, rows, columns) of booleans.
        """
        if self.kind == "images":
            return x.reshape(-1, *self.task.event_shape) > 0
        features = x[:, self.columns].astype(float)
        return features if self.kind == "counts" else (features - self.centre) / self.half_range

    def write(self, x: NDArray, y: NDArray) -> NDArray:
        """Events x (n, d) in which what `read` gives is y; a cosine that runs over an end comes back from it."""
        if self.kind == "images":
            return y.reshape(x.shape).astype(x.dtype)
        changed = x.copy()
        if self.kind == "counts":
            z = np.maximum(np.rint(y), 0)
        else:
            z = self.centre + self.half_range * y
            if self.cosine:
                z = np.where(np.abs(z) > 1, np.abs((z - 1) % 4 - 2) - 1, z)
        changed[:, self.columns] = np.where(y == self.read(x), x[:, self.columns], z)  # to the last bit where it stays
        return changed


@dataclass(frozen=True)
class Range:
    """The range from which a setting of a shape is drawn, uniformly or log-uniformly, perhaps with either sign."""

    low: float
    high: float
    log: bool = False
    either_sign: bool = False

    def draw(self, rng: np.random.Generator) -> float:
        value = (
            np.exp(rng.uniform(np.log(self.low), np.log(self.high))) if self.log else rng.uniform(self.low, self.high)
        )
        return float(value * rng.choice([-1, 1])) if self.either_sign else float(value)


Measure = Callable[[Simulate, NDArray[np.float64], Place, SimpleNamespace, np.random.Generator], NDArray]
"""What a shape does: simulate, theta (n, p), the place, its settings, rng -> measured events (n, d)."""


@dataclass(frozen=True)
class Shape:
    """A way in which measured events may differ from simulated ones, declared apart from the catalogue."""

    name: str
    family: str
    """The name by which a diagnosis must call it: that of a family of the catalogue."""
    sentence: str
    """What happens, for a person."""
    stage: int
    """As `Effect.stage`."""
    ranges: Mapping[str, Range]
    """What is drawn. `strength` reaches from barely visible to strong."""
    suits: Callable[[Place], bool]
    """Whether the shape makes sense at a place."""
    measure: Measure

    def draw(self, place: Place, rng: np.random.Generator) -> "Injection":
        """An effect of this shape with random strength and settings."""
        return Injection(self, place, {name: each.draw(rng) for name, each in self.ranges.items()})


@dataclass(frozen=True)
class Injection:
    """An effect of foreign shape with all that is random in it fixed."""

    shape: Shape
    place: Place
    settings: Mapping[str, float]

    @property
    def name(self) -> str:
        return self.shape.family

    @property
    def stage(self) -> int:
        return self.shape.stage

    def stronger(self, factor: float) -> "Injection":
        """The same injection with its strength multiplied by a factor, within the range from which it is drawn."""
        high = self.shape.ranges["strength"].high
        strength = float(np.clip(factor * self.settings["strength"], -high, high))
        return replace(self, settings={**self.settings, "strength": strength})

    def measure(self, simulate: Simulate, theta: NDArray[np.float64], rng: np.random.Generator) -> NDArray:
        return self.shape.measure(simulate, theta, self.place, SimpleNamespace(**self.settings), rng)
