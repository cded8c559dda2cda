"""Fit simulators that have no likelihood, know how well that works, and find what a simulator lacks."""
