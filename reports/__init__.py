"""Figures, tables and pages from records: one module a figure. Nothing here infers; weinberg draws what was observed."""
