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


ADDED = {  # to the first feature, by where the others are in their ranges, from -1 to 1
    "x2 quadratic": lambda first, u, third: u**2,
    "x2 tanh": lambda first, u, third: np.tanh(3 * u),
    "x2 walk": lambda first, u, third: SHIFTS["walk"](u),
    "x2 gain": lambda first, u, third: 3 * first * (u + 1) / 2,
    "x2 balanced": lambda first, u, third: 3 * first * u,
    "neighbours": lambda first, u, third: 5 * (u + 1) + third,
}


@pytest.mark.parametrize("form", ADDED)
def test_a_feature_is_shifted_by_others_and_by_nothing_else(form):
    plain, x = made((Crosstalk if form == "neighbours" else ConditionalResponse)(0, RANGES, form), -0.3)
    np.testing.assert_array_equal(x[:, 1:], plain[:, 1:])
    np.testing.assert_allclose((x - plain)[:, 0], -0.3 * ADDED[form](*((plain - [1, 5, 0]) / [3, 5, 1]).T))


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


def test_sensors_that_tilt_about_a_pivot_have_one_error_in_proportion_to_its_distance():
    effect = next(s for s in Correlation("all", RANGES).shapes() if s.shape == "tilt")
    phi = np.tile([0.2, 0.5], (N, 1))
    x = effect.apply(lambda theta, rng: np.zeros((N, 3)), phi, phi, np.random.default_rng(0))
    errors = x / np.array([span.half for span in RANGES])
    np.testing.assert_allclose(errors[:, 1:] / errors[:, :1], np.tile([1 / 3, -1 / 3], (N, 1)))
    assert errors[:, 0].std() == pytest.approx(0.2 * 1.5, rel=5 / np.sqrt(2 * N))


@pytest.mark.parametrize(
    ("shape", "sigma", "signs"), [("x1 x3", 0.3, [1, 0, 1]), ("x1 x3", -0.3, [1, 0, -1]), ("every", 0.2, [1, 1, 1])]
)
def test_features_share_an_error_of_the_stated_covariance(shape, sigma, signs):
    plain, x = made(Correlation("all", RANGES, shape), sigma)
    assert np.cov(((x - plain) / [3, 5, 1]).T) == pytest.approx(sigma**2 * np.outer(signs, signs), rel=0.05)


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
