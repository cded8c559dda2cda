"""The fifth series of shapes, each drawn from one physical cause and written without sight of the catalogue."""

from avobench.challenge.shapes.fifth import continuous, counts, images

FAMILIES = {"counts": counts.FAMILIES, "continuous": continuous.FAMILIES, "images": images.FAMILIES}
