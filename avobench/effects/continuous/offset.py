"""An offset: values are recorded shifted."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

FARTHEST = 0.7
"""Of half the range, or in rad of an angle: beyond, most values would lie where the simulator makes none."""


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted.

    In the shape `part` those of a share of the events, as after a step in time. In `creeping` the shift approaches its
    last value exponentially while the data are taken, as of electronics that warm up.
    """

    shape: str = "plain"
    name = "offset"
    position = 2
    sentence = "The zero of the scale is wrong."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 5"

    def strength(self) -> Parameter:
        high = FARTHEST if self.shape == "angle" else FARTHEST * self.half
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        of_some = {"part": (Parameter("share", 0.01, 1, None, "1"),)}
        of_most = {"creeping": (Parameter("warm_up", 0.01, 1, None, "of the data"),)}
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {}) | of_some | of_most

    def apply(self, simulate, theta, phi, rng):
        if self.shape not in ("part", "creeping"):
            return super().apply(simulate, theta, phi, rng)
        x, time = simulate(theta, rng), rng.random(len(theta))  # one time for all features of an event
        present = time < phi[:, 1] if self.shape == "part" else -np.expm1(-time / phi[:, 1])
        x[:, list(self.columns)] += (phi[:, 0] * present)[:, None]
        return self.wrapped(x)

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]
