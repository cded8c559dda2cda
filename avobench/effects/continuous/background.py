"""Backgrounds: some events come from elsewhere."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Background
from avobench.effects.contract import Parameter

COWAN = "G. Cowan, Statistical Data Analysis (1998), Section 6.9"


@dataclass(frozen=True)
class FlatBackground(Background):
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

    def drawn(self, span, phi, rng):
        u = rng.random(len(phi))
        if self.shape == "angle":
            return span.cosine(np.pi * u)
        v = 2 * u - 1
        if self.shape == "sloped":  # density (1 + slope v) / 2, by reflection
            v = np.where(rng.random(len(phi)) < (1 + phi[:, 1] * v) / 2, v, -v)
        return span.centre + span.half * v * (phi[:, 1] if self.shape == "wider" else 1)


@dataclass(frozen=True)
class PeakBackground(Background):
    """A share of the events forms a peak: Gaussian, Lorentzian or a box of the same standard deviation."""

    shape: str = "gaussian"
    name = "peak_background"
    sentence = "Some events are background gathered at one place, as from a resonance or a hot spot."
    source = COWAN

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.9, 0, "1")

    def variants(self):
        place = self.place(0.01, 0.35)
        return {"gaussian": place, "lorentzian": place, "box": place}

    def within(self, low, high, column):
        low, high = self.placed(np.array([low, high]), self.ranges[column])
        return np.array([(low + high) / 2, (high - low) / np.sqrt(12)])

    def drawn(self, span, phi, rng):
        n = len(phi)
        noise = {
            "gaussian": lambda: rng.standard_normal(n),
            "lorentzian": lambda: np.tan(np.pi * 0.45 * rng.uniform(-1, 1, n)) / 1.2,
            "box": lambda: np.sqrt(3) * rng.uniform(-1, 1, n),
        }[self.shape]()
        value = phi[:, 1] + phi[:, 2] * noise
        if self.feature == "all":
            value = span.centre + span.half * value
        return span.reflect(value) if span.bounded else value
