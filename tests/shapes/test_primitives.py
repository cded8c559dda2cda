"""Each primitive, by shapes that are declared from it and whose moments are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from avobench.challenge.shape import Place
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from avobench.tasks.weinberg import Weinberg
from shapes import counts, images, response, selection

N, L = 20_000, 6.0
THETA = np.full((2000, 1), 0.4)
EVEN = Place(Weinberg(), 0, 2 * (np.arange(N)[:, None] + 0.5) / N - 1)
"""A cosine that is spread evenly."""
NORMAL = np.array([1, 3, 0, -2, 5]) + [1, 2, 3, 1, 0.5] * np.random.default_rng(7).standard_normal((N, 5))
LINE = Place(Carl(), 1, NORMAL)


def measured(shape, where, simulate, theta, **fixed):
    """Events as they are measured with a shape of which some settings are fixed, the others drawn."""
    settings = shape.draw(where, np.random.default_rng(3)).settings
    assert set(fixed) <= set(settings)
    return shape.measure(simulate, theta, where, SimpleNamespace(**settings | fixed), np.random.default_rng(0))


def again(where):
    """A simulator that makes the events of the reference, or draws of them."""

    def simulate(theta, rng):
        return where.reference[np.arange(N) if len(theta) == N else rng.integers(N, size=len(theta))]

    return simulate


def read(shape, where=EVEN, **settings):
    """What is read of the reference as it is measured with a shape, (n, k)."""
    return where.read(measured(shape, where, again(where), np.zeros((N, 2)), **settings))


MOMENTS = [  # of counts of mean L, by the law of total variance
    (counts.two_intensities, {"strength": 0.3, "share": 0.3}, L, L + (0.3 * L) ** 2),  # rate
    (counts.decaying_source, {"strength": 1.0}, L, L + L**2 * (0.5 / np.tanh(0.5) - 1)),
    (counts.pulsed_beam, {"strength": 0.3, "duty": 0.6}, 1.3 * L, 1.3 * L + (0.3 * L) ** 2 * (1 / 0.6 - 1)),  # add
    (counts.channels_off, {"strength": 0.3, "channels": 20.0}, 0.7 * L, 0.7 * L + 0.21 * L**2 / 20),  # thin
    (counts.cable_reflection, {"strength": 0.1, "echo": 1.0}, 1.1 * L, 1.3 * L + 0.09 * L**2),  # branch
    (counts.missed_reset, {"strength": 0.2, "least": 1.0}, 1.2 * L, 1.2 * L + 0.16 * L**2),  # rate above 1
    (counts.mains_hum, {"strength": 0.5, "hum": 1.0}, L, 1.25 * L + 1 / 12),  # map
]


@pytest.mark.parametrize(("shape", "settings", "mean", "variance"), MOMENTS, ids=lambda each: getattr(each, "name", ""))
def test_counts_have_their_moments(shape, settings, mean, variance):
    task, theta = Poisson(), np.full((N, 1), np.log(L))
    where = Place(task, 0, task.simulate(theta, np.random.default_rng(99)))
    x = measured(shape, where, task.simulate, theta, **settings)
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N) + 0.05)  # the reference's mean errs too
    assert x.var() == pytest.approx(variance, rel=0.07)


def test_a_selection_leaves_the_share_that_its_efficiency_says():
    jaw = {"strength": 0.6, "half_shadow": 0.5, "remnant": 0.0, "side": 1}
    assert (read(selection.collimator_jaw, **jaw) > 0.4).mean() == pytest.approx(0.15 / 1.55, abs=0.01)
    where = Place(Carl(), "all", np.random.default_rng(99).uniform(-1, 1, (N, 5)))
    x = read(selection.two_halves, where, strength=0.6, width=1e-3, side=1)  # of each feature independently
    np.testing.assert_allclose((x > 0).mean(axis=0), 0.4 / 1.4, atol=0.015)
    with pytest.raises(ValueError, match="soft_gap keeps next to no event"):
        read(selection.soft_gap, strength=100.0, middle=0.0, residual=0.0, side=0.1)


@pytest.mark.parametrize(
    ("shape", "settings", "mean", "variance"),
    [
        (selection.combinatorial, {"slope": -0.6}, -0.2, 1 / 3 - 0.04),
        (selection.beam_halo, {"reach": 0.1, "side": -1}, -0.9, 0.01),
    ],
    ids=["combinatorial", "beam_halo"],
)
def test_foreign_events_have_their_moments(shape, settings, mean, variance):
    x = read(shape, strength=1.0, **settings)
    assert x.mean() == pytest.approx(mean, abs=5 * np.sqrt(variance / N))
    assert x.var() == pytest.approx(variance, rel=0.06)


def test_values_of_a_share_of_the_events_are_changed_and_blurred_ones_have_their_variance():
    plain = LINE.read(NORMAL)
    x = read(selection.flipped_bits, LINE, strength=0.1)
    hit = ~np.isclose(x, plain, rtol=0, atol=1e-9)
    assert hit.mean() == pytest.approx(0.1, abs=0.015)
    assert set(np.abs(x - plain)[hit].round(6)) == {1.5, 3, 6}
    error = (read(response.ageing_sensor, LINE, strength=0.5, power=1.0) - plain) / LINE.spread
    assert error.mean() == pytest.approx(0, abs=5 * error.std() / np.sqrt(N))
    assert error.var() == pytest.approx(0.25 / 3, rel=0.1)


def test_a_feature_responds_to_others_and_a_parameter_varies_by_the_prior_width():
    every = (NORMAL - NORMAL.mean(axis=0)) / NORMAL.std(axis=0)
    x = measured(response.two_neighbours, LINE, again(LINE), np.zeros((N, 2)), strength=0.2, other_side=0.5)
    leak = (x[:, 1] - NORMAL[:, 1]) / LINE.std
    leak -= leak.mean()
    np.testing.assert_allclose(leak, 0.2 * (every[:, 0] + 0.5 * every[:, 2]), atol=1e-9)
    where, theta = Place(Carl(), "beta", NORMAL), np.tile([0.5, -0.5], (N, 1))
    theta = measured(response.unsteady_beam, where, lambda theta, rng: theta, theta, strength=0.3, turn=1.0)
    assert (theta[:, 0] == 0.5).all()
    assert theta[:, 1].std() == pytest.approx(0.3 * 4, rel=0.05)


full, empty = (lambda theta, rng, cell=cell: np.full((len(theta), 1024), cell, np.uint8) for cell in (1, 0))


@pytest.mark.parametrize(
    ("shape", "simulate", "settings", "hits"),
    [
        (images.clock_edge, full, {"strength": 0.5}, 0.75 * 1024),  # thin
        (images.dead_patch, full, {"strength": 30.0, "residual": 0.0}, 1024 - 30),  # mask
        (images.light_bursts, empty, {"strength": 3.0}, 3),  # add
    ],
    ids=["clock_edge", "dead_patch", "light_bursts"],
)
def test_as_many_hits_are_lost_or_added_as_asked_for(tracker, shape, simulate, settings, hits):
    x = measured(shape, tracker, simulate, THETA, **settings)
    assert x.sum() / len(THETA) == pytest.approx(hits, rel=0.12)


def test_further_collisions_are_as_many_as_asked_for(tracker):
    def simulate(theta, rng):
        return (empty if len(theta) == len(THETA) else full)(theta, rng)

    double = measured(images.out_of_time, tracker, simulate, THETA, strength=0.3, in_time=0.5)
    assert double.any(axis=1).mean() == pytest.approx(-np.expm1(-0.3), abs=0.04)
    assert np.quantile(double[double.any(axis=1)].mean(axis=1), 0.1) == pytest.approx(0.5, abs=0.05)


def test_the_particles_of_an_event_turn_before_they_are_detected(tracker):
    plain, n = tracker.task.simulate, 200
    x = plain(THETA[:n], np.random.default_rng(0)).reshape(n, 32, 32)
    turned = measured(images.rocking_frame, tracker, plain, THETA[:n], strength=np.pi, azimuth=0.0, rock=0.0)
    assert (turned.reshape(n, 32, 32) == x[:, ::-1, ::-1]).mean() > 0.9999
