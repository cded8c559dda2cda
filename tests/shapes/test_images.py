"""Shapes of images: the hits that they add or lose are as many as asked for."""

from dataclasses import replace

import numpy as np
import pytest

from shapes.images import IMAGES

N, ROWS, COLUMNS = 200, 32, 32
SHAPES = {shape.name: shape for shape in IMAGES.shapes}
THETA = np.full((2000, 1), 0.4)


def full(theta, rng):
    return np.ones((len(theta), ROWS * COLUMNS), np.uint8)


def empty(theta, rng):
    return np.zeros((len(theta), ROWS * COLUMNS), np.uint8)


def measured(name, place, simulate, n=N, **fixed):
    """The images of n events at some fixed settings, (n, rows, columns)."""
    injection = SHAPES[name].draw(place, np.random.default_rng(3))
    assert fixed.keys() <= injection.settings.keys()
    injection = replace(injection, settings={**injection.settings, **fixed})
    return injection.measure(simulate, THETA[:n], np.random.default_rng(0)).reshape(n, ROWS, COLUMNS)


LOSSES = {
    "clock_phase": (0.7, {"strength": 0.3}),
    "clock_edge": (0.75, {"strength": 0.5}),
    "supply_ripple": (0.7, {"strength": 0.6}),
    "air_pressure": (np.exp(-0.5), {"strength": 0.5, "weather": 0.0}),
    "bad_timing": (0.8, {"strength": 0.2, "evenness": 5.0}),
    "uneven_efficiency": (0.7, {"strength": 0.3, "unevenness": 0.7}),
    "forward_damage": (0.6, {"strength": 0.8, "power": 1.0}),
    "upset_masks": (-np.expm1(-0.3) / 0.3, {"strength": 0.3}),
    "dead_patch": (1 - 30 / 1024, {"strength": 30.0, "residual": 0.0}),
    "cracked_bonds": (1 - 20 / 1024, {"strength": 40.0, "cold": 0.5}),
    "burnt_spot": (1 - np.pi * 50 / 1024, {"strength": 5.0, "stretch": 2.0, "edge": 0.01}),
    "dead_board": (1 - 0.25 * 1.5, {"strength": 0.25, "row": 0.5, "opposite": 0.5}),
    "weak_line": (1 - 0.75 / 32, {"strength": 0.5, "neighbour": 0.5}),
    "resistive_column": (1 - (1 + np.expm1(-2) / 2) / 32, {"strength": -2.0}),
}
GAINS = {
    "noise_clusters": (4.5, {"strength": 3.0, "burst": 0.5, "pairs": 0.5}),
    "light_bursts": (3, {"strength": 3.0}),
    "beam_halo": (3, {"strength": 3.0, "spill": 0.5}),
    "common_mode": (3, {"strength": 3.0, "sway": 0.0}),
    "radioactivity": (6, {"strength": 2.0, "shared": 0.5}),
    "stray_electrons": (4, {"strength": 2.0, "goes_on": 0.5}),
    "hot_cells": (5, {"strength": 0.5, "cells": 10.5, "spread": 0.0}),
    "noisy_chip": (4, {"strength": 0.5, "cells": 10.0, "together": 0.8}),
    "clock_feedthrough": (32 * 0.15, {"strength": 0.1, "bunching": 0.5}),
}


@pytest.mark.parametrize("name", LOSSES)
def test_hits_are_lost_in_the_share_asked_for(tracker, name):
    left, fixed = LOSSES[name]
    assert 1 - measured(name, tracker, full, 1000, **fixed).mean() == pytest.approx(1 - left, rel=0.12)


@pytest.mark.parametrize("name", GAINS)
def test_false_hits_are_as_many_as_asked_for(tracker, name):
    mean, fixed = GAINS[name]
    assert measured(name, tracker, empty, 2000, **fixed).sum() / 2000 == pytest.approx(mean, rel=0.12)


