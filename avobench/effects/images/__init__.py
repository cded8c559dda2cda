"""Effects on images: cells that record hits (0 or 1) or energies."""
