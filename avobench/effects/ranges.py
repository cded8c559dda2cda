"""Where the features of events lie: over the whole prior of a simulator, or as measured events show it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.checked import checked_events

REFERENCE_EVENTS = 20_000
"""Events over the prior, from which the range of each feature is read: enough that its ends are seen."""
OUTERMOST = 0.01
"""Share of the range, at either end, in which events are counted to tell whether it ends sharply."""
SHARP = 0.002
"""The least share of the events that the outermost hundredth of a sharp end holds: a fifth of an even share."""
DEVIATIONS = 3.5
"""How far a feature without sharp ends reaches to either side of the median, in standard deviations."""
SHOWN = (0.005, 0.995)
"""Quantiles of measured events between which a feature without sharp ends is said to lie."""


@dataclass(frozen=True)
class Range:
    """The range of a feature."""

    low: float
    high: float
    bounded: bool
    """Whether it ends sharply at both ends, as a cosine does."""
    periodic: bool = False
    """Whether it comes round again at its ends, as an angle does."""
    positive: bool = False
    """Whether it has no negative values, as an energy or a time."""

    @property
    def centre(self) -> float:
        return (self.low + self.high) / 2

    @property
    def half(self) -> float:
        return (self.high - self.low) / 2

    def relative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """x in units of the largest magnitude in the range."""
        return x / max(abs(self.low), abs(self.high))

    def unit(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """x in units where the range is [-1, 1]."""
        return (x - self.centre) / self.half

    def angle(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angle whose cosine is `unit(x)`: the natural variable of a bounded feature. [0, pi]"""
        return np.arccos(np.clip(self.unit(x), -1, 1))

    def cosine(self, angle: NDArray[np.float64]) -> NDArray[np.float64]:
        """The feature at an angle."""
        return self.centre + self.half * np.cos(angle)

    def shown(self, column: NDArray[np.float64]) -> "Range":
        """The range that values (n,) show: its own where it ends sharply, else that of all but one in a hundred."""
        low, high = np.quantile(column, SHOWN).tolist()
        return self if self.bounded or self.periodic or low == high else replace(self, low=low, high=high)

    def wrapped(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angles x moved into the range by whole periods. Other features are returned unchanged."""
        return self.low + (x - self.low) % (self.high - self.low) if self.periodic else x

    def reflect(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """x folded back into the range."""
        return self.low + 2 * self.half * (1 - np.abs((x - self.low) / (2 * self.half) % 2 - 1))


def ranges(task: Task, x: NDArray | None = None) -> tuple[Range, ...]:
    """The range of each feature, from events over the prior: exact ends if they are sharp, 3.5 deviations else.

    They are read from events x (n, d) over the prior; REFERENCE_EVENTS are simulated where it is None.

    An end is sharp if the outermost hundredth of the range holds at least a fifth of an even share of the events. The
    range of an angle is once round: from zero, or as far to either side of it where some are negative. Raises
    SimulatorError for events that are not those that the task declares.
    """
    if x is None:
        rng = np.random.default_rng(0)
        x = checked_events(task, task.prior.sample(REFERENCE_EVENTS, rng), rng)
    found = []
    units = task.feature_units or ("",) * task.num_features
    for column, kind, unit in zip(x.T.astype(float), task.kinds_of_features, units, strict=True):
        low, high = column.min(), column.max()
        positive = bool(low >= 0)
        if kind == "angle":
            once = 360.0 if unit == "deg" else 2 * np.pi
            start = -once / 2 if low < 0 else 0.0
            found.append(Range(start, start + once, False, periodic=True))
            continue
        margin = OUTERMOST * (high - low)
        share = min(np.mean(column < low + margin), np.mean(column > high - margin))
        if share > SHARP:
            low, high = _round_out(low, high)
            found.append(Range(low, high, True, positive=positive))
        else:
            centre, spread = np.median(column), column.std()
            reach = DEVIATIONS * spread
            found.append(Range(centre - reach, centre + reach, False, positive=positive))
    return tuple(found)


def _round_out(low: float, high: float) -> tuple[float, float]:
    """The nearest round numbers outside the smallest and the largest of many events."""
    step = 10.0 ** np.floor(np.log10((high - low) / 100))
    return float(np.floor(low / step) * step), float(np.ceil(high / step) * step)
