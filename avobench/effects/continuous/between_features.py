"""Effects of one feature on another: crosstalk, a response that depends on it, or an error in common."""

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from avobench.effects.continuous.feature import Change, FeatureEffect
from avobench.effects.contract import Effect, Parameter

SOURCES = {
    "mean": lambda x: (x.sum(axis=1, keepdims=True) - x) / (x.shape[1] - 1),
    "next": lambda x: np.roll(x, -1, axis=1),
    "neighbours": lambda x: np.roll(x, -1, axis=1) + np.roll(x, 1, axis=1),
}
"""What leaks into each feature, of events (n, d) -> (n, d), by shape. Other shapes name the feature that leaks."""


@dataclass(frozen=True)
class Crosstalk(Change):
    """A part of another feature is added: of the next one, of the mean of all, of a given one, or of its excess."""

    shape: str = "mean"
    between = True
    name = "crosstalk"
    position = 11
    sentence = "A part of the signal of other channels leaks into this one."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 13"

    @classmethod
    def entries(cls, site):
        return super().entries(site) if len(site.features) > 1 else []

    STRENGTH = Parameter("coupling", -0.5, 0.5, 0, "1")

    def variants(self):
        if self.feature == "all":
            return {shape: () for shape in SOURCES}
        others = [j for j in range(len(self.ranges)) if j != self.feature]
        ends = {j: (self.ranges[j].low, self.ranges[j].high) for j in others}
        above = {f"x{j + 1} above": (Parameter("level", *ends[j], None, f"of x{j + 1}"),) for j in others}
        return {"mean": (), "neighbours": ()} | {f"x{j + 1}": () for j in others} | above

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


FLOOR = 0.1
"""Share of the range of the acting feature that is added to it in `walk`: signals begin at a threshold, not at zero."""


def _walk(u):
    at = np.maximum((1 + u) / 2, 0) + FLOOR
    least, most = (1 + FLOOR) ** -0.5, FLOOR**-0.5
    return (at**-0.5 - least) / (most - least)


SHIFTS = {"tanh": lambda u: np.tanh(3 * u), "walk": _walk, "quadratic": np.square}
"""The shift (n,), in units of the strength, where the acting feature is u (n,), in half ranges from its centre.

One that is linear is `crosstalk`. A walk is that of a leading edge: the smaller the signal, the later, by its inverse
root."""
SMEARED = "smeared"
"""The shape in which a feature is smeared, the more the larger what acts is."""
GAIN = "gain"
"""The shape in which a feature is stretched about its centre, the more the larger what acts is."""
BALANCED = "balanced"
"""The shape of a gain without stretch where the acting feature is at its centre, and with a shrinking below."""
STRETCH = 0.5
"""The largest stretch of a gain, as that of a wrong scale."""


@dataclass(frozen=True)
class ConditionalResponse(FeatureEffect):
    """A feature is shifted, smeared or stretched by an amount that depends on another one.

    An entry for each feature acted on; which other one acts is a matter of shape.
    """

    on_all = False
    between = True
    name = "conditional_response"
    position = 26
    sentence = "The response in one feature depends on another, as a time on the height of its signal."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Chapter 17"

    @classmethod
    def entries(cls, site) -> list[Effect]:
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
        span, size = self.ranges[self.feature], np.abs(1 + u) / 2
        if form == SMEARED:
            moved = size * rng.standard_normal(len(x))
        elif form in (GAIN, BALANCED):
            gain = np.minimum(size, 1) if form == GAIN else np.clip(u, -1, 1)
            moved = (x[:, self.feature] - span.centre) * gain
        else:
            moved = SHIFTS[form](u)
        x[:, self.feature] = span.wrapped(x[:, self.feature] + phi[:, 0] * moved)
        return x


MOST_PAIRS = 45
"""The pairs of ten features. With more features only neighbours are a shape, since they may share a board."""


@dataclass(frozen=True)
class Correlation(FeatureEffect):
    """All features, or two of them, share an error; a negative one moves the second of a pair to the other side.

    In the shape `tilt` the error of each is in proportion to its distance from a pivot, in the order of the features,
    as of sensors on one table. Where features are smeared each by itself it is `resolution`.
    """

    between = True
    name = "correlation"
    position = 27
    sentence = "Features share an error, as from a common reference or clock."
    source = "R. J. Barlow, Statistics (1989), Section 4.4"

    @classmethod
    def entries(cls, site) -> list[Effect]:
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
