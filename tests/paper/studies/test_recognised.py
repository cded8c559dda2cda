"""How often networks are right, where they were not trained."""

from types import SimpleNamespace

import numpy as np
import pytest

from paper.studies.experience import Examples
from paper.studies.recognised import told

FIXED = SimpleNamespace(probabilities=lambda marks: dict(zip("abc", marks / marks.sum(), strict=True)))
"""Networks that take a portrait for the probabilities."""


def asked(*rows):
    """Examples of (first family, second family, portrait)."""
    first, second, portraits = zip(*rows, strict=True)
    pairs = np.stack([first, second], axis=1)
    return Examples(np.array(portraits, np.float32), pairs, pairs, np.array(first))


def test_names_are_right_if_they_are_among_those_that_were_written_down():
    rows = [("a", "a", (8, 1, 1)), ("a|b", "a|b", (1, 2, 7)), ("outside", "outside", (1, 1, 1)), ("a", "b", (1, 8, 1))]
    said = told(FIXED, ["a", "b", "c"], asked(*rows))
    assert (said["n"], said["first"], said["first three"]) == (2, 0.5, 1)
    assert said["log p"] == pytest.approx(np.log([0.8, 0.3]).mean(), abs=0.01)


def test_what_a_network_does_not_know_takes_no_part():
    assert told(FIXED, ["a", "b"], asked(("a", "a", (2, 1, 7))))["first"] == 1
