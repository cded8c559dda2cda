"""Backgrounds: some events come from elsewhere."""

from dataclasses import dataclass

import numpy as np

from avobench.diagnosis.effects.base import Parameter
from avobench.diagnosis.effects.continuous.base import Change

COWAN = "G. Cowan, Statistical Data Analysis (1998), Section 6.9"


@dataclass(frozen=True)
class FlatBackground(Change):
    """A share of the events is uniform over the range, or over the angle, or falls along it."""

    shape: str = "uniform"
    name = "flat_background"
    sentence = "Some events are background that spreads evenly over the range."
    source = COWAN

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.95, 0, "1")

    def variants(self):
        shapes = {"uniform": (), "sloped": (Parameter("slope", -1, 1, None, "1"),)}
        return shapes | ({"angle": ()} if self.bounded else {"wider": (Parameter("width", 0.5, 4, None, "1"),)})

    def changed(self, x, span, phi, rng):
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        u = rng.random(len(rows))
        if self.shape == "angle":
            value = span.cosine(np.pi * u)
        else:
            v = 2 * u - 1
            if self.shape == "sloped":  # density (1 + slope v) / 2, by reflection
                v = np.where(rng.random(len(rows)) < (1 + phi[rows, 1] * v) / 2, v, -v)
            value = span.centre + span.half * v * (phi[rows, 1] if self.shape == "wider" else 1)
        x = x.copy()
        x[rows] = value
        return x


@dataclass(frozen=True)
class PeakBackground(Change):
    """A share of the events forms a peak: Gaussian, Lorentzian or a box of the same standard deviation."""

    shape: str = "gaussian"
    name = "peak_background"
    sentence = "Some events are background gathered at one place, as from a resonance or a hot spot."
    source = COWAN

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.9, 0, "1")

    def variants(self):
        where = Parameter("centre", self.low, self.high, None, "of the feature")
        width = Parameter("width", 0.01 * self.half, 0.35 * self.half, None, "of the feature")
        return {"gaussian": (where, width), "lorentzian": (where, width), "box": (where, width)}

    def within(self, low, high):
        return np.array([(low + high) / 2, (high - low) / np.sqrt(12)])

    def changed(self, x, span, phi, rng):
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        n = len(rows)
        noise = {
            "gaussian": lambda: rng.standard_normal(n),
            "lorentzian": lambda: np.tan(np.pi * 0.45 * rng.uniform(-1, 1, n)) / 1.2,
            "box": lambda: np.sqrt(3) * rng.uniform(-1, 1, n),
        }[self.shape]()
        value = phi[rows, 1] + phi[rows, 2] * noise
        x = x.copy()
        x[rows] = span.reflect(value) if span.bounded else value
        return x
