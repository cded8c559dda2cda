"""Tasks, methods and effects by name, shipped or a user's own."""
