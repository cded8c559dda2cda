"""Effects on how values are written down, be they counts or real numbers: one family a file."""
