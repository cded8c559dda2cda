"""Outliers: a few values are recorded with a large error."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

CAUCHY_SHARE = 0.3
"""Of the width, the scale of a Cauchy error: about as many errors reach the width as Gaussian ones do."""
WIDTH = Parameter("width", 0.5, 20, None, "of half the range")
ANGLE = Parameter("width", 0.3, 3, None, "rad")

ERRORS = {
    "gaussian": lambda width, rng: width * rng.standard_normal(len(width)),
    "cauchy": lambda width, rng: CAUCHY_SHARE * width * rng.standard_cauchy(len(width)),
    # to one side only, as a loss of energy is
    "above": lambda width, rng: width * rng.standard_exponential(len(width)),
    "below": lambda width, rng: -width * rng.standard_exponential(len(width)),
}
"""By shape: errors (n,) of widths (n,)."""
TOGETHER = "together"
"""Ends the names of shapes in which a whole event is far off."""


@dataclass(frozen=True)
class Outliers(Change):
    """A share of the values has a large error: `width` times half the range, or as an angle.

    On all features alike in the shapes `together` an event is far off in all of them, and else a value by itself.
    """

    shape: str = "gaussian"
    name = "outliers"
    position = 10
    sentence = "A few values are far off, as from a failed reconstruction."
    source = "P. J. Huber, Robust Statistics (1981), Section 1.1"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        shapes = {"gaussian": (WIDTH,), "cauchy": (WIDTH,)}
        shapes |= {"angle": (ANGLE,)} if self.bounded else {"above": (WIDTH,), "below": (WIDTH,)}
        whole = {f"{each} {TOGETHER}": (WIDTH,) for each in shapes if each in ERRORS}
        return shapes | (whole if self.feature == "all" else {})

    def apply(self, simulate, theta, phi, rng):
        if not self.shape.endswith(TOGETHER):
            return super().apply(simulate, theta, phi, rng)
        x = simulate(theta, rng)
        rows, errors = np.flatnonzero(rng.random(len(x)) < phi[:, 0]), ERRORS[self.shape.split()[0]]
        for j in self.columns:
            x[rows, j] += errors(phi[rows, 1] * self.ranges[j].half, rng)
        return self.wrapped(x)

    def changed(self, x, span, phi, rng):
        rows = np.flatnonzero(rng.random(len(x)) < phi[:, 0])
        x, width = x.copy(), phi[rows, 1]
        if self.shape == "angle":
            x[rows] = span.cosine(span.angle(x[rows]) + width * rng.standard_normal(len(rows)))
        else:
            x[rows] += ERRORS[self.shape](width * span.half, rng)
        return x
