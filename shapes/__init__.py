"""Hidden effects that have been seen: shapes that the catalogue does not have, declared from a few primitives."""

from shapes.counts import COUNTS
from shapes.images import IMAGES
from shapes.response import RESPONSE
from shapes.selection import SELECTION

__all__ = ["SEEN"]

SEEN = [*COUNTS.shapes, *SELECTION.shapes, *RESPONSE.shapes, *IMAGES.shapes]
"""All shapes. A new set is kept in a file of its own until it was used once, and then joins one of these."""
