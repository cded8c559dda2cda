"""A conditional response: what one feature is measured as depends on another."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import FeatureEffect
from avobench.effects.contract import Effect, Parameter

FLOOR = 0.1
"""Of the range of what acts, added to it in `walk`: signals begin at a threshold, not at nothing."""


def _walk(u):
    at = np.maximum((1 + u) / 2, 0) + FLOOR
    least, most = (1 + FLOOR) ** -0.5, FLOOR**-0.5
    return (at**-0.5 - least) / (most - least)


SHIFTS = {"tanh": lambda u: np.tanh(3 * u), "walk": _walk, "quadratic": np.square}
"""By shape: the shift (n,), in units of the strength, where what acts is u (n,), in half ranges from its centre.

One that is linear is `crosstalk`. A walk is that of a leading edge: the smaller the signal, the later, by its inverse
root."""
SMEARED = "smeared"
"""The shape in which a feature is smeared, the more the larger what acts is."""
GAIN = "gain"
"""The shape in which a feature is stretched about its centre, the more the larger what acts is."""
BALANCED = "balanced"
"""The same with no stretch where what acts is at its centre, and a shrinking below."""
STRETCH = 0.5
"""Of a gain, at most, as of a wrong scale."""


@dataclass(frozen=True)
class ConditionalResponse(FeatureEffect):
    """A feature is shifted, smeared or stretched by an amount that depends on another one.

    An entry for each feature acted on; which other one acts is a matter of shape. Each has a strength and nothing else,
    so that a look at all of them costs no more than one at a place and a width.
    """

    on_all = False
    name = "conditional_response"
    position = 26
    sentence = "The response in one feature depends on another, as a time on the height of its signal."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 17"

    @classmethod
    def entries(cls, site) -> list[Effect]:
        """One a feature where there are several, in its first shape."""
        return [entry.shapes()[0] for entry in super().entries(site) if entry.variants()]

    def strength(self) -> Parameter:
        if self.shape.endswith(SMEARED):
            return Parameter("sigma", 0, self.half, 0, "of the feature")
        if self.shape.endswith((GAIN, BALANCED)):
            return Parameter("stretch", -STRETCH, STRETCH, 0, "1")
        return Parameter("shift", -self.half, self.half, 0, "of the feature")

    def variants(self):
        others = [j for j in range(len(self.ranges)) if j != self.feature]
        return {f"x{j + 1} {form}": () for form in (*SHIFTS, SMEARED, GAIN, BALANCED) for j in others}

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        other, _, form = self.shape.partition(" ")
        j = int(other[1:]) - 1
        u = self.ranges[j].unit(x[:, j])
        own, size = self.ranges[self.feature], np.abs(1 + u) / 2
        if form == SMEARED:
            moved = size * rng.standard_normal(len(x))
        elif form in (GAIN, BALANCED):
            gain = np.minimum(size, 1) if form == GAIN else np.clip(u, -1, 1)
            moved = (x[:, self.feature] - own.centre) * gain
        else:
            moved = SHIFTS[form](u)
        x[:, self.feature] = own.wrapped(x[:, self.feature] + phi[:, 0] * moved)
        return x
