"""Effects hidden in data, found again, and scored: how often a diagnosis is right."""
