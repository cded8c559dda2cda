"""Fits of a black-box simulator to a summary."""
