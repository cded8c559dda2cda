"""What effects share whose strength is a limit: how far into the range it lies, from an end beyond which nothing is."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from avobench.effects.continuous.feature import FeatureEffect
from avobench.effects.contract import Parameter

SIDES = ("below", "above")
"""By shape: of which side of its limit the values are concerned."""
BEYOND = 0.01
"""Of half the range: how far the end, where an effect is absent, lies beyond a limit that the data show, at least."""
INSIDE = 0.05
"""The same of how far within such a limit a fit may look for it."""


@dataclass(frozen=True)
class Limited(FeatureEffect):
    """An effect on all values below, or above, a limit in one feature. At the end of the range the limit is none."""

    shape: str = "below"
    limits: tuple[float | None, float | None] = (None, None)
    """Those that the data show below and above."""
    on_all = False

    def variants(self):
        return {side: () for side in SIDES}

    def shown(self, x: NDArray[np.float64], side: str) -> float | None:
        """The limit that values (n,) show on a side, if they show one."""
        raise NotImplementedError

    @property
    def limit(self) -> float | None:
        """That of this shape."""
        return self.limits[SIDES.index(self.shape)]

    def adapted(self, x):
        """With the limits that the data show; the ends stay, since the data do not tell what lies beyond a limit."""
        column = x[:, self.feature]
        return replace(self, limits=tuple(self.shown(column, side) for side in SIDES))

    def known(self, x: NDArray[np.float64]) -> Self:
        """This effect with the limits that the data x (N, d) show, if it has not got them yet."""
        return self if self.limits != (None, None) else self.adapted(x)

    def strength(self) -> Parameter:
        sign = 1 if self.shape == "below" else -1
        end, far = (self.low, (self.low + self.high) / 2) if sign > 0 else (self.high, (self.low + self.high) / 2)
        if self.limit is not None:
            end = sign * min(sign * end, sign * self.limit - BEYOND * self.half)
            far = self.limit + sign * INSIDE * self.half
        return Parameter("limit", min(end, far), max(end, far), end, "of the feature")

    def beyond(self, x: NDArray[np.float64], limit: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which values x (n,) lie beyond their limits (n,): none beyond one that is absent."""
        outside = x < limit if self.shape == "below" else x > limit
        return outside & (limit != self.strength().null)
