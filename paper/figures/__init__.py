"""The figures of the paper and of the studies beyond it."""
