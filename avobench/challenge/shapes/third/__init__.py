"""The third series of hidden effects."""

from avobench.challenge.shapes.third import continuous, counts, images

FAMILIES = {"counts": counts.FAMILIES, "continuous": continuous.FAMILIES, "images": images.FAMILIES}
NEW_FAMILIES = {"counts": counts.NEW_FAMILIES, "continuous": continuous.NEW_FAMILIES, "images": images.NEW_FAMILIES}
