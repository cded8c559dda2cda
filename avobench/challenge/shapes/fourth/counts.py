"""Effects in a number of counts."""

from avobench.challenge.shapes.fourth import counts_arrivals, counts_readout

FAMILIES = (*counts_arrivals.FAMILIES, *counts_readout.FAMILIES)
