"""Effects on features that are real numbers: on one of them, or on all alike."""
