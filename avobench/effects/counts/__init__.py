"""Effects on events that are one count each."""
