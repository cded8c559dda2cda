"""An analysis window: events outside it are not in the sample, whatever was done to them before."""

from dataclasses import dataclass, replace

import numpy as np

from avobench.effects.continuous.ends import SIDES, sharp_end
from avobench.effects.continuous.feature import Acceptance
from avobench.effects.continuous.truncation import BEYOND, INSIDE
from avobench.effects.contract import Parameter

CENTRES = 0.25
"""Of half the range: how far from its middle the window of data that do not show it may lie."""


@dataclass(frozen=True)
class AnalysisWindow(Acceptance):
    """Events outside a window in one feature are lost. A fit is tried where the data end sharply, on one side or both.

    It acts after all else: what a smearing moves out of the window is lost too, and what it moves in is kept. By itself
    it cannot be told from a truncation where one end alone cuts anything, nor from the shape `window`.
    """

    shape: str = "analysis_window"
    window: tuple[float, float] | None = None
    """The range that the data show."""
    stage = 5
    on_all = False
    name = "edge_acceptance"
    position = 23
    sentence = "Only events within a window are in the sample, after everything else."
    source = "V. Blobel, in: Data Analysis in High Energy Physics, ed. O. Behnke et al. (2013), Chapter 6"

    def _place(self) -> tuple[float, float, float, float]:
        """Of the window the least centre and the largest, the least width, and that with which it covers everything."""
        middle = (self.low + self.high) / 2
        if self.window is None:
            off = CENTRES * self.half
            return middle - off, middle + off, self.half, 2 * (self.half + off)
        (low, high), off = self.window, INSIDE * self.half
        left, right = (low + high) / 2 - off, (low + high) / 2 + off
        reach = max(right - self.low, self.high - left, (high - low) / 2 + off) + BEYOND * self.half
        return left, right, (high - low) - 2 * off, 2 * reach

    def strength(self) -> Parameter:
        _, _, narrow, wide = self._place()
        return Parameter("width", max(narrow, 0.0), wide, wide, "of the feature")

    def variants(self):
        left, right, *_ = self._place()
        return {self.shape: (Parameter("centre", left, right, None, "of the feature"),)}

    def adapted(self, x):
        """With the range of the data, if an end of it is sharp."""
        column = x[:, self.feature]
        sharp = any(sharp_end(column, side) is not None for side in SIDES)
        return replace(self, window=(float(column.min()), float(column.max())) if sharp else None)

    def guess(self, x):
        """Nothing where the data thin out to both sides."""
        window = (self if self.window else self.adapted(x)).window
        return np.empty((0, 2)) if window is None else np.array([[window[1] - window[0], sum(window) / 2]])

    def kept(self, x, span, phi):
        width = phi[:, 0]
        return ((np.abs(x - phi[:, 1]) <= width / 2) | (width == self.strength().null)).astype(float)
