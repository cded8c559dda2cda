"""Calibration: a value is recorded shifted, stretched, mixed with others, or with the wrong sign."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

LEO = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), "
CALIBRATED = 0.03
"""A scale is known to some per cent as a rule; where the far ends of a range seem squeezed by more, they may be cut."""


@dataclass(frozen=True)
class Offset(Change):
    """Every value is shifted."""

    shape: str = "plain"
    name = "offset"
    sentence = "The zero of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        high = 0.7 if self.shape == "angle" else 0.7 * self.half
        return Parameter("shift", -high, high, 0, "rad" if self.shape == "angle" else "of the feature")

    def variants(self):
        return {"plain": ()} | ({"angle": (), "reflected": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(span.angle(x) + phi[:, 0])
        return span.reflect(x + phi[:, 0]) if self.shape == "reflected" else x + phi[:, 0]


@dataclass(frozen=True)
class Scale(Change):
    """Every value is stretched: about zero, about the centre of the angle, or more the larger it is."""

    shape: str = "linear"
    name = "scale"
    sentence = "The unit of the scale is wrong."
    source = LEO + "Chapter 5"

    def strength(self) -> Parameter:
        return Parameter("stretch", -0.5, 0.5, 0, "1", usual=CALIBRATED)

    def variants(self):
        return {"linear": (), "cubic": ()} | ({"angle": ()} if self.bounded else {})

    def changed(self, x, span, phi, rng):
        if self.shape == "angle":
            return span.cosine(np.pi / 2 + (1 + phi[:, 0]) * (span.angle(x) - np.pi / 2))
        growth = span.relative(x) ** 2 if self.shape == "cubic" else 1
        return x * (1 + phi[:, 0] * growth)


@dataclass(frozen=True)
class Crosstalk(Change):
    """A part of another feature is added: of the next one, of a given one, or of the mean of all others.

    Or of what a given one exceeds a level by.
    """

    shape: str = "mean"
    name = "crosstalk"
    sentence = "A part of the signal of other channels leaks into this one."
    source = LEO + "Chapter 13"

    def strength(self) -> Parameter:
        return Parameter("coupling", -0.5, 0.5, 0, "1")

    def variants(self):
        if self.feature == "all":
            return {"mean": (), "next": (), "neighbours": ()}
        others = [j for j in range(len(self.ranges)) if j != self.feature]
        above = {f"x{j + 1} above": (self._level(j),) for j in others}
        return {"mean": ()} | {f"x{j + 1}": () for j in others} | above

    def _level(self, j: int) -> Parameter:
        return Parameter("level", self.ranges[j].low, self.ranges[j].high, None, f"of x{j + 1}")

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        d = x.shape[1]
        if self.shape == "mean":
            other = (x.sum(axis=1, keepdims=True) - x) / (d - 1)
        elif self.shape == "next":
            other = np.roll(x, -1, axis=1)
        elif self.shape == "neighbours":
            other = np.roll(x, -1, axis=1) + np.roll(x, 1, axis=1)
        else:
            other = np.repeat(x[:, [int(self.shape.split()[0][1:]) - 1]], d, axis=1)
            if self.shape.endswith("above"):
                other = np.maximum(other - phi[:, [1]], 0)
        columns = list(self.columns)
        x[:, columns] += phi[:, [0]] * other[:, columns]
        return x


@dataclass(frozen=True)
class ChargeMisid(Change):
    """The sign is taken wrongly with a fixed chance, or with one that grows with the magnitude."""

    shape: str = "constant"
    name = "charge_misid"
    sentence = "The charge, hence the sign, of some events is taken wrongly."
    source = "ALEPH, DELPHI, L3, OPAL, SLD, Phys. Rep. 427 (2006) 257, Section 5"

    def strength(self) -> Parameter:
        return Parameter("fraction", 0, 0.5, 0, "1")

    def variants(self):
        return {"constant": (), "growing": (Parameter("power", 0.5, 10, None, "1"),)}

    def changed(self, x, span, phi, rng):
        chance = phi[:, 0]
        if self.shape == "growing":
            chance = chance * np.minimum(np.abs(span.relative(x)), 1) ** phi[:, 1]
        return np.where(rng.random(len(x)) < chance, -x, x)
