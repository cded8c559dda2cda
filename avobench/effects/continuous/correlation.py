"""A correlation: features are measured with an error in common."""

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from avobench.effects.continuous.feature import FeatureEffect
from avobench.effects.contract import Effect, Parameter

MOST_PAIRS = 45
"""Of up to ten features every pair is a shape; of more only neighbours are, for they may share a board or a module."""


@dataclass(frozen=True)
class Correlation(FeatureEffect):
    """All features, or two of them, share an error; a negative one moves the second of a pair to the other side.

    In the shape `tilt` the error of each is in proportion to its distance from a pivot, in the order of the features,
    as of sensors on one table.

    One entry, on all features; which of them share the error is a matter of shape. Where both are smeared alike but
    each by itself it is `resolution`.
    """

    name = "correlation"
    position = 27
    sentence = "Features share an error, as from a common reference or clock."
    source = "R. J. Barlow, Statistics (1989), Section 4.4"

    @classmethod
    def entries(cls, site) -> list[Effect]:
        """One where there are several features."""
        return [entry.shapes()[0] for entry in super().entries(site) if entry.feature == "all"]

    def strength(self) -> Parameter:
        return Parameter("sigma", 0 if self.shape in ("every", "tilt") else -0.5, 0.5, 0, "of half the range")

    def variants(self):
        features = range(len(self.ranges))
        pairs = list(combinations(features, 2))
        pairs = pairs if len(pairs) <= MOST_PAIRS else list(pairwise(features))
        pivot = Parameter("pivot", -1, 1, None, "of half the row of features")
        common = {"every": (), "tilt": (pivot,)} if len(pairs) > 1 else {}
        return common | {f"x{i + 1} x{j + 1}": () for i, j in pairs}

    def apply(self, simulate, theta, phi, rng):
        x, sigma = simulate(theta, rng), phi[:, 0]
        noise = rng.standard_normal(len(x))
        if self.shape in ("every", "tilt"):
            for j, at in zip(self.columns, np.linspace(-1, 1, len(self.columns)), strict=True):
                lever = at - phi[:, 1] if self.shape == "tilt" else 1
                x[:, j] += self.ranges[j].half * sigma * lever * noise
            return self.wrapped(x)
        first, second = (int(feature[1:]) - 1 for feature in self.shape.split())
        x[:, first] += self.ranges[first].half * abs(sigma) * noise
        x[:, second] += self.ranges[second].half * sigma * noise
        return self.wrapped(x)
