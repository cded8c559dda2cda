"""Effects by which some events come from elsewhere: a flat background, a peak, or a second exponential."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import ndtr, ndtri

from avobench.effects.continuous.feature import Background
from avobench.effects.contract import Parameter


@dataclass(frozen=True)
class FlatBackground(Background):
    """A share of the events is uniform over the range, or over the angle, or falls along it or towards both ends."""

    shape: str = "uniform"
    name = "flat_background"
    position = 6
    sentence = "Some events are background that spreads evenly over the range."
    source = "G. Cowan, Statistical Data Analysis (1998), Section 6.9"
    STRENGTH = Parameter("fraction", 0, 0.95, 0, "1")
    SHAPES: ClassVar = {"uniform": (), "domed": (), "sloped": (Parameter("slope", -1, 1, None, "1"),)}

    def variants(self):
        return self.SHAPES | ({"angle": ()} if self.bounded else {"wider": (Parameter("width", 0.5, 4, None, "1"),)})

    def drawn(self, span, phi, rng):
        u = rng.random(len(phi))
        if self.shape == "angle":
            return span.cosine(np.pi * u)
        v = 2 * rng.beta(1.5, 1.5, len(phi)) - 1 if self.shape == "domed" else 2 * u - 1
        if self.shape == "sloped":  # density (1 + slope v) / 2, by reflection
            v = np.where(rng.random(len(phi)) < (1 + phi[:, 1] * v) / 2, v, -v)
        return span.centre + span.half * v * (phi[:, 1] if self.shape == "wider" else 1)


NOISE = {
    "gaussian": lambda n, rng: rng.standard_normal(n),
    # Cut where it would reach far beyond the range, and narrowed to about the same width.
    "lorentzian": lambda n, rng: np.tan(np.pi * 0.45 * rng.uniform(-1, 1, n)) / 1.2,
    "box": lambda n, rng: np.sqrt(3) * rng.uniform(-1, 1, n),
    "tail_below": lambda n, rng: _crystal_ball(n, rng),
    "tail_above": lambda n, rng: -_crystal_ball(n, rng),
}
"""Random distances (n,) from the centre, in widths, by shape."""

TAIL = (1.0, 3.0)
"""Where the tail of a peak begins, in widths from its centre, and the power that it falls by."""


def _crystal_ball(n, rng):
    """Distances (n,) of a Gaussian that goes over smoothly into a power below (T. Skwarnicki, DESY F31-86-02)."""
    begin, power = TAIL
    tail, core = power / begin / (power - 1) * np.exp(-(begin**2) / 2), np.sqrt(2 * np.pi) * ndtr(begin)
    u = rng.random(n)
    gaussian = ndtri(1 - ndtr(begin) * u)  # above -begin
    beyond = power / begin * ((1 - u) ** (-1 / (power - 1)) - 1)
    return np.where(rng.random(n) < tail / (tail + core), -begin - beyond, gaussian)


@dataclass(frozen=True)
class PeakBackground(Background):
    """A share of the events forms a peak: Gaussian, Lorentzian, a box of the same deviation, or with a tail."""

    shape: str = "gaussian"
    name = "peak_background"
    position = 7
    sentence = "Some events are background gathered at one place, as from a resonance or a hot spot."
    source = "G. Cowan, Statistical Data Analysis (1998), Section 6.9"
    STRENGTH = Parameter("fraction", 0, 0.9, 0, "1")

    def variants(self):
        place = self.place(0.01, 0.35)
        return {shape: place for shape in NOISE}

    def within(self, low, high, column):
        low, high = self.placed(np.array([low, high]), self.ranges[column])
        return np.array([(low + high) / 2, (high - low) / np.sqrt(12)])

    def drawn(self, span, phi, rng):
        value = phi[:, 1] + phi[:, 2] * NOISE[self.shape](len(phi), rng)
        if self.feature == "all":
            value = span.centre + span.half * value
        return span.reflect(value) if span.bounded else value


@dataclass(frozen=True)
class SecondExponential(Background):
    """A share of the events falls off exponentially from the lower end of the range, or from the upper."""

    shape: str = "falling"
    stage = 1
    on_all = False
    name = "second_exponential"
    position = 25
    sentence = "Some events decay with a lifetime of their own."
    source = "G. F. Knoll, Radiation Detection and Measurement, 4th ed. (2010), Chapter 1"
    STRENGTH = Parameter("fraction", 0, 0.95, 0, "1")

    @classmethod
    def acts_on(cls, span):
        return span.positive

    def variants(self):
        length = Parameter("length", 0.02 * self.half, 3 * self.half, None, "of the feature")
        return {shape: (length,) for shape in ("falling", "rising")}

    def drawn(self, span, phi, rng):
        most = -np.expm1(-2 * span.half / phi[:, 1]) if span.bounded else 1
        from_end = -phi[:, 1] * np.log1p(-most * rng.random(len(phi)))
        return span.low + from_end if self.shape == "falling" else span.high - from_end
