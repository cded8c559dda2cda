"""Alignment in three dimensions: exact geometry, the symmetries of the tracker, and a floor that was measured."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from avobench.tasks.alignment import Alignment, Particles
from avobench.tasks.alignment_3 import FLOORS, HEIGHTS, RADII, Alignment3
from paper.information import of_cells

TASK = Alignment3()
ROWS, COLUMNS = TASK.event_shape


@cache
def generated() -> Particles:
    """1000 events."""
    return next(TASK.generate(1000, np.random.default_rng(2020)))


def images(theta: tuple[float, float, float], particles: Particles | None = None) -> NDArray:
    """The shared events, or others, seen at theta: (n, 16, 8)."""
    particles = particles or generated()
    return TASK.detect(particles, np.tile(theta, (len(particles), 1))).reshape(-1, ROWS, COLUMNS)


def turned(particles: Particles, angle: float) -> Particles:
    """The particles turned about the beam axis."""
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return replace(particles, position=turn @ particles.position, momentum=turn @ particles.momentum)


@pytest.mark.parametrize("offset", [(1.0, 0.0, 0.0), (-0.7, 1.2, 0.0), (1.5, -1.5, 1.0), (0.0, 0.0, -1.5)])
def test_a_track_leaves_the_sphere_where_geometry_says(offset):
    """Along +y from the offset: at x and z of the offset, and the y that is left on the sphere."""
    momentum = np.array([[0.0], [1.0], [0.0]])
    track = Particles(np.array([0, 1]), np.zeros((3, 1)), momentum, np.ones(1), np.array([np.inf]))
    x, _, z = offset
    y = np.sqrt(TASK.radius**2 - x**2 - z**2)
    row = int((np.arctanh(z / TASK.radius) + 5) * ROWS / 10)
    column = int(np.arctan2(y, x) * COLUMNS / (2 * np.pi))
    assert np.argwhere(images(offset, track)[0]).tolist() == [[row, column]]


def test_along_the_beam_it_is_alignment_with_larger_cells():
    fine = Alignment().detect(generated(), np.full((1000, 1), 0.8)).reshape(-1, ROWS, 2, COLUMNS, 4)
    assert (images((0.0, 0.0, 0.8)) == fine.max(axis=(2, 4))).all()


def test_turned_events_at_a_turned_offset_make_turned_images():
    """By one column, 45 degrees. A track on an edge may fall to either side of it."""
    column = 2 * np.pi / COLUMNS
    moved = (1.2 * np.cos(0.3 + column), 1.2 * np.sin(0.3 + column), -0.6)
    before, after = images((1.2 * np.cos(0.3), 1.2 * np.sin(0.3), -0.6)), images(moved, turned(generated(), column))
    assert (np.roll(before, 1, axis=2) != after).mean() < 1e-5


def test_no_axis_is_cyclic_and_no_default_sweep_has_it():
    assert TASK.cyclic_axes == ()
    assert not TASK.by_default
    columns = images((1.5, 0.0, 0.0)).mean(axis=(0, 1))
    assert columns.max() > 1.5 * columns.min()


def test_the_floor_is_the_inverse_of_the_information_and_fewer_events_to_learn_from_find_less_of_it():
    found = of_cells(TASK, np.zeros((1, 3)), 8000, np.random.default_rng(3))[0]
    assert found == pytest.approx(found.T)
    times = np.trace(np.linalg.inv(found)) / FLOORS[0][0]  # weights of 128 cells, learnt from 4000 events, not 32 000
    assert 1 < times < 2
    assert TASK.floor(np.zeros(3), 100_000, 160_000) == pytest.approx((1 / 1e5 + 1 / 1.6e5) * FLOORS[0][0])


def test_the_floor_depends_on_the_distances_from_axis_and_centre_alone():
    somewhere = [TASK.floor(np.array([1.1 * np.cos(a), 1.1 * np.sin(a), z]), 1000, None) for a, z in [(0, 1), (2, -1)]]
    assert somewhere[0] == pytest.approx(somewhere[1])
    assert np.isfinite([TASK.floor(np.array(corner), 1000, 1000) for corner in [TASK.prior.low, TASK.prior.high]]).all()
    assert sum(TASK.floor_shares) == pytest.approx(1)


def test_the_floor_is_unknown_where_it_was_not_measured():
    assert np.isnan(TASK.floor(np.array([0.0, 0.0, HEIGHTS[-1] + 0.1]), 1000, 1000))
    assert np.isnan(TASK.floor(np.array([RADII[-1] + 0.1, 0.0, 0.0]), 1000, 1000))
    assert np.isnan(Alignment3(radius=10).floor(np.zeros(3), 1000, 1000))
