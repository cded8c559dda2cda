"""What avobench says of the paper and of itself: studies, claims, tables, figures and speed. Run from a clone."""
