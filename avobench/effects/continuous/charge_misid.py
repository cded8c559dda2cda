"""A wrong charge: the sign of some values is taken wrongly."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

SHAPES = {"constant": (), "growing": (Parameter("power", 0.5, 10, None, "1"),), "of_positive": (), "of_negative": ()}


@dataclass(frozen=True)
class ChargeMisid(Change):
    """The sign is taken wrongly with a fixed chance, or with one that grows with the magnitude.

    In the shapes `of_positive` and `of_negative` only that of values with this sign.
    """

    shape: str = "constant"
    name = "charge_misid"
    position = 9
    sentence = "The charge, hence the sign, of some events is taken wrongly."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 1 if self.shape.startswith("of_") else 0.5, 0, "1")

    def variants(self):
        return SHAPES

    def changed(self, x, span, phi, rng):
        chance = phi[:, 0]
        if self.shape == "growing":
            chance = chance * np.minimum(np.abs(span.relative(x)), 1) ** phi[:, 1]
        wrong = rng.random(len(x)) < chance
        if self.shape.startswith("of_"):
            wrong &= (x > 0) if self.shape == "of_positive" else (x < 0)
        return np.where(wrong, -x, x)
