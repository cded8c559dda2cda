"""Shapes of counts of the ninth series."""

from avobench.challenge.shapes.ninth import counts_added, counts_lost

FAMILIES = (*counts_lost.FAMILIES, *counts_added.FAMILIES)
"""All of them."""
