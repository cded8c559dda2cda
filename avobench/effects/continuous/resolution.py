"""A finite resolution: each value is recorded with a small error."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter
from avobench.effects.noise import skewed_noise

TAIL_WIDTH = 3
"""Of the tail, in widths of the core, in the shape `tails`."""
WIDEST_ANGLE = 1.5
"""Of the smearing of an angle [rad]: beyond a right angle nothing of the value is left."""

SHAPES = {
    "gaussian": (),
    "skewed": (Parameter("skewness", -2, 2, None, "1"),),
    "tails": (Parameter("tail", 0.02, 0.5, None, "1"),),
    "proportional": (),
    "rising": (),
    "falling": (),
}
SHAPES_BOUNDED = {"reflected": (), "angle": ()}
"""The same of a feature that ends sharply at both ends, beside those above."""


@dataclass(frozen=True)
class Resolution(Change):
    """Each value is smeared with standard deviation `sigma`.

    In the shapes `rising` and `falling` that is at one end of the range, and its square falls evenly to the other: as
    of charges that spread while they drift.
    """

    shape: str = "gaussian"
    name = "resolution"
    position = 1
    sentence = "Values are measured with a finite resolution that the simulation lacks."
    source = "Particle Data Group, Review of Particle Physics (2022), Section 35"

    def strength(self) -> Parameter:
        if self.shape == "angle":
            return Parameter("sigma", 0, WIDEST_ANGLE, 0, "rad")
        return Parameter("sigma", 0, self.half, 0, "of the feature")

    def variants(self):
        return SHAPES | (SHAPES_BOUNDED if self.bounded else {})

    def changed(self, x, span, phi, rng):
        error = phi[:, 0] * self._noise(phi, rng)
        if self.shape == "proportional":
            return x + error * np.abs(span.unit(x))
        if self.shape == "angle":
            return span.cosine(span.angle(x) + error)
        if self.shape in ("rising", "falling"):
            far = (1 + (span.unit(x) if self.shape == "rising" else -span.unit(x))) / 2
            moved = x + error * np.sqrt(np.clip(far, 0, 1))
            return span.reflect(moved) if span.bounded else moved
        return span.reflect(x + error) if self.shape == "reflected" else x + error

    def _noise(self, phi, rng):
        """Errors of standard deviation 1: phi (n, q) -> (n,)."""
        if self.shape == "skewed":
            return skewed_noise(phi[:, 1], rng)
        noise = rng.standard_normal(len(phi))
        if self.shape == "tails":  # a share `tail` of the values has a wider error than the core
            wide = rng.random(len(phi)) < phi[:, 1]
            noise = noise * np.where(wide, TAIL_WIDTH, 1) / np.sqrt(1 + (TAIL_WIDTH**2 - 1) * phi[:, 1])
        return noise
