"""Shapes of counts whose moments are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from avobench.challenge.shape import Place
from avobench.tasks.poisson import Poisson
from shapes import counts

N = 20_000
TASK = Poisson()
L = 6.0


def place(mean):
    theta = np.full((N, 1), np.log(mean))
    return Place(TASK, 0, TASK.simulate(theta, np.random.default_rng(99))), theta


MANY = place(L)


def measured(shape, where=MANY, seed=0, **settings):
    """Counts (n,) with all settings of a shape given."""
    assert set(settings) == set(shape.ranges)
    at, theta = where
    return shape.measure(TASK.simulate, theta, at, SimpleNamespace(**settings), np.random.default_rng(seed))[:, 0]


MOMENTS = [
    (counts.two_intensities, {"strength": 0.3, "share": 0.3}, L, L + (0.3 * L) ** 2),
    (counts.lognormal_rate, {"strength": 0.3, "memory": 1.0}, L, L + (0.3 * L) ** 2),
    (counts.mains_ripple, {"strength": 0.3, "overtone": 0.4}, L, L + (0.3 * L) ** 2),
    (counts.decaying_source, {"strength": 1.0}, L, L + L**2 * (0.5 / np.tanh(0.5) - 1)),
    (counts.flares, {"strength": 1.0, "share": 0.2}, L, L + 0.36 * (L / 1.2) ** 2),
    (counts.molecules_in_focus, {"strength": 1.0}, L, 2 * L),
    (counts.pulsed_beam, {"strength": 0.3, "duty": 0.6}, 1.3 * L, 1.3 * L + (0.3 * L) ** 2 * (1 / 0.6 - 1)),
    (counts.missed_reset, {"strength": 0.2, "least": 1.0}, 1.2 * L, 1.2 * L + 0.16 * L**2),
    (counts.close_neighbour, {"strength": 1.0, "fading": 1.0}, 1.5 * L, 1.5 * L + L**2 / 12),
    (counts.compton_continuum, {"strength": 1.0, "edge": 2.0, "rise": 0.0}, L, L + L**2 / 3),
    (counts.discharge_train, {"strength": 1.0, "length": 2.0}, 2 * L, 2 * L * (2 * L - 1)),
    (counts.ringing_pulse, {"strength": 0.2, "again": 0.0}, 1.2 * L, 1.6 * L),
    (counts.light_crosstalk, {"strength": 0.2}, L / 0.8, L / 0.8**3),
    (counts.uneven_ringing, {"strength": 0.2, "evenness": 3.0}, 1.2 * L, 1.6 * L + 0.04 * L**2),
    (counts.cable_reflection, {"strength": 0.1, "echo": 1.0}, 1.1 * L, 1.3 * L + 0.09 * L**2),
    (counts.leaky_shutter, {"strength": 0.2, "dark": 0.5}, 0.8 * L + 0.1, 0.8 * L + 0.1 + 0.16 * (L - 0.5) ** 2),
    (counts.channels_off, {"strength": 0.3, "channels": 20.0}, 0.7 * L, 0.7 * L + 0.21 * L**2 / 20),
    (counts.ageing, {"strength": 0.5}, 0.75 * L, 0.75 * L + L**2 * 0.25 / 12),
    (counts.mains_hum, {"strength": 0.5, "hum": 1.0}, L, 1.25 * L + 1 / 12),
    (counts.prescaler, {"strength": 1.0, "ratio": 4.0}, L, L + 2.5),
]


@pytest.mark.parametrize(("shape", "settings", "mean", "variance"), MOMENTS, ids=lambda each: getattr(each, "name", ""))
def test_counts_have_their_moments(shape, settings, mean, variance):
    x = measured(shape, **settings)
    assert x.mean() == pytest.approx(mean, abs=5 * x.std() / np.sqrt(N) + 0.05)  # the reference's mean errs too
    assert x.var() == pytest.approx(variance, rel=0.07)


def test_pulses_are_lost_to_dead_time_as_the_formulas_say():
    blind, paralysed = (
        measured(counts.hybrid_dead_time, strength=0.12, paralysis=p, spread=0.0).mean() for p in (0.0, 1.0)
    )
    # of the pulses in one event, those soon after another; the first ones find the counter ready
    assert paralysed == pytest.approx(L * np.exp(-0.12), abs=0.1)
    assert blind == pytest.approx(L / 1.12, abs=0.13)
    assert blind > paralysed


@pytest.mark.parametrize(("slots", "lost"), [(1.0, 0.8 / 1.8), (2.0, 0.32 / 2.12)])
@pytest.mark.parametrize("spread", [0.3, 1.0])
def test_a_buffer_loses_what_erlang_says_however_the_times_in_it_spread(slots, lost, spread):
    at, theta = place(40)
    x = measured(counts.readout_buffer, (at, theta[:4000]), strength=0.8, slots=slots, spread=spread)
    assert x.mean() / 40 == pytest.approx(1 - lost, abs=0.03)  # the buffer is empty when an event begins


def test_buckets_hold_one_count_each():
    x = measured(counts.one_per_bucket, place(40), strength=0.5, daylight=0.2)
    assert x.mean() == pytest.approx(0.8 * 80 * -np.expm1(-0.5), rel=0.01)


def test_blanked_events_have_the_share_asked_for():
    x = measured(counts.trips, strength=0.2, partial=0.0)
    assert (x == 0).mean() == pytest.approx(0.2 + 0.8 * np.exp(-L), abs=0.015)
    x = measured(counts.discharges, strength=0.1, power=1.0)
    assert (x == 0).mean() == pytest.approx(0.1 + np.exp(-L), abs=0.01)


def test_selections_follow_their_efficiency():
    limit = np.quantile(MANY[0].reference, 0.8)
    assert measured(counts.overflow_discarded, strength=0.2, banks=1.0).max() == limit
    level = np.quantile(MANY[0].reference, 0.2)
    x, plain = measured(counts.prescaled_trigger, strength=0.5, below=0.2), MANY[0].reference
    share = (plain <= level).mean() / 2
    assert (x <= level).mean() == pytest.approx(share / (1 - share), abs=0.015)
    x = measured(counts.soft_trigger, strength=0.5, width=0.1)
    assert (x <= 3).mean() < 0.01 < (plain <= 3).mean()


def test_readings_end_and_step_where_they_should():
    reference, few = MANY[0].reference, 0.2
    assert measured(counts.counter_full, strength=few, late=0.0).max() == np.quantile(reference, 0.8)
    assert measured(counts.detection_limit, strength=few, samples=1.0).min() == np.quantile(reference, 0.2) + 1
    assert (measured(counts.stuck_bit, strength=1.0, line=-1.5) % 2 == 0).all()
    assert (measured(counts.hanging_bit, strength=1.0, weight=0.5) % 2 == 1).all()
    x, knee = measured(counts.coarse_range, strength=0.5, step=4.9), np.quantile(reference, 0.5)
    assert (x[x >= knee + 3] % 4 == 0).all()
    assert (x[x < 4] % 4 != 0).any()
