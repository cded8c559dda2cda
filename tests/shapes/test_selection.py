"""Shapes of real features that lose or add events: what they do to distributions whose moments are known."""

import numpy as np
import pytest

from avobench.challenge.shape import Injection, Place
from avobench.tasks.carl import Carl
from avobench.tasks.weinberg import Weinberg
from shapes.selection import SELECTION

N = 20_000
SHAPES = {shape.name: shape for shape in SELECTION.shapes}


EVEN = Place(Weinberg(), 0, 2 * (np.arange(N)[:, None] + 0.5) / N - 1)
"""A cosine that is spread evenly."""
LINE = Place(Carl(), 1, Carl().simulate(np.tile([0.5, -0.5], (N, 1)), np.random.default_rng(99)))


def measured(name, where=EVEN, **settings):
    """What `read` gives of the reference without and with the shape: (n, k), (n, k)."""
    drawn = SHAPES[name].draw(where, np.random.default_rng(3))
    injection = Injection(drawn.shape, where, {**drawn.settings, **settings})

    def simulate(theta, rng):
        return where.reference[np.arange(N) if len(theta) == N else rng.integers(N, size=len(theta))]

    x = injection.measure(simulate, np.zeros((N, 2)), np.random.default_rng(0))
    return where.read(where.reference), where.read(x)


LOST = [
    ("two_halves", {"strength": 0.4, "width": 0.1, "side": 1}, (0.5, 1), 0.3 / 1.6),
    ("rim_loss", {"strength": 1.0, "depth": 0.1}, (0, 1), 0.5),
    ("layers_missed", {"strength": 0.6, "begin": 0.7, "layers": 3.5}, (0.8, 0.9), 0.06 / 1.76),
    ("collimator_jaw", {"strength": 0.6, "half_shadow": 0.5, "remnant": 0.0, "side": 1}, (0.4, 1), 0.15 / 1.55),
    ("worn_spot", {"strength": 1.0, "spot": 0.5, "width": 0.1}, (0, 1), (1 - 0.1 * np.sqrt(2 * np.pi)) / 1.74934),
    ("soft_gap", {"strength": 0.1, "middle": 0.3, "residual": 0.0, "side": 0.01}, (0.21, 0.39), 0.0),
    ("tapered_gap", {"strength": 0.2, "middle": 0.3, "depth": 0.8}, (0.1, 0.5), 0.24 / 1.84),
    ("support_rib", {"strength": 0.1, "middle": 0.0, "half_shadow": 1.0, "remnant": 0.0}, (-0.2, 0.2), 0.1 / 1.7),
    ("barrel_gaps", {"strength": 0.3, "module": 0.5, "residual": 0.1}, (0.35, 0.65), 0.03 / 1.46),
    ("round_beam_stop", {"strength": 1.0, "middle": 0.0, "radius": 0.2}, (-0.2, 0.2), (4 - np.pi) / (20 - np.pi)),
]


@pytest.mark.parametrize(("name", "settings", "between", "share"), LOST, ids=[each[0] for each in LOST])
def test_a_selection_leaves_the_share_that_its_efficiency_says(name, settings, between, share):
    _, x = measured(name, **settings)
    inside = (x > between[0]) & (x < between[1])
    assert inside.mean() == pytest.approx(share, abs=0.01)


def test_features_lose_events_independently_and_a_loss_of_all_is_told():
    where = Place(Carl(), "all", np.random.default_rng(99).uniform(-1, 1, (N, 5)))
    _, x = measured("two_halves", where, strength=0.6, width=1e-3, side=1)
    np.testing.assert_allclose((x > 0).mean(axis=0), 0.4 / 1.4, atol=0.015)
    with pytest.raises(ValueError, match="soft_gap keeps next to no event"):
        measured("soft_gap", strength=100.0, middle=0.0, residual=0.0, side=0.1)


