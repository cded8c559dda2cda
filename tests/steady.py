"""What is the same each time that something is made: all but what a clock or a meter says."""

from typing import Any

CLOCKS = ("started", "peak_memory_mib", "seconds")


def without_clocks(value: Any) -> Any:
    """A record, a document, or several in one another, without times and memory."""
    if isinstance(value, dict):
        return {name: without_clocks(inner) for name, inner in value.items() if not str(name).endswith(CLOCKS)}
    return [without_clocks(inner) for inner in value] if isinstance(value, list) else value
