"""A flat background: some events are spread over the whole range."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Background
from avobench.effects.contract import Parameter

SHAPES = {"uniform": (), "domed": (), "sloped": (Parameter("slope", -1, 1, None, "1"),)}
SHAPES_BOUNDED = {"angle": ()}
SHAPES_UNBOUNDED = {"wider": (Parameter("width", 0.5, 4, None, "1"),)}
"""Beside those above: of a feature that ends sharply at both ends, and of another."""


@dataclass(frozen=True)
class FlatBackground(Background):
    """A share of the events is uniform over the range, or over the angle, or falls along it or towards both ends."""

    shape: str = "uniform"
    name = "flat_background"
    position = 6
    sentence = "Some events are background that spreads evenly over the range."
    source = "G. Cowan, Statistical Data Analysis (1998), Section 6.9"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.95, 0, "1")

    def variants(self):
        return SHAPES | (SHAPES_BOUNDED if self.bounded else SHAPES_UNBOUNDED)

    def drawn(self, span, phi, rng):
        u = rng.random(len(phi))
        if self.shape == "angle":
            return span.cosine(np.pi * u)
        v = 2 * rng.beta(1.5, 1.5, len(phi)) - 1 if self.shape == "domed" else 2 * u - 1
        if self.shape == "sloped":  # density (1 + slope v) / 2, by reflection
            v = np.where(rng.random(len(phi)) < (1 + phi[:, 1] * v) / 2, v, -v)
        return span.centre + span.half * v * (phi[:, 1] if self.shape == "wider" else 1)
