"""What a feature is decides where it lies and in which unit an answer gives it."""

import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.effects.contract import OF_FEATURE
from avobench.effects.model import Model
from avobench.effects.ranges import Range, ranges
from avobench.tasks.function import task


def compass(theta, rng):
    return np.column_stack([rng.uniform(0, 360, len(theta)), rng.normal(theta[:, 0], 3)])


COMPASS = task(
    compass,
    prior={"energy": (20, 30)},
    features=["azimuth", "energy"],
    kinds={"azimuth": "angle"},
    feature_units={"azimuth": "deg", "energy": "GeV"},
)


def entry(name, feature):
    return next(effect for effect in catalogue(COMPASS) if effect.key == (name, feature))


def test_the_range_of_an_angle_is_once_round_and_keeps_to_it():
    assert ranges(COMPASS)[0] == Range(0.0, 360.0, False, periodic=True)
    assert ranges(COMPASS)[0].shown(np.linspace(100, 200, 50)) == ranges(COMPASS)[0]
    either_side = task(lambda theta, rng: rng.uniform(-3, 3, len(theta)), prior={"a": (0, 1)}, kinds={"x1": "angle"})
    assert ranges(either_side)[0].low == pytest.approx(-np.pi)


def test_what_moves_an_angle_past_its_end_comes_in_at_the_other():
    shift = entry("offset", 0)
    phi = np.full((1000, 1), shift.parameters[0].high)
    x = compass(np.full((1000, 1), 25.0), np.random.default_rng(0))
    y = shift.apply(lambda theta, rng: x.copy(), phi, phi, np.random.default_rng(0))
    assert ((y[:, 0] >= 0) & (y[:, 0] < 360)).all()
    away = (y[:, 0] - x[:, 0]) % 360
    assert away == pytest.approx(np.full(1000, away[0]))
    assert (y[:, 0] < x[:, 0]).any()
    energy = entry("offset", 1)
    y = energy.apply(lambda theta, rng: x.copy(), phi, phi, np.random.default_rng(0))
    assert (y[:, 1] - x[:, 1]) == pytest.approx(phi[:, 0])


def test_a_value_of_a_feature_has_its_unit_and_one_of_all_features_has_none():
    peak, of_all = entry("peak_background", 1), entry("peak_background", "all")
    assert [p.unit for p in peak.parameters].count(OF_FEATURE) == 2
    assert Model(COMPASS, (peak,)).units == ("1", "1", "GeV", "GeV")
    assert "of half the range of each" in Model(COMPASS, (of_all,)).units
    assert Model(COMPASS, (entry("peak_background", 0),)).units == ("1", "1", "deg", "deg")
