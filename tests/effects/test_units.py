"""What an answer says of the unit of an effect's parameter."""

import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.effects.contract import Effect
from avobench.effects.images.cells import DeadCells, NoisyCells
from avobench.tasks.carl import Carl


def unit(effect: Effect, shape: str, name: str, units: tuple[str, ...]) -> str:
    chosen = next(s for s in effect.shapes() if s.shape == shape)
    return chosen.unit(next(p for p in chosen.parameters if p.name == name), units)


@pytest.mark.parametrize(
    ("name", "feature", "shape", "parameter", "known", "unknown"),
    [
        ("offset", 1, "plain", "shift", "GeV", "of the feature"),
        ("offset", "all", "plain", "shift", "in the unit of each feature", "in the unit of each feature"),
        ("peak_background", 1, "gaussian", "fraction", "1", "1"),
        ("peak_background", "all", "gaussian", "width", "of half the range of each", "of half the range of each"),
        ("edge_acceptance", 1, "cut", "edge", "of half the range -2 to 6.5 GeV", "of half the range -2 to 6.5"),
    ],
)
def test_the_feature_s_own_unit_and_the_range_are_told(name, feature, shape, parameter, known, unknown):
    effect = next(e for e in catalogue(Carl()) if e.key == (name, feature))
    spans = tuple(type(span)(-2.0, 6.5, False) for span in effect.ranges)
    effect = type(effect)(feature, spans)
    assert unit(effect, shape, parameter, ("s", "GeV", "s", "s", "s")) == known
    assert unit(effect, shape, parameter, ()) == unknown


def test_the_cell_that_is_at_fault_is_told_where_it_is_one():
    x = np.zeros((20_000, 64), np.uint8)
    x[:] = np.random.default_rng(0).random(x.shape) < 0.1
    one, two = x.copy(), x.copy()
    one[:, 3 * 8 + 5] = 0
    two[:, [3 * 8 + 5, 9]] = 0
    dead = DeadCells((8, 8))
    assert unit(dead.adapted(one), "", "lost", ()) == "of what the cell in row 3, column 5 records"
    assert unit(dead.adapted(two), "", "lost", ()) == unit(dead.adapted(x), "", "lost", ()) == "1"
    one[:, 3 * 8 + 5] = 1
    assert unit(NoisyCells((8, 8)).adapted(one), "", "rate", ()) == "an event, by the cell in row 3, column 5"
