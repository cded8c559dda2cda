"""All shapes of what happens to counts."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.eighth import counts_added, counts_lost, counts_read

FAMILIES: tuple[type[Injection], ...] = (*counts_lost.FAMILIES, *counts_added.FAMILIES, *counts_read.FAMILIES)
