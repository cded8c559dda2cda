"""All shapes of what happens to real features."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.eighth import (
    continuous_added,
    continuous_lost,
    continuous_measured,
    continuous_read,
    continuous_several,
)

FAMILIES: tuple[type[Injection], ...] = (
    *continuous_measured.FAMILIES,
    *continuous_lost.FAMILIES,
    *continuous_added.FAMILIES,
    *continuous_read.FAMILIES,
    *continuous_several.FAMILIES,
)
