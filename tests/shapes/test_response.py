"""Shapes of how real features are measured: what they do to distributions whose moments are known."""

import numpy as np
import pytest

from avobench.challenge.shape import Injection, Place
from avobench.tasks.carl import Carl
from avobench.tasks.decays import DECAYS
from avobench.tasks.weinberg import Weinberg
from shapes.response import RESPONSE

N = 20_000
SHAPES = {shape.name: shape for shape in RESPONSE.shapes}


COSINE = Place(Weinberg(), 0, 2 * (np.arange(N)[:, None] + 0.5) / N - 1)
NORMAL = np.array([1, 3, 0, -2, 5]) + [1, 2, 3, 1, 0.5] * np.random.default_rng(7).standard_normal((N, 5))
LINE, ALL = Place(Carl(), 1, NORMAL), Place(Carl(), "all", NORMAL)
TIME = Place(DECAYS, 0, np.random.default_rng(7).standard_exponential((N, 1)))


def measured(name, where=LINE, **settings):
    """The reference as it is measured with a shape, (n, k), in standard deviations (a cosine as it is)."""
    drawn = SHAPES[name].draw(where, np.random.default_rng(3))
    assert set(settings) <= set(drawn.settings)
    injection = Injection(drawn.shape, where, {**drawn.settings, **settings})
    x = injection.measure(lambda theta, rng: where.reference, np.zeros((N, 1)), np.random.default_rng(0))
    return x[:, where.columns] / (1 if where.cosine else where.std)


def plain(where=LINE):
    return where.reference[:, where.columns] / (1 if where.cosine else where.std)


BLURS = [
    ("double_gaussian", {"tail_share": 0.2, "tail_width": 3.0}, 0.25 * (1 + 0.2 * 8)),
    ("straggling", {}, 0.25),
    ("ageing_sensor", {"power": 1.0}, 0.25 / 3),
    ("finite_slits", {}, 0.25),
    ("drift_diffusion", {"anode": 1.0}, 0.25 / 2),
]


@pytest.mark.parametrize(("name", "settings", "variance"), BLURS)
def test_errors_have_no_mean_and_their_variance(name, settings, variance):
    error = measured(name, strength=0.5, **settings) - plain()
    assert error.mean() == pytest.approx(0, abs=5 * error.std() / np.sqrt(N))
    assert error.var() == pytest.approx(variance, rel=0.1)


def test_angles_are_turned_and_stretched_as_angles():
    angle, slope = np.arccos(plain(COSINE)), lambda x: x / np.sqrt(1 - x**2)
    turned = measured("drifting_offset", COSINE, strength=0.05, drift=0.0)
    np.testing.assert_allclose(turned, np.cos(angle - 0.05))
    moved = measured("displaced_vertex", COSINE, strength=0.1, bunch=0.0)
    np.testing.assert_allclose(slope(moved), slope(np.cos(angle)) + 0.1)
    damped = (measured("double_gaussian", COSINE, strength=0.3, tail_share=0.0) * np.cos(angle)).mean() * 3
    assert damped == pytest.approx(np.exp(-(0.3**2) / 2), abs=0.02)


def test_offsets_and_gains_act_when_and_where_they_say():
    jump = measured("stale_survey", strength=-0.3, since=0.7) - plain()
    assert np.unique(jump.round(9)).tolist() == [-0.3, 0]
    warm = measured("warm_up", strength=0.3, warming=0.1) - plain()
    assert warm.mean() == pytest.approx(0.3 * (1 - 0.1 * (1 - np.exp(-10))), abs=1e-4)
    np.testing.assert_allclose(measured("bent_gain", strength=0.1, bend=0.0, drift=0.0), 1.1 * plain())
    two, middle = measured("two_slopes", strength=0.2, other=0.0, side=-1.0), LINE.centre / LINE.std
    np.testing.assert_allclose(two - middle, (plain() - middle) * np.where(plain() < middle, 1.2, 1))


def test_signs_are_mistaken_as_often_as_said():
    ratio = measured("lost_sign_bit", COSINE, strength=-0.3) / plain(COSINE)
    assert (ratio[plain(COSINE) < 0] == 1).all()
    assert (ratio[plain(COSINE) > 0] < 0).mean() == pytest.approx(0.3, abs=0.02)
    wrong = measured("stiff_tracks", COSINE, strength=0.4, floor=0.25, power=2.0) * plain(COSINE) < 0
    assert wrong.mean() == pytest.approx(0.4 * (0.25 + 0.75 / 3), abs=0.015)


def test_channels_leak_and_err_together():
    every = NORMAL / NORMAL.std(axis=0)
    leak = measured("two_neighbours", strength=0.2, other_side=0.5)[:, 0] - plain()[:, 0]
    np.testing.assert_allclose(leak, 0.2 * (every[:, 0] + 0.5 * every[:, 2]))
    held = np.cov(measured("held_charge", ALL, strength=0.3).T)
    np.testing.assert_allclose(np.diag(held, 1)[:2], [0.3, 0.3 * (1 + 0.09)], atol=0.04)
    hum = measured("mains_hum", ALL, strength=1.0, lag=0.2) - plain(ALL)
    np.testing.assert_allclose(np.cov(hum.T)[0], np.cos(0.2 * np.arange(5)) / 2, atol=0.02)
    kept = measured("common_mode", ALL, strength=1.0)
    np.testing.assert_allclose(np.cov(kept.T), (1 + np.eye(5)) / 2, atol=0.05)
    smeared = (measured("behind_the_rail", strength=1.0, border=0.0, other=0.0) - plain())[:, 0]
    assert smeared[NORMAL[:, 2] > 0.1].std() == pytest.approx(1, rel=0.05)
    assert np.abs(smeared[NORMAL[:, 2] < -0.1]).max() < 1e-9


def test_scales_have_steps_and_ends():
    step = measured("truncating_readout", strength=0.5, noise=0.0) / 0.5 - 0.5
    np.testing.assert_allclose(step, np.floor(plain() / 0.5), atol=1e-6)
    marks = measured("dial_reading", strength=0.3, step=0.2)
    given = np.abs(marks - plain()) > 1e-9
    assert given.mean() == pytest.approx(0.3, abs=0.02)
    np.testing.assert_allclose(marks[given] / 0.2, np.rint(marks[given] / 0.2))
    assert len(np.unique(measured("segments", COSINE, strength=0.2, uneven=0.3).round(9))) in (15, 16, 17)
    ends = measured("two_converters", strength=0.2, ratio=0.5, side=1.0)
    assert (ends < plain() - 1e-9).mean() == pytest.approx((0.2 + 0.1) / 2, abs=0.01)
    bent = measured("soft_saturation", strength=0.2, room=0.1, side=-1.0) - plain()
    assert (bent > 1e-9).mean() == pytest.approx(0.2, abs=0.01)


def test_radiation_takes_the_mean_share_and_a_parameter_varies_by_the_prior_width():
    soft = measured("bremsstrahlung", TIME, strength=0.2) / plain(TIME)
    assert soft.mean() == pytest.approx(np.exp(-0.2), abs=0.01)
    injection = Injection(SHAPES["unsteady_beam"], Place(Carl(), "beta", NORMAL), {"strength": 0.3, "turn": 1.0})
    theta = injection.measure(lambda theta, rng: theta, np.tile([0.5, -0.5], (N, 1)), np.random.default_rng(0))
    assert (theta[:, 0] == 0.5).all()
    assert theta[:, 1].std() == pytest.approx(0.3 * 4, rel=0.05)
