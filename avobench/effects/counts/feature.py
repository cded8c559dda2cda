"""What effects on counts share: which of the counts of an event they act on."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avobench.effects.contract import Effect, Family
from avobench.effects.site import Site


@dataclass(frozen=True)
class CountEffect(Family):
    """An effect on the one count of an event, on one of several, or on all alike.

    On all alike, what happens to an event happens to all its counts, what happens to a count to each by itself.
    """

    shape: str = ""
    feature: int | Literal["all"] | None = None
    columns: tuple[int, ...] = (0,)
    """Where the counts stand in an event."""

    domains = ("counts",)

    @classmethod
    def entries(cls, site: Site) -> list[Effect]:
        """One a count, and one that acts on all of them where there are several."""
        return [cls(feature=feature, columns=site.columns(feature)) for feature in site.counts]

    def cells(self, rows: NDArray) -> tuple[NDArray[np.intp], ...]:
        """What indexes the counts in some rows of events, given as numbers or as a mask: (m, k)."""
        return np.ix_(rows, self.columns)


def whole(x: NDArray) -> NDArray[np.int64]:
    """Counts in a type of whole numbers: those of an event with real numbers beside them come as such."""
    return x.astype(np.int64)