@pytest.mark.parametrize(
    ("name", "seen"), [("bunch_crossing", None), ("out_of_time", "in_time"), ("late_pulses", "left")]
)
def test_further_collisions_are_as_many_as_asked_for(tracker, name, seen):
    share = {"strength": 0.3, seen: 0.5} if seen else {"strength": 0.3}
    x = measured(name, tracker, lambda at, rng: (empty if len(at) == 2000 else full)(at, rng), 2000, **share)
    double = x.any(axis=(1, 2))
    assert double.mean() == pytest.approx(0.3 if name == "late_pulses" else -np.expm1(-0.3), abs=0.04)
    assert np.quantile(x[double].mean(axis=(1, 2)), 0.1) == pytest.approx(0.5 if seen else 1, abs=0.05)


@pytest.mark.parametrize(("name", "rows"), [("summed_trigger", slice(32)), ("central_trigger", slice(8, 24))])
def test_a_trigger_on_the_number_of_hits_loses_events_with_few(tracker, name, rows):
    sharp = {"noise": 1e-6} if name == "summed_trigger" else {"width": 1e-6, "middle": 0.5}
    x = measured(name, tracker, tracker.task.simulate, strength=0.3, **sharp)[:, rows]
    hits = tracker.reference.reshape(-1, ROWS, COLUMNS)[:, rows].sum(axis=(1, 2))
    assert x.sum(axis=(1, 2)).min() == np.quantile(hits, 0.3)


def test_what_is_beside_a_hit_decides(tracker):
    def three(theta, rng):
        x = np.zeros((len(theta), ROWS, COLUMNS), np.uint8)
        x[:, 16, [3, 31, 0]] = 1  # the last two are neighbours around the beam
        return x.reshape(len(theta), -1)

    x = measured("cluster_cleaning", tracker, three, strength=1.0, pairs=0.0)
    np.testing.assert_array_equal(np.argwhere(x[0]), [[16, 0], [16, 31]])
    x = measured("hot_amplifier", tracker, three, strength=1.0, row=0.51)
    np.testing.assert_array_equal(np.flatnonzero(x[0, 16]), [0, 1, 2, 3, 4, 30, 31])
    x = measured("shared_charge", tracker, three, strength=1.0, row=0.54)
    np.testing.assert_array_equal(x[:, 17], x[:, 16])
    x = measured("sagging_supply", tracker, three, 2000, strength=0.5, row=0.51)
    assert x.sum() / 2000 == pytest.approx(3 / (1 + 0.5 * 2), rel=0.06)
    x = measured("busy_link", tracker, three, 2000, strength=0.5)
    assert x.sum() / 2000 == pytest.approx(3 * 0.5**2, rel=0.08)


def test_the_detector_and_the_beams_turn_and_move(tracker):
    plain, half = tracker.task.simulate, {"strength": np.pi, "azimuth": 0.0}
    x, mirrored = (plain(at, np.random.default_rng(0)).reshape(N, ROWS, COLUMNS) for at in (THETA[:N], -THETA[:N]))
    for name in (shape.name for shape in IMAGES.shapes if shape.stage == 0 and shape.name != "soft_particles"):
        np.testing.assert_array_equal(measured(name, tracker, plain, strength=0.0), x)
    turned = measured("rocking_frame", tracker, plain, rock=0.0, **half)
    assert (turned == x[:, ::-1, ::-1]).mean() > 0.9999
    turned = measured("tilted_beams", tracker, plain, divergence=0.0, **half)  # the collision stays where it was
    assert (turned == mirrored[:, ::-1, ::-1]).mean() > 0.9999
    columns = measured("wandering_beam", tracker, plain, strength=1.0, azimuth=0.0).sum(axis=(0, 1))
    assert columns[[*range(4), *range(28, 32)]].sum() > 1.2 * columns[12:20].sum()
    soft = measured("soft_particles", tracker, plain, strength=0.5)
    assert (soft <= x).all()
    assert 0.5 < soft.sum() / x.sum() < 0.95
