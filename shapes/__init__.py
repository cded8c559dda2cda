"""Hidden effects that have been seen: shapes that the catalogue does not have, declared from a few primitives."""
