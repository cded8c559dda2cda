"""A dead region: events within a part of a range are lost."""

from dataclasses import dataclass

import numpy as np

from avobench.effects.continuous.feature import Acceptance
from avobench.effects.contract import Parameter

INSIDE = 0.05
"""Of half the range, at least as much is recorded on either side: a region at an end is an `edge_acceptance`."""
LOST = {"box": lambda distance: distance < 0.5, "dip": lambda distance: np.exp(-6 * distance**2)}
"""By shape: the share that is lost at a distance (n,) from the middle, in widths."""


@dataclass(frozen=True)
class DeadRegion(Acceptance):
    """Events in one region are lost: all of it alike, or most at its middle. It has events on both sides."""

    shape: str = "box"
    name = "dead_region"
    position = 8
    sentence = "A part of the detector does not record."
    source = "W. R. Leo, Techniques for Nuclear and Particle Physics Experiments, 2nd ed. (1994), Section 5.6"

    def strength(self) -> Parameter:
        return Parameter("lost", 0, 1, 0, "1")

    def variants(self):
        place = self.place(0.02, 0.8)
        return {shape: place for shape in LOST}

    def within(self, low, high, column):
        low, high = self.placed(np.array([low, high]), self.ranges[column])
        return np.array([(low + high) / 2, high - low])

    def kept(self, x, span, phi):
        _, centre, width = phi.T
        if not span.periodic:
            low, high = self.placed(np.array([span.low, span.high]), span)
            free = (low + INSIDE * (high - low) / 2 + width / 2, high - INSIDE * (high - low) / 2 - width / 2)
            centre = np.clip(centre, *free)
        distance = np.abs(self.placed(x, span) - centre) / width
        return 1 - phi[:, 0] * LOST[self.shape](distance)
