"""A peak of background: some events are gathered at one place."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from avobench.effects.continuous.feature import Background
from avobench.effects.contract import Parameter

NOISE = {
    "gaussian": lambda n, rng: rng.standard_normal(n),
    # Cut where it would reach far beyond the range, and narrowed to about the same width.
    "lorentzian": lambda n, rng: np.tan(np.pi * 0.45 * rng.uniform(-1, 1, n)) / 1.2,
    "box": lambda n, rng: np.sqrt(3) * rng.uniform(-1, 1, n),
    "tail_below": lambda n, rng: _crystal_ball(n, rng),
    "tail_above": lambda n, rng: -_crystal_ball(n, rng),
}
"""By shape: distances (n,) from the centre, in widths."""

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

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.9, 0, "1")

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
