"""Shapes of counts."""

from shapes.primitives import Library

COUNTS = Library("counts")
