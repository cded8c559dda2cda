"""A radiative tail: some events have lost a part of their energy before they are measured."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

INDEX = 3
"""Of the power that the tail falls by: its mean is finite, its variance is not."""
LOSSES = {
    "exponential": lambda n, rng: rng.standard_exponential(n),
    "power": lambda n, rng: (INDEX - 2) * rng.pareto(INDEX - 1, n),
}
"""By shape: losses (n,) in units of their mean."""


RADIATOR = "radiator"
"""The shape in which every value loses, as an electron does in matter: mostly next to nothing, and at times nearly all.
"""


@dataclass(frozen=True)
class RadiativeTail(Change):
    """A share of the values is moved to one side, by an exponential or a power: by the range as a rule, at most.

    Or all lose a share z of their magnitude, with the density b z^(b - 1), where b is the thickness of a radiator in
    units of 3/4 radiation length. `outliers` to one side are those that are moved by more.
    """

    shape: str = "exponential_below"
    stage = 1
    on_all = False
    of_positive = True
    name = "radiative_tail"
    position = 24
    sentence = "Some events have lost a part of their energy, as by radiation before the measurement."
    source = "Y.-S. Tsai, Rev. Mod. Phys. 46 (1974) 815"

    def strength(self) -> Parameter:
        if self.shape == RADIATOR:
            return Parameter("thickness", 0, 1, 0, "of 3/4 radiation length")
        return Parameter("fraction", 0, 0.95, 0, "1")

    def variants(self):
        tail = Parameter("tail", 0.01 * self.half, self.half, None, "of the feature")
        return {f"{law}_{side}": (tail,) for side in ("below", "above") for law in LOSSES} | {RADIATOR: ()}

    def changed(self, x, span, phi, rng):
        if self.shape == RADIATOR:
            thickness = np.maximum(phi[:, 0], np.finfo(float).tiny)  # of one of nothing the power is zero
            return x * (1 - rng.random(len(x)) ** (1 / thickness))
        law, _, side = self.shape.partition("_")
        lost = phi[:, 1] * LOSSES[law](len(x), rng) * (rng.random(len(x)) < phi[:, 0])
        return x - lost if side == "below" else x + lost
