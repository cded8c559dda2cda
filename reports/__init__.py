"""Figures from records: one module a figure. Nothing here simulates or infers."""
