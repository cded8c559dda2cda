"""Figures, tables and pages from records. Nothing here infers or simulates."""
