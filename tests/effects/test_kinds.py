"""What a feature is decides where it lies and in which unit an answer gives a parameter."""

import numpy as np
import pytest
from measurements import applied, entry, shape_of

from avobench.effects.contract import OF_FEATURE, Effect
from avobench.effects.images.cells import DeadCells, NoisyCells
from avobench.effects.model import Model
from avobench.effects.ranges import Range, ranges
from avobench.tasks.carl import Carl
from avobench.tasks.function import task


def compass(theta, rng):
    return np.column_stack([rng.uniform(0, 360, len(theta)), rng.normal(theta[:, 0], 3)])


UNITS = {"azimuth": "deg", "energy": "GeV"}
COMPASS = task(
    compass, prior={"energy": (20, 30)}, features=list(UNITS), kinds={"azimuth": "angle"}, feature_units=UNITS
)


def test_the_range_of_an_angle_is_once_round_and_keeps_to_it():
    assert ranges(COMPASS)[0] == Range(0.0, 360.0, False, periodic=True)
    assert ranges(COMPASS)[0].shown(np.linspace(100, 200, 50)) == ranges(COMPASS)[0]
    either_side = task(lambda theta, rng: rng.uniform(-3, 3, len(theta)), prior={"a": (0, 1)}, kinds={"x1": "angle"})
    assert ranges(either_side)[0].low == pytest.approx(-np.pi)


def test_what_moves_an_angle_past_its_end_comes_in_at_the_other():
    shift = entry(COMPASS, "offset", 0)
    by = shift.parameters[0].high
    x = compass(np.full((1000, 1), 25.0), np.random.default_rng(0))
    y = applied(shift, x, [by])
    assert ((y[:, 0] >= 0) & (y[:, 0] < 360)).all()
    away = (y[:, 0] - x[:, 0]) % 360
    assert away == pytest.approx(np.full(1000, away[0]))
    assert (y[:, 0] < x[:, 0]).any()
    y = applied(entry(COMPASS, "offset", 1), x, [by])
    assert (y[:, 1] - x[:, 1]) == pytest.approx(by)


def test_a_value_of_a_feature_has_its_unit_and_one_of_all_features_has_none():
    of_azimuth, peak, of_all = (entry(COMPASS, "peak_background", feature) for feature in (0, 1, "all"))
    assert [p.unit for p in peak.parameters].count(OF_FEATURE) == 2
    assert Model(COMPASS, (peak,)).units == ("1", "1", "GeV", "GeV")
    assert "of half the range of each" in Model(COMPASS, (of_all,)).units
    assert Model(COMPASS, (of_azimuth,)).units == ("1", "1", "deg", "deg")


def unit(effect: Effect, shape: str, name: str, units: tuple[str, ...]) -> str:
    chosen = shape_of(effect, shape)
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
    effect = entry(Carl(), name, feature)
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
