"""All shapes of what happens to images of hits."""

from avobench.challenge.shapes.contract import Injection
from avobench.challenge.shapes.ninth import images_added, images_lines, images_lost

FAMILIES: tuple[type[Injection], ...] = (*images_lost.FAMILIES, *images_added.FAMILIES, *images_lines.FAMILIES)
