"""The harness: cells, how they are planned, carried out and kept; plugins and their checks; measured events."""
