"""What is quoted of a fitted model, and what the data could not have shown."""
