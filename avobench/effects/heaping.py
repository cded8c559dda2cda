"""Heaping: values are recorded as round numbers near them."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.feature import KNOWN, REPEATED
from avobench.effects.contract import OF_FEATURE, Family, Parameter

ROUND = (1.0, 2.0, 2.5, 5.0)
"""Steps between round numbers, times any power of ten."""
OF_TIME = (6.0, 7.0, 12.0, 15.0, 24.0, 30.0, 60.0)
"""Other steps that are looked for: months, days and minutes come in these."""
CLEAR = 5.0
"""Standard deviations by which multiples of a step stand out from the values next to them."""
APART = 4.5
"""Grains of the values in a step, at least: what is finer is rounding, another shape of it."""
FINEST = 0.01
"""The finest step that is considered, in half ranges: a finer one is rounding."""
MOSTLY = 0.98
"""The largest share that a fit begins at: at one there is no slope to follow."""
REACHES = (0.05, 0.15, 0.5)
"""Reaches, in steps, from which a fit begins."""


class Heaps(NamedTuple):
    """Multiples of a step that stand out."""

    step: float
    share: float
    """The share of all values that is there beyond what the values next to them let expect."""
    z: float
    """Significance in standard deviations."""


NONE = Heaps(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Heaping(Family):
    """A share of the values is recorded as the nearest multiple of a step: of all values, or the more the nearer.

    In the shape `heaped_near` the share falls off with the distance d from the multiple, as exp(-d / (reach step)).
    """

    shape: str = "heaped"
    feature: int | Literal["all"] | None = None
    columns: tuple[int, ...] = (0,)
    """Where the values stand in an event."""
    whole: bool = False
    """Whether they are counts."""
    steps: tuple[float, float] = (5.0, 100.0)
    """The bounds of the step, next to each other where the data show it."""

    stage = 4
    name = "quantisation"
    domains = ("counts", "continuous")
    position = 33
    choices = 1
    STRENGTH = Parameter("share", 0, 1, 0, "1")
    sentence: ClassVar = "Round numbers are preferred: values near them are recorded as these."
    source: ClassVar = "D. F. Heitjan, D. B. Rubin, J. Am. Stat. Assoc. 85 (1990) 304"

    @classmethod
    def entries(cls, site):
        """One a feature that is a number, whether a count or not, and one that acts on all alike."""
        entries = [cls(feature=feature, columns=site.columns(feature), whole=True) for feature in site.counts]
        for feature in site.features:
            columns = site.columns(feature)
            widest = max(site.ranges[j].half for j in columns)
            entries.append(cls(feature=feature, columns=columns, steps=(FINEST * widest, widest)))
        return entries

    def variants(self):
        low, high = self.steps
        known = high - low < 4 * KNOWN * high
        step = Parameter("step", low, high, None, "counts" if self.whole else OF_FEATURE, known=known)
        return {"heaped": (step,), "heaped_near": (step, Parameter("reach", 0.03, 1, None, "steps"))}

    def shown(self, x: NDArray) -> Heaps:
        """The heaps of measured events x (N, d) that stand out most, of all features that it acts on."""
        return max((heaps(x[:, j], self.whole) for j in self.columns), key=lambda one: one.z)

    def adapted(self, x):
        step = self.shown(x).step
        return replace(self, steps=((1 - KNOWN) * step, (1 + KNOWN) * step) if step else self.steps)

    def guess(self, x):
        shown = self.shown(x)
        if not shown.step:
            return np.empty((0, len(self.parameters)))
        if self.shape == "heaped":
            return np.array([[min(shown.share, MOSTLY), shown.step]])
        reach = np.array(REACHES)
        of_all = 2 * reach * (1 - np.exp(-0.5 / reach))  # the mean of exp(-d / reach), d even from 0 to half a step
        return np.stack([np.minimum(shown.share / of_all, MOSTLY), np.full(3, shown.step), reach], axis=1)

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        values, share, step = x[:, self.columns], phi[:, :1], phi[:, 1:2]
        round_numbers = step * np.rint(values / step)
        if self.shape == "heaped_near":
            share = share * np.exp(-np.abs(values - round_numbers) / (phi[:, 2:] * step))
        if self.whole:
            round_numbers = np.rint(round_numbers)
        x[:, self.columns] = np.where(rng.random(values.shape) < share, round_numbers, values)
        return x


def heaps(x: NDArray, whole: bool) -> Heaps:
    """The step whose multiples hold most more of the values x (N,) than those next to them let expect.

    What to expect at a multiple is the cubic through the two values to either side of it, which lie a grain apart, of
    the numbers or of their logarithms, whichever is more: counts fall steeply. Of real numbers that nobody rounded
    nothing.
    """
    values, numbers = np.unique(x.astype(float), return_counts=True)
    often = values[numbers >= REPEATED]
    if len(often) < 3:
        return NONE
    gap = 1.0 if whole else float(np.median(np.diff(often)))
    rounded = whole or numbers[numbers >= REPEATED].sum() > len(x) / 2
    if not rounded:
        values, numbers = often, numbers[numbers >= REPEATED]
    best = NONE
    for step in _steps(APART * gap if rounded else (1 - KNOWN) * gap, (values[-1] - values[0]) / 2, whole):
        nearest = step * np.rint(values / step)
        away = np.abs(values - nearest) / gap
        if rounded:  # a multiple at the end of the values has no two on either side
            away[(nearest < values[0] + 2 * gap) | (nearest > values[-1] - 2 * gap)] = np.inf
        at, one, two = (float(numbers[np.abs(away - k) < 1e-3].sum()) for k in (0, 1, 2))
        expected = max((4 * one - two) / 6, _steep(nearest, away, numbers)) if rounded else 0.0
        z = (at - expected) / np.sqrt(at + expected + 1)
        if z > max(best.z, CLEAR):
            best = Heaps(step, (at - expected) / len(x), float(z))
    return best


def _steep(nearest: NDArray, away: NDArray, numbers: NDArray) -> float:
    """Sum of the cubics in logarithms at all multiples `nearest` (k,) with two of `numbers` (k,) on either side."""
    total = 0.0
    for multiple in np.unique(nearest[np.abs(away) < 1e-3]):
        beside = [numbers[(nearest == multiple) & (np.abs(away - k) < 1e-3)] for k in (1, 2)]
        if all(len(pair) == 2 for pair in beside):
            total += float(np.exp((4 * np.log(beside[0]).sum() - np.log(beside[1]).sum()) / 6))
    return total


def _steps(low: float, high: float, whole: bool) -> list[float]:
    """Steps from low to high, the largest first: real numbers that are heaped have the same heaps in finer steps."""
    if not 0 < low < high < np.inf:
        return []
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    steps = sorted({*(one * 10.0**power for one in ROUND for power in powers), *OF_TIME}, reverse=True)
    return [step for step in steps if low <= step <= high and not (whole and step % 1)]
