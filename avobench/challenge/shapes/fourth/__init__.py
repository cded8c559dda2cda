"""The fourth series of hidden effects."""

from avobench.challenge.shapes.fourth import continuous, counts, images

FAMILIES = {"counts": counts.FAMILIES, "continuous": continuous.FAMILIES, "images": images.FAMILIES}
