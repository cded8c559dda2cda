"""What a command prints, taken apart: other processors round in another way, and take longer."""

import re

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def apart(told: str) -> tuple[str, list[float]]:
    """The words and the numbers of a text, without how long anything took."""
    timed = re.sub(r"simulated events, [\d.]+ s\b", "simulated events", told)
    return NUMBER.sub("#", timed), [float(value) for value in NUMBER.findall(timed)]
