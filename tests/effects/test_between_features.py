"""Effects by which features depend on one another: what their shapes do, and how many there are."""

import numpy as np
import pytest

from avobench.effects.catalogue import catalogue
from avobench.effects.continuous.between_features import (
    FLOOR,
    MOST_PAIRS,
    SHIFTS,
    ConditionalResponse,
    Correlation,
    Crosstalk,
)
from avobench.effects.ranges import Range
from avobench.tasks.carl import Carl
from avobench.tasks.function import task
from avobench.tasks.weinberg import Weinberg

N = 40_000
RANGES = (Range(-2.0, 4.0, False), Range(0.0, 10.0, False), Range(-1.0, 1.0, False))


def even(theta, rng):
    return np.column_stack([rng.uniform(span.low, span.high, len(theta)) for span in RANGES])


def made(effect, strength, seed=0):
    """Events without and with an effect, which draw the same of the simulator."""
    phi = np.full((N, 1), strength)
    with_it = effect.apply(even, phi, phi, np.random.default_rng(seed))
    return even(phi, np.random.default_rng(seed)), with_it


@pytest.mark.parametrize("form", SHIFTS)
def test_a_feature_is_shifted_by_another_and_by_nothing_else(form):
    effect = ConditionalResponse(0, RANGES, f"x2 {form}")
    plain, x = made(effect, 0.7)
    np.testing.assert_array_equal(x[:, 1:], plain[:, 1:])
    u = (plain[:, 1] - 5) / 5
    expected = {"quadratic": u**2, "tanh": np.tanh(3 * u), "walk": SHIFTS["walk"](u)}[form]
    np.testing.assert_allclose(x[:, 0] - plain[:, 0], 0.7 * expected)


def test_a_walk_is_latest_at_nothing_and_goes_by_the_inverse_root():
    u = np.linspace(-1, 1, 200)
    walk = SHIFTS["walk"](u)
    assert walk[[0, -1]] == pytest.approx([1, 0], abs=1e-12)
    assert (np.diff(walk) < 0).all()
    assert (np.diff(walk, 2) > 0).all()
    assert np.corrcoef(walk, ((1 + u) / 2 + FLOOR) ** -0.5)[0, 1] == pytest.approx(1)
    assert np.isfinite(SHIFTS["walk"](np.array([-9.0, 9.0]))).all()  # beyond the range as well


def test_a_smearing_grows_with_what_acts():
    plain, x = made(ConditionalResponse(2, RANGES, "x2 smeared"), 0.5)
    error, share = x[:, 2] - plain[:, 2], plain[:, 1] / 10
    assert np.std(error / share) == pytest.approx(0.5, rel=0.03)
    assert abs(np.corrcoef(np.abs(error / share), share)[0, 1]) < 5 / np.sqrt(N)


def test_a_gain_follows_what_acts_as_far_as_its_range():
    plain, x = made(ConditionalResponse(0, RANGES, "x2 gain"), -0.3)
    np.testing.assert_allclose((x - plain)[:, 0], -0.3 * (plain[:, 0] - 1) * plain[:, 1] / 10)
    plain, x = made(ConditionalResponse(0, RANGES, "x2 balanced"), -0.3)
    np.testing.assert_allclose((x - plain)[:, 0], -0.3 * (plain[:, 0] - 1) * (plain[:, 1] - 5) / 5)


def test_sensors_that_tilt_about_a_pivot_have_one_error_in_proportion_to_its_distance():
    effect = next(s for s in Correlation("all", RANGES).shapes() if s.shape == "tilt")
    phi = np.tile([0.2, 0.5], (N, 1))
    x = effect.apply(lambda theta, rng: np.zeros((N, 3)), phi, phi, np.random.default_rng(0))
    errors = x / np.array([span.half for span in RANGES])
    np.testing.assert_allclose(errors[:, 1:] / errors[:, :1], np.tile([1 / 3, -1 / 3], (N, 1)))
    assert errors[:, 0].std() == pytest.approx(0.2 * 1.5, rel=5 / np.sqrt(2 * N))


def test_both_neighbours_of_a_feature_leak_into_it():
    plain, x = made(Crosstalk(0, RANGES, "neighbours"), 0.2)
    np.testing.assert_allclose((x - plain)[:, 0], 0.2 * (plain[:, 1] + plain[:, 2]))


@pytest.mark.parametrize("sigma", [0.3, -0.3])
def test_two_features_share_an_error_of_the_stated_covariance(sigma):
    plain, x = made(Correlation("all", RANGES, "x1 x3"), sigma)
    np.testing.assert_array_equal(x[:, 1], plain[:, 1])
    error = (x - plain)[:, [0, 2]] / [3, 1]
    expected = sigma**2 * np.array([[1, np.sign(sigma)], [np.sign(sigma), 1]])
    assert np.cov(error.T) == pytest.approx(expected, rel=0.05)


def test_all_features_may_share_one():
    plain, x = made(Correlation("all", RANGES, "every"), 0.2)
    error = (x - plain) / [3, 5, 1]
    assert np.cov(error.T) == pytest.approx(np.full((3, 3), 0.04), rel=0.05)


def features(d):
    return task(lambda theta, rng: rng.standard_normal((len(theta), d)), prior={"unused": (0, 1)}, name="features")


def test_the_catalogue_stays_small_however_many_features_there_are():
    names = {"conditional_response", "correlation"}
    assert not names & {effect.name for effect in catalogue(Weinberg())}
    assert sorted(e.key for e in catalogue(Carl()) if e.name == "conditional_response") == [
        ("conditional_response", j) for j in range(5)
    ]
    of_two, of_five, of_many = (
        next(e for e in catalogue(each) if e.name == "correlation") for each in (features(2), Carl(), features(20))
    )
    assert [shape.shape for shape in of_two.shapes()] == ["x1 x2"]
    assert len(of_five.shapes()) == 2 + 10
    assert len(of_many.shapes()) == 2 + 19 <= 2 + MOST_PAIRS
    assert {shape.shape for shape in of_many.shapes()} >= {"every", "x1 x2", "x19 x20"}
    shapes = [shape for e in catalogue(Carl()) if e.name in names for shape in e.shapes()]
    assert all(len(shape.parameters) == 1 + (shape.shape == "tilt") for shape in shapes)
