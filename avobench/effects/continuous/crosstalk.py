"""Crosstalk: a part of other features is added to one."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Change
from avobench.effects.contract import Parameter

SOURCES = {
    "mean": lambda x: (x.sum(axis=1, keepdims=True) - x) / (x.shape[1] - 1),
    "next": lambda x: np.roll(x, -1, axis=1),
    "neighbours": lambda x: np.roll(x, -1, axis=1) + np.roll(x, 1, axis=1),
}
"""By shape: what leaks into each feature, of events (n, d) -> (n, d). Other shapes name the feature that leaks."""


@dataclass(frozen=True)
class Crosstalk(Change):
    """A part of another feature is added: of the next one, of a given one, or of the mean of all others.

    Or of what a given one exceeds a level by.
    """

    shape: str = "mean"
    name = "crosstalk"
    position = 11
    sentence = "A part of the signal of other channels leaks into this one."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 13"

    @classmethod
    def entries(cls, site):
        """None where there is but one feature."""
        return super().entries(site) if len(site.features) > 1 else []

    def strength(self) -> Parameter:
        return Parameter("coupling", -0.5, 0.5, 0, "1")

    def variants(self):
        if self.feature == "all":
            return {shape: () for shape in SOURCES}
        others = [j for j in range(len(self.ranges)) if j != self.feature]
        above = {f"x{j + 1} above": (self._level(j),) for j in others}
        return {"mean": (), "neighbours": ()} | {f"x{j + 1}": () for j in others} | above

    def _level(self, j: int) -> Parameter:
        return Parameter("level", self.ranges[j].low, self.ranges[j].high, None, f"of x{j + 1}")

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        columns = list(self.columns)
        x[:, columns] += phi[:, [0]] * self._leaking(x, phi)[:, columns]
        return self.wrapped(x)

    def _leaking(self, x, phi):
        """What leaks into each feature: (n, d) -> (n, d)."""
        if self.shape in SOURCES:
            return SOURCES[self.shape](x)
        other, _, above = self.shape.partition(" ")
        leaking = np.repeat(x[:, [int(other[1:]) - 1]], x.shape[1], axis=1)
        return np.maximum(leaking - phi[:, [1]], 0) if above else leaking
