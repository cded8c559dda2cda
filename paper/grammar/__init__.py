"""A grammar of what may be wrong: primitives times random functions, on random simulators."""
