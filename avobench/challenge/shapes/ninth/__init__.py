"""The ninth series of shapes, from causes of its own and written without sight of the others and of the search."""

from avobench.challenge.shapes.ninth import continuous, counts, images

FAMILIES = {"counts": counts.FAMILIES, "continuous": continuous.FAMILIES, "images": images.FAMILIES}
"""The shapes by what an event is."""
