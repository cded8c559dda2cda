"""An offset: every value is recorded shifted."""

from dataclasses import dataclass

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

FARTHEST = 0.7
"""Of half the range, or in rad of an angle: beyond, most values would lie where the simulator makes none."""


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted."""

    shape: str = "plain"
    name = "offset"
    position = 2
    sentence = "The zero of the scale is wrong."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 5"

    def strength(self) -> Parameter:
        high = FARTHEST if self.shape == "angle" else FARTHEST * self.half
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]
