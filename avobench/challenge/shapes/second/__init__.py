"""The second series of hidden effects: the same families by other mechanisms, so that no shape is known already."""

from avobench.challenge.shapes.second import continuous, counts, images

__all__ = ["continuous", "counts", "images"]
