"""The first series of hidden shapes."""
