"""Shapes of real features of the ninth series."""

from avobench.challenge.shapes.ninth import continuous_lost, continuous_measured

FAMILIES = (*continuous_lost.FAMILIES, *continuous_measured.FAMILIES)
"""All of them."""
