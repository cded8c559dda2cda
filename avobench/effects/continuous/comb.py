"""Even steps that are blurred, as a line in the spectrum of the values shows them."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

FINE = 8192
"""Bins of the histogram whose spectrum is taken: eight for each of the finest steps."""
FINER = 4
"""Frequencies of the spectrum a cycle over the range: enough that no line falls between two."""
STEPS = (4, 1000)
"""Steps that a range may have: fewer are no scale, more are finer than the histogram shows."""
PLAIN = 0.1
"""The least amplitude of a comb, since a range that ends sharply has lines nearly as high."""
CHANCE = 5.0
"""Standard errors that the line of a comb has more than that."""
LINE = 3.0
"""How far the line of a comb stands above the frequencies beside it."""
FIRST = 0.9
"""Least height of the first line of a comb in that of the highest: harmonics of sharp steps are nearly as high."""


@dataclass(frozen=True)
class Comb:
    """Even steps, each blurred, in which values of a feature lie."""

    step: float
    error: float
    """The relative standard error of the step."""
    origin: float
    """One of the values, near the middle."""
    share: float
    """The approximate share of the values that lie in steps."""
    noise: float
    """The approximate noise of each value, in steps."""

    @classmethod
    def shown(cls, x: NDArray[np.float64]) -> Self | None:
        """The comb of values (n,) that are all different: a line in their spectrum, if there is one.

        With its harmonic it also tells the noise: the spectrum of a comb falls as that of the blur.
        """
        low, high = np.quantile(x, [0.005, 0.995])
        if not high > low:
            return None
        counts = np.histogram(x, FINE, (low, high))[0]
        spectrum = np.abs(np.fft.rfft(counts, FINER * FINE)) / counts.sum()
        cycles = np.arange(len(spectrum)) / FINER
        heights = np.where((cycles >= STEPS[0]) & (cycles <= STEPS[1]), spectrum, 0)
        line = cycles[np.argmax(heights > FIRST * heights.max())]  # sharp steps have harmonics as high
        beside = spectrum[(np.abs(cycles - line) < line / 2) & (np.abs(cycles - line) > 1.5)]

        def amplitude(cycles: float) -> complex:
            return complex(np.exp(2j * np.pi * cycles * (x - low) / (high - low)).mean())

        ends = (line - 3 / FINER, line + 3 / FINER)
        line = float(minimize_scalar(lambda c: -abs(amplitude(c)), bounds=ends, method="bounded").x)
        first, second = amplitude(line), max(abs(amplitude(2 * line)), 1 / np.sqrt(len(x)))
        if abs(first) < max(PLAIN + CHANCE / np.sqrt(len(x)), LINE * float(np.median(beside))):
            return None
        variance = max(np.log(abs(first) / second), 0) / (6 * np.pi**2)
        step = float(high - low) / line
        line *= 1 + float(variance * step**2 / x.var())  # the fall moves the line
        first, step = amplitude(line), float(high - low) / line
        origin = float(low + step * (np.angle(first) / (2 * np.pi) + line // 2))
        share = min(abs(first) * float(np.exp(2 * np.pi**2 * variance)), 1.0)
        error = 1 / (abs(first) * np.sqrt(len(x)) * line)
        return cls(step, float(error), origin, share, float(np.sqrt(variance)))
