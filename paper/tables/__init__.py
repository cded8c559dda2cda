"""The tables that the documentation prints from committed records."""
