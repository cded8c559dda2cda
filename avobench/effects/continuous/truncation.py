"""Truncation: values beyond a limit are lost."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.ends import sharp_end
from avobench.effects.continuous.feature import Acceptance
from avobench.effects.continuous.limited import Limited


@dataclass(frozen=True)
class Truncation(Limited, Acceptance):
    """Every event beyond a limit is lost: below it, or above. A fit is tried where the data end sharply.

    Where only a share is lost, or both ends lose alike, it is an `edge_acceptance`; where the loss is gradual, a
    `turn_on`. Of an exponential a limit below is an `offset`, exactly: what is left begins later, and is as steep.
    """

    name = "truncation"
    position = 21
    sentence = "Values beyond a limit are not in the sample, as below a threshold."
    source = "A. C. Cohen, Truncated and Censored Samples (1991), Chapter 1"

    def shown(self, x, side):
        return sharp_end(x, side)

    def guess(self, x):
        """Nothing where the data thin out."""
        limit = self.known(x).limit
        return np.empty((0, 1)) if limit is None else np.array([[limit]])

    def kept(self, x, span, phi):
        return (~self.beyond(x, phi[:, 0])).astype(float)
