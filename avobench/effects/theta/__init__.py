"""Effects that act through the parameters of a simulator, whatever its events are: one family a file."""
