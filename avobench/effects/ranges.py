"""Where the features of events lie: over the whole prior of a simulator, or as measured events show it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avobench.tasks import Task
from avobench.tasks.checked import checked_events
from avobench.tasks.missing import filled

REFERENCE_EVENTS = 20_000
"""Events over the prior, from which the range of each feature is read: enough that its ends are seen."""
OUTERMOST = (50, 20, 100)
"""To tell whether an end is sharp, one in 50 values is looked at there, but at least 20 and at most 100."""
SHARP = -0.5
"""Extreme value index below which an end is sharp: -1 for a density that ends in a step, -1/2 for one that falls to
zero in a straight line, 0 for an exponential tail."""
DEVIATIONS = 3.5
"""How far a feature reaches from the median to an end that is not sharp, in standard deviations."""
SHOWN = (0.005, 0.995)
"""Quantiles of measured events at which a feature is said to end where its end is not sharp."""


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
    sharp_low: bool = False
    """Whether it ends sharply at the lower end, as a time since a start does."""
    sharp_high: bool = False

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
        return self.centre + self.half * np.cos(angle)

    def shown(self, column: NDArray[np.float64]) -> "Range":
        """The range that values (n,) show, each end by itself.

        It is the range's own end where that is sharp, else where the values end if they do so sharply, else the value
        beyond which one in 200 lies.
        """
        low, high = np.quantile(column, SHOWN).tolist()
        if self.bounded or self.periodic or low == high:
            return self
        rounded = _round_out(column.min(), column.max())
        if self.sharp_low or ends_sharply(-column):
            low = self.low if self.sharp_low else rounded[0]
        if self.sharp_high or ends_sharply(column):
            high = self.high if self.sharp_high else rounded[1]
        return replace(self, low=low, high=high) if low < high else self

    def wrapped(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angles x moved into the range by whole periods. Other features are returned unchanged."""
        return self.low + (x - self.low) % (self.high - self.low) if self.periodic else x

    def reflect(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """x folded back into the range."""
        return self.low + 2 * self.half * (1 - np.abs((x - self.low) / (2 * self.half) % 2 - 1))


def ranges(task: Task, x: NDArray | None = None) -> tuple[Range, ...]:
    """The range of each feature, from events x (n, d) over the prior: exact if it ends sharply, else 3.5 deviations.

    REFERENCE_EVENTS are simulated where x is None. An angle's is once round: from zero, or to either side of it where
    some are negative. Raises SimulatorError for events that are not those that the task declares.
    """
    if x is None:
        rng = np.random.default_rng(0)
        x = checked_events(task, task.prior.sample(REFERENCE_EVENTS, rng), rng)
    x, spans = filled(x), []
    units = task.feature_units or ("",) * task.num_features
    for column, kind, unit in zip(x.T.astype(float), task.kinds_of_features, units, strict=True):
        low, high = column.min(), column.max()
        positive = bool(low >= 0)
        if kind == "angle":
            once = 360.0 if unit == "deg" else 2 * np.pi
            start = -once / 2 if low < 0 else 0.0
            spans.append(Range(start, start + once, False, periodic=True))
            continue
        sharp_low, sharp_high = ends_sharply(-column), ends_sharply(column)
        centre, reach = float(np.median(column)), DEVIATIONS * float(column.std())
        low, high = (
            _round_out(low, high)[0] if sharp_low else centre - reach,
            _round_out(low, high)[1] if sharp_high else centre + reach,
        )
        spans.append(Range(low, high, sharp_low and sharp_high, False, positive, sharp_low, sharp_high))
    return tuple(spans)


def ends_sharply(column: NDArray[np.float64]) -> bool:
    """Whether the density of values (n,) does not fall to zero towards their upper end.

    By the extreme value index of the largest values, a generalised Pareto distribution fitted to them by probability
    weighted moments (J. R. M. Hosking, J. R. Wallis, Technometrics 29 (1987) 339).
    """
    share, least, most = OUTERMOST
    count = min(max(len(column) // share, least), most, len(column) - 1)
    highest = np.sort(np.partition(column, len(column) - count - 1)[-count - 1 :])
    excess = highest[1:] - highest[0]
    mean = excess.mean()
    weighted = (excess * (1 - (np.arange(count) + 0.65) / count)).mean()
    return bool(mean > 2 * weighted and 2 - mean / (mean - 2 * weighted) < SHARP)


def _round_out(low: float, high: float) -> tuple[float, float]:
    step = 10.0 ** np.floor(np.log10((high - low) / 100))
    return float(np.floor(low / step) * step), float(np.ceil(high / step) * step)
