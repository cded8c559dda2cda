"""What effects on real features share: the range of each feature, and the columns to act on."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Effect, Parameter, accepted
from avobench.tasks import Task

REFERENCE_EVENTS = 20_000


@dataclass(frozen=True)
class Range:
    """Where a feature lies: over the whole prior of a simulator, or as events show it."""

    low: float
    high: float
    bounded: bool
    """Whether it ends sharply at both ends, as a cosine does."""

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
        low, high = np.quantile(column, [0.005, 0.995]).tolist()
        return self if self.bounded or low == high else Range(low, high, False)

    def reflect(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """x folded back into the range."""
        return self.low + 2 * self.half * (1 - np.abs((x - self.low) / (2 * self.half) % 2 - 1))


def ranges(task: Task) -> tuple[Range, ...]:
    """The range of each feature, from events over the prior: exact ends if they are sharp, 3.5 deviations else.

    An end is sharp if the outermost hundredth of the range holds at least a fifth of an even share of the events.
    """
    rng = np.random.default_rng(0)
    x = task.simulate(task.prior.sample(REFERENCE_EVENTS, rng), rng)
    found = []
    for column in x.T.astype(float):
        low, high = column.min(), column.max()
        margin = 0.01 * (high - low)
        share = min(np.mean(column < low + margin), np.mean(column > high - margin))
        if share > 0.002:
            low, high = _round_out(low, high)
            found.append(Range(low, high, True))
        else:
            centre, spread = np.median(column), column.std()
            found.append(Range(centre - 3.5 * spread, centre + 3.5 * spread, False))
    return tuple(found)


def _round_out(low: float, high: float) -> tuple[float, float]:
    """The nearest round numbers outside the smallest and the largest of many events."""
    step = 10.0 ** np.floor(np.log10((high - low) / 100))
    return float(np.floor(low / step) * step), float(np.ceil(high / step) * step)


@dataclass(frozen=True)
class FeatureEffect(Effect):
    """An effect on one feature or on all alike; `shape` is one of `variants()`."""

    feature: int | Literal["all"] = 0
    ranges: tuple[Range, ...] = ()
    shape: str = ""

    @property
    def columns(self) -> range:
        return range(len(self.ranges)) if self.feature == "all" else range(self.feature, self.feature + 1)

    @property
    def bounded(self) -> bool:
        return all(self.ranges[j].bounded for j in self.columns)

    @property
    def half(self) -> float:
        """Half the range; the widest where the effect acts on all features."""
        return max(self.ranges[j].half for j in self.columns)

    @property
    def low(self) -> float:
        return min(self.ranges[j].low for j in self.columns)

    @property
    def high(self) -> float:
        return max(self.ranges[j].high for j in self.columns)

    def adapted(self, x):
        return replace(self, ranges=tuple(span.shown(x[:, j]) for j, span in enumerate(self.ranges)))

    def strength(self) -> Parameter:
        raise NotImplementedError

    def place(self, narrow: float, wide: float) -> tuple[Parameter, Parameter]:
        """A centre and a width, the bounds of which are given in half ranges: of the feature; of each where all."""
        scale, low, high, unit = self.half, self.low, self.high, "of the feature"
        if self.feature == "all":
            scale, low, high, unit = 1.0, -1.0, 1.0, "of half the range"
        return (
            Parameter("centre", low, high, None, unit),
            Parameter("width", narrow * scale, wide * scale, None, unit),
        )

    def placed(self, x: NDArray[np.float64], span: Range) -> NDArray[np.float64]:
        """Values of a feature in the units of `place`."""
        return span.unit(x) if self.feature == "all" else x

    def variants(self) -> dict[str, tuple[Parameter, ...]]:
        """The shapes: name -> parameters beside the strength."""
        return {"": ()}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (self.strength(), *self.variants()[self.shape])

    def shapes(self) -> tuple[Effect, ...]:
        return tuple(replace(self, shape=shape) for shape in self.variants())


@dataclass(frozen=True)
class Change(FeatureEffect):
    """An effect that changes the value of a feature."""

    def changed(self, x, span, phi, rng):
        """New values of one feature: x (n,), its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        for j in self.columns:
            x[:, j] = self.changed(x[:, j], self.ranges[j], phi, rng)
        return x


@dataclass(frozen=True)
class Background(FeatureEffect):
    """An effect by which a share of the events, its strength, comes from elsewhere: in all the features it acts on."""

    stage = 4

    def drawn(self, span, phi, rng):
        """Values of one feature: its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        for j in self.columns:
            x[rows, j] = self.drawn(self.ranges[j], phi[rows], rng)
        return x


@dataclass(frozen=True)
class Acceptance(FeatureEffect):
    """An effect that loses events, with a probability that depends on a feature."""

    stage = 3

    def kept(self, x, span, phi):
        """The chance to be recorded: x (n,), its Range, phi (n, q) -> (n,)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        def keep(x, rows):
            return np.prod([self.kept(x[:, j], self.ranges[j], phi[rows]) for j in self.columns], axis=0)

        return accepted(simulate, theta, keep, rng)
