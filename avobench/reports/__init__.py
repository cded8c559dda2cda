"""Figures, tables and pages from records. Nothing here infers; weinberg's figure draws the observed events again."""
