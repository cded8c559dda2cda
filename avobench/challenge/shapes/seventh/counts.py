"""The seventh series of shapes of counts."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.seventh import counts_added, counts_lost, counts_read

FAMILIES: tuple[type[Injection], ...] = (*counts_lost.FAMILIES, *counts_added.FAMILIES, *counts_read.FAMILIES)