FOREIGN = [
    ("nearly_flat", {"slope": 0.2, "curvature": -0.5}, 0.2 / 3, 1 / 3 - 0.5 * 2 / 15 - (0.2 / 3) ** 2),
    ("combinatorial", {"slope": -0.6}, -0.2, 1 / 3 - 0.04),
    ("room_return", {"slope": 0.7}, 1 / np.tanh(0.7) - 1 / 0.7, 1 / 0.49 - 1 / np.sinh(0.7) ** 2),
    ("accidental_coincidences", {"narrow": 0.3}, 0, (0.49 + 0.09) / 3),
    ("cosmic_rays", {}, 0, 1 / 4),
    ("tailed_line", {"line": 0.1, "width": 0.05, "tail": -0.1, "tailed": 1.0}, 0, 0.05**2 + 0.1**2),
    ("jacobian_peak", {"edge": 0.3, "tail": 0.2}, 0.1 + 0.05 * np.pi, 0.04 * (2 / 3 - np.pi**2 / 16)),
    ("doublet", {"line": 0.1, "apart": 0.3, "first": 0.8, "width": 0.1}, 0.16, 0.09 * (0.16 + 0.01)),
    ("scraper_spot", {"spot": -0.2, "radius": 0.15}, -0.2, 0.15**2 / 4),
    ("beam_halo", {"reach": 0.1, "side": -1}, -0.9, 0.01),
]


@pytest.mark.parametrize(("name", "settings", "mean", "variance"), FOREIGN, ids=[each[0] for each in FOREIGN])
def test_foreign_events_have_their_moments(name, settings, mean, variance):
    _, x = measured(name, strength=1.0, **settings)
    assert x.mean() == pytest.approx(mean, abs=5 * np.sqrt(variance / N))
    assert x.var() == pytest.approx(variance, rel=0.06)


def test_a_resonance_has_its_half_width_and_its_cut():
    _, x = measured("breit_wigner", strength=1.0, line=0.2, width=0.05, cut=5.0)
    assert np.abs(x - 0.2).max() == pytest.approx(0.25, abs=0.001)
    assert (np.abs(x - 0.2) < 0.05).mean() == pytest.approx(np.pi / 4 / np.arctan(5), abs=0.02)


def test_outliers_on_a_line_are_off_by_what_they_should():
    def off(name, **settings):
        plain, x = measured(name, LINE, strength=0.1, **settings)
        hit = ~np.isclose(x, plain, rtol=0, atol=1e-9)
        assert hit.mean() == pytest.approx(0.1, abs=0.015)
        return plain[hit], (x - plain)[hit]

    assert set(np.abs(off("bit_flips", lowest=1.0)[1] / LINE.spread).round(6)) == {1, 2, 4}
    assert set(np.abs(off("flipped_bits")[1]).round(6)) == {1.5, 3, 6}
    plain, more = off("decimal_slip")
    np.testing.assert_allclose(more, 9 * (plain + LINE.centre / LINE.half_range))
    assert (np.abs(off("lightning_strikes", least=3.0)[1]) >= 3 * LINE.spread - 1e-9).all()
    pulses = off("lightning_pickup", least=-2.0)[1] / LINE.spread
    assert (pulses.max(), pulses.mean()) == (pytest.approx(-2, abs=0.01), pytest.approx(-4, abs=0.3))
    spikes = off("spikes", least=1.5, tail=4.0, most=10.0, side=-1)[1]
    assert (spikes.max(), np.median(spikes)) == (pytest.approx(-1.5, abs=0.01), pytest.approx(-1.5 * 2**0.25, rel=0.03))


def test_outliers_of_an_angle_are_off_by_what_they_should():
    plain, x = measured("wrong_vertex", strength=1.0, distance=2.0)
    moved = np.abs(x / np.sqrt(1 - x**2) - plain / np.sqrt(1 - plain**2))
    assert (moved.min(), moved.max()) == (pytest.approx(1.4, abs=0.01), pytest.approx(2.6, abs=0.01))
    where = Place(Weinberg(), 0, np.full((N, 1), 0.8))
    _, x = measured("nuclear_scattering", where, strength=0.5, mean=1.0)
    assert x.mean() == pytest.approx(0.8 * (0.5 + 0.5 / 2), abs=0.02)
    _, x = measured("hard_scattering", where, strength=0.3, width=1.0)
    assert x.mean() == pytest.approx(0.8 * (0.7 + 0.3 / 2), abs=0.02)
