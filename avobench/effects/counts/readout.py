"""Effects of how counts are read out: a background, noise, steps, or the end of the scale."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Parameter
from avobench.effects.counts.feature import CountEffect, whole


@dataclass(frozen=True)
class FlatBackground(CountEffect):
    """A share of the events has nothing to do with the source: counts are uniform, or exponential, up to `reach`.

    In the shape `added` such counts come on top of those of the source. In `swept` their rate swings up and down.
    """

    shape: str = "uniform"

    stage = 4
    name = "flat_background"
    position = 5
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {
        "uniform": (Parameter("reach", 2, 400, None, "counts"),),
        "exponential": (Parameter("reach", 1, 200, None, "counts"),),
        "added": (Parameter("reach", 1, 200, None, "counts"),),
        "swept": (Parameter("reach", 2, 400, None, "counts"),),
    }
    sentence: ClassVar = "Some events are background whose counts spread over the whole range."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 20.II"

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        reach, u = phi[rows, 1:], rng.random((len(rows), len(self.columns)))
        if self.shape == "swept":
            drawn = rng.poisson(reach * np.sin(np.pi / 2 * u) ** 2)
        else:
            drawn = u * (reach + 1) if self.shape == "uniform" else -reach * np.log1p(-u)
        x[self.cells(rows)] = np.floor(drawn) + (x[self.cells(rows)] if self.shape == "added" else 0)
        return x


NOISE = {
    "gaussian": lambda n, rng: rng.standard_normal(n),
    "laplace": lambda n, rng: rng.laplace(0, np.sqrt(0.5), n),
    "jumps": lambda n, rng: rng.choice([-1.0, 1.0], n),
    "hum": lambda n, rng: np.sqrt(2) * np.sin(2 * np.pi * rng.random(n)),
}
"""Random errors of standard deviation 1, of size n, by shape; other shapes have the Gaussian one."""


@dataclass(frozen=True)
class ReadoutNoise(CountEffect):
    """Noise of standard deviation `sigma` is added to each count, rounded, and cut at zero.

    In the shape `sometimes` to a share of the readings. In `jumps` a share of them is too high or too low by `sigma`,
    in `hum` each by what a sine wave has at some phase. In `upset` one bit of a share of them is the wrong one.
    """

    shape: str = "gaussian"

    stage = 4
    name = "readout_noise"
    position = 7
    STRENGTH = Parameter("sigma", 0, 30, 0, "counts", soft=True)
    SHAPES: ClassVar = {
        "gaussian": (),
        "laplace": (),
        "folded": (),
        "sometimes": (Parameter("share", 0.01, 1, None, "1"),),
        "jumps": (Parameter("share", 0.01, 1, None, "1"),),
        "hum": (),
        "upset": (Parameter("bits", 1, 8, None, "1"),),
    }
    sentence: ClassVar = "The electronics adds noise of its own to the readings."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.III"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1, 0, "1") if self.shape == "upset" else self.STRENGTH

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        if self.shape == "upset":
            read, n = whole(x[:, self.columns]), (len(x), len(self.columns))
            flipped = read ^ (1 << (phi[:, 1:] * rng.random(n)).astype(int))
            x[:, self.columns] = np.where(rng.random(n) < phi[:, :1], flipped, read)
            return x
        n = (len(x), len(self.columns))
        noise = NOISE.get(self.shape, NOISE["gaussian"])(n, rng)
        if self.shape in ("sometimes", "jumps"):
            noise = noise * (rng.random(n) < phi[:, 1:])
        y = np.rint(x[:, self.columns] + phi[:, :1] * noise)
        x[:, self.columns] = np.abs(y) if self.shape == "folded" else np.maximum(y, 0)
        return x


ONE_VALUE = 0.95
"""Share of the counts that a rounding may make the same, at most."""

ROUNDINGS = {
    "down": lambda step: (0, 0),
    "up": lambda step: (step - 1, 0),
    "nearest": lambda step: (step // 2, 0),
    "middle": lambda step: (0, step // 2),
}
"""What is added to a count before it is rounded down to a step, and after."""
STEPS = {
    f"{step} {to}": (step, *added(step))
    for step in (2, 3, 4, 5, 6, 7, 8, 10, 12, 16)
    for to, added in ROUNDINGS.items()
    if step > 2 or to in ("down", "up")  # of two counts there is no middle
}
"""A step, and what is added before and after, by shape."""
BITS = {
    f"bit {bit} {at}": (1 << bit, at == "high")
    for bit in range(4)
    for at in ("low", "high")
    if (bit, at) != (0, "low")  # that is rounding down to even counts
}
"""A bit of the counter that sticks, and whether it is set, by shape."""


@dataclass(frozen=True)
class Quantisation(CountEffect):
    """A share of the readings is known only in steps of `shape` counts, rounded as it says; or one bit sticks."""

    shape: str = "2 down"

    stage = 4
    name = "quantisation"
    position = 8
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    SHAPES: ClassVar = {shape: () for shape in (*STEPS, *BITS)}
    sentence: ClassVar = "Readings are rounded to a coarser step than one count."
    source: ClassVar = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Section 17.V"

    def guess(self, x):
        """There is no start where the step is so wide that nearly all counts become the same: that is no rounding."""
        same = max(np.unique(self._rounded(x[:, j]), return_counts=True)[1].max() for j in self.columns)
        return np.empty((0, 1)) if same > ONE_VALUE * len(x) else None

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        for j in self.columns:
            rows = rng.random(len(x)) < phi[:, 0]
            x[rows, j] = self._rounded(x[rows, j])
        return x

    def _rounded(self, x):
        if self.shape in BITS:
            bit, high = BITS[self.shape]
            return whole(x) | bit if high else whole(x) & ~bit
        step, before, after = STEPS[self.shape]
        return (x + before) // step * step + after


CLEAR = 5.0
"""Standard deviations by which the events at a limit stand out from those of the counts next to it."""
SHARES = (0.98, 0.4, 0.1)
"""Shares at which a fit begins: at one there is no slope to follow."""
LOWEST = 0.1
"""Share of the events that a limit above has below it, at least, and one below above it: most may be at the limit."""
OUTERMOST = 3
"""Counts at the end of the data that may be the limit, though none of them stands out."""


@dataclass(frozen=True)
class Censoring(CountEffect):
    """A share of the counts beyond a limit is recorded as the limit.

    Between two whole numbers the limit is, in so large a share of the events, the upper one: as where several counters
    take turns of which one stops later.
    """

    shape: str = "above"
    least: tuple[float, float] = (1.0, 1.0)
    """Counts that bound the limit: one above lies at the first or higher, one below at the second or lower."""
    ends: tuple[float, float] = (0.0, 100.0)
    """The smallest and the largest of the measured counts."""

    stage = 4
    name = "censoring"
    position = 35
    STRENGTH = Parameter("fraction", 0, 1, 0, "1")
    sentence: ClassVar = "Counts beyond the end of the scale are recorded as its end, where they gather."
    source: ClassVar = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def variants(self):
        bounds = {"above": (self.least[0], self.ends[1]), "below": (self.ends[0], self.least[1])}
        return {
            shape: (Parameter("limit", low, max(high, low + 1), None, "counts"),)
            for shape, (low, high) in bounds.items()
        }

    def adapted(self, x):
        columns = x[:, self.columns]
        ends = float(columns.min()), float(columns.max())
        least = tuple(float(value) for value in np.quantile(columns, [LOWEST, 1 - LOWEST]))
        return replace(self, least=least, ends=ends)

    def guess(self, x):
        """The count that stands out most, and the outermost ones."""
        adapted, above = self.adapted(x), self.shape == "above"
        _, limit = adapted.parameters
        outermost = limit.high - np.arange(OUTERMOST) if above else max(limit.low, 1.0) + np.arange(OUTERMOST)
        spikes = [_spike(x[:, j], above) for j in self.columns]
        limits = np.unique([*outermost, *(spike for spike in spikes if spike is not None)])
        return np.array([[share, at] for at in limits if limit.low <= at <= limit.high for share in SHARES])

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        counts = x[:, self.columns]
        limit = np.floor(phi[:, 1:] + rng.random(counts.shape))
        beyond = counts > limit if self.shape == "above" else counts < limit
        x[:, self.columns] = np.where(beyond & (rng.random(counts.shape) < phi[:, :1]), limit, counts)
        return x


def _spike(x: NDArray, above: bool) -> int | None:
    """The count of x (N,) that most stands out from those next to it, no end of the other side; None for none.

    Zero is none: nothing is below it.
    """
    values, numbers = np.unique(np.maximum(x, 0).astype(np.int64), return_counts=True)
    next_to = np.zeros(len(values))
    for step in (-1, 1):
        at = np.minimum(np.searchsorted(values, values + step), len(values) - 1)
        next_to = np.maximum(next_to, np.where(values[at] == values + step, numbers[at], 0))
    z = (numbers - next_to) / np.sqrt(numbers + next_to)
    low, high = np.quantile(x, [LOWEST, 1 - LOWEST])
    z[(values < low) if above else (values > high)] = -np.inf
    z[values == 0] = -np.inf
    best = int(z.argmax())
    return int(values[best]) if z[best] > CLEAR else None
