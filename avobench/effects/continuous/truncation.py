"""Truncation: values beyond a limit are lost."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.ends import SIDES, sharp_end
from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

BEYOND = 0.01
"""Of half the range: how far the end, where the effect is absent, lies beyond a limit that the data show, at least."""
INSIDE = 0.05
"""The same of how far within such a limit a fit may look for it."""


@dataclass(frozen=True)
class Truncation(Acceptance):
    """Every event beyond a limit is lost: below it, or above. A fit is tried where the data end sharply.

    The strength is the limit, which at the end of the range is none. Where only a share is lost, both ends lose alike,
    or the loss is gradual, it is another shape of an edge acceptance. Of an exponential a limit below is an `offset`,
    exactly: what is left begins later, and is as steep.
    """

    shape: str = "truncated_below"
    limits: tuple[float | None, float | None] = (None, None)
    """Those that the data show below and above."""
    on_all = False
    name = "edge_acceptance"
    position = 21
    sentence = "Values beyond a limit are not in the sample, as below a threshold."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    @property
    def limit(self) -> float | None:
        """That of this shape, if the data show it."""
        return self.limits[self.shape == "truncated_above"]

    def strength(self) -> Parameter:
        sign, end = (1, self.low) if self.shape == "truncated_below" else (-1, self.high)
        far = (self.low + self.high) / 2
        if self.limit is not None:
            end = sign * min(sign * end, sign * self.limit - BEYOND * self.half)
            far = self.limit + sign * INSIDE * self.half
        return Parameter("limit", min(end, far), max(end, far), end, "of the feature")

    def variants(self):
        return {f"truncated_{side}": () for side in SIDES}

    def adapted(self, x):
        """With the limits that the data show; the range stays, since they do not tell what lies beyond."""
        return replace(self, limits=tuple(sharp_end(x[:, self.feature], side) for side in SIDES))

    def guess(self, x):
        """Nothing where the data thin out."""
        limit = (self if self.limits != (None, None) else self.adapted(x)).limit
        return np.empty((0, 1)) if limit is None else np.array([[limit]])

    def kept(self, x, span, phi):
        limit = phi[:, 0]
        within = x >= limit if self.shape == "truncated_below" else x <= limit
        return (within | (limit == self.strength().null)).astype(float)
