"""Alignment: real Pythia events, exact geometry, and a stream that neither repeats nor depends on how it is asked."""

import dataclasses
import pickle
from functools import cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import chi2

from avobench.tasks import alignment
from avobench.tasks.alignment import NUM_COLUMNS, NUM_ROWS, Alignment, Particles
from paper.information import of_rows

TASK = Alignment()


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pythia generates no more than a test asks for: the events of its stream are the same in chunks of any size."""
    monkeypatch.setattr(alignment, "CHUNK", 100)


@cache
def generated() -> list[Particles]:
    """4000 events, shared by the tests that only look at them."""
    return list(Alignment().generate(4000, np.random.default_rng(2019)))


def images(theta: float, task: Alignment = TASK) -> NDArray:
    """The shared events seen at theta: (4000, 32, 32)."""
    seen = [task.detect(particles, np.full((len(particles), 1), theta)) for particles in generated()]
    return np.concatenate(seen).reshape(-1, NUM_ROWS, NUM_COLUMNS)


def simulate(theta: float | NDArray, n: int, seed: int = 0) -> NDArray:
    return Alignment().simulate(np.broadcast_to(np.reshape(theta, (-1, 1)), (n, 1)), np.random.default_rng(seed))


def one(position: tuple, momentum: tuple, reach: float = np.inf) -> Particles:
    place, along = (np.array([each], float).T for each in (position, momentum))
    return Particles(np.array([0, 1]), place, along, np.ones(1), np.array([reach]))


def cells(particles: Particles, theta: float = 0.0, task: Alignment = TASK) -> list[tuple[int, int]]:
    image = task.detect(particles, np.array([[theta]])).reshape(NUM_ROWS, NUM_COLUMNS)
    return [(int(row), int(column)) for row, column in np.argwhere(image)]


# Pythia


def test_charged_multiplicity_is_the_measured_one() -> None:
    final = np.concatenate([np.add.reduceat(np.isinf(p.reach), p.offsets[:-1], dtype=int) for p in generated()])
    assert len(final) == 4000
    assert final.mean() == pytest.approx(20.71, abs=5 * 6.52 * np.sqrt(1 / 4000 + 1 / 3000))  # LEP: 20.76 +- 0.16
    assert final.std() == pytest.approx(6.52, abs=0.4)  # LEP: 6.3 to 6.5


def test_fewer_charged_particles_when_k0s_and_lambda_are_stable() -> None:
    pieces = list(Alignment(max_tau0=10).generate(1000, np.random.default_rng(0)))
    mean = sum(np.isinf(piece.reach).sum() for piece in pieces) / 1000
    assert mean == pytest.approx(18.5, abs=5 * 6.5 / np.sqrt(1000))


@pytest.mark.parametrize("counted", ["charged", "visible"])
def test_particles_are_those_of_pythias_own_event_record(counted: str) -> None:
    particles = next(Alignment(particles=counted).generate(100, np.random.default_rng(7)))
    seed = np.random.default_rng(7).integers(1, 900_000_000, endpoint=True)
    pythia = alignment.start_pythia((*alignment.SETTINGS, "ParticleDecays:tau0Max = 1000", f"Random:seed = {seed}"))
    for i in range(100):
        assert pythia.next()
        record = [
            (q.xProd(), q.yProd(), q.zProd(), q.px(), q.py(), q.pz(), q.e(), np.inf if q.isFinal() else q.tau() / q.m())
            for q in pythia.event
            if q.isFinal() or ((q.isHadron() or q.isLepton()) and q.tau() > 0)
            if q.isCharged() or (counted == "visible" and q.idAbs() not in (12, 14, 16))
        ]
        event = particles.events(i, i + 1)
        ours = np.vstack([event.position, event.momentum, event.energy, event.reach]).T
        np.testing.assert_allclose(ours, record, rtol=1e-9, atol=1e-9)


def test_pythia_that_cannot_run_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alignment, "SETTINGS", (*alignment.SETTINGS, "Beams:eCM = 1."))
    with pytest.raises(RuntimeError, match="initialise"):
        simulate(0.0, 1)
    monkeypatch.setattr(alignment, "SETTINGS", ("No:such = thing",))
    with pytest.raises(RuntimeError, match="No:such"):
        simulate(0.0, 1)


# Detector


@given(eta=st.floats(-4.99, 4.99), phi=st.floats(0, 6.28))
def test_track_from_the_centre_hits_the_cell_it_points_to(eta: float, phi: float) -> None:
    row, column = (eta + 5) * NUM_ROWS / 10, phi * NUM_COLUMNS / (2 * np.pi)
    momentum = (np.cos(phi), np.sin(phi), np.sinh(eta))
    (hit,) = cells(one((0, 0, 0), momentum))
    assert hit[0] == pytest.approx(row - 0.5, abs=0.5 + 1e-6)
    assert hit[1] == pytest.approx(column - 0.5, abs=0.5 + 1e-6)


@given(
    theta=st.floats(-3.1, 3.1),
    position=st.tuples(*[st.floats(-0.05, 0.05)] * 3),
    eta=st.floats(-3, 3),
    phi=st.floats(0, 6.28),
)
def test_hit_is_where_the_track_leaves_the_sphere(theta: float, position: tuple, eta: float, phi: float) -> None:
    direction = np.array([np.cos(phi), np.sin(phi), np.sinh(eta)]) / np.cosh(eta)
    start = np.add(position, (0, 0, theta))
    # March along the track to the sphere by bisection: an independent way to the same point.
    low, high = 0.0, 10.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if np.linalg.norm(start + middle * direction) < 3.2 else (low, middle)
    x, y, z = start + low * direction
    found = cells(one(position, tuple(5 * direction)), theta)
    row, column = (np.arctanh(z / 3.2) + 5) * NUM_ROWS / 10, np.arctan2(y, x) % (2 * np.pi) * NUM_COLUMNS / (2 * np.pi)
    if min(row % 1, 1 - row % 1, column % 1, 1 - column % 1) > 1e-6:  # not on an edge
        assert found == ([(int(row), int(column))] if 0 < row < NUM_ROWS else [])  # lost beyond |eta| = 5


def test_forward_tracks_are_lost() -> None:
    assert cells(one((0, 0, 0), (1, 0, np.sinh(4.99)))) == [(31, 0)]
    for pz in (np.sinh(5.01), -np.sinh(5.01), 1e9):
        assert cells(one((0, 0, 0), (1, 0, pz))) == []
    assert cells(one((0, 0, 0), (0, 0, 1))) == []


def test_only_what_starts_inside_and_lives_to_leave_is_recorded() -> None:
    momentum = (2.0, 0.1, 0.1)
    assert cells(one((3.1, 0, 0), momentum)) == [(16, 0)]
    assert cells(one((3.3, 0, 0), momentum)) == []
    assert cells(one((-3.3, 0, 0), momentum)) == []  # enters and leaves, but comes from outside
    assert cells(one((0, 0, 0), momentum, reach=1.55)) == []  # decays at x = 3.1 mm
    assert cells(one((0, 0, 0), momentum, reach=1.65)) == [(16, 0)]
    # The sphere is narrower where the interaction point is off centre: what decays inside at 0 decays outside at 1.5.
    assert cells(one((0, 0, 0), momentum, reach=1.55), theta=1.5) != []
    assert cells(one((2.9, 0, 0), momentum), theta=0) != []
    assert cells(one((2.9, 0, 0), momentum), theta=1.5) == []


def test_energy_of_a_cell_is_the_sum_and_log1p_its_logarithm() -> None:
    two = Particles(np.array([0, 2, 2]), np.zeros((3, 2)), np.ones((3, 2)), np.array([1.5, 2.0]), np.full(2, np.inf))
    theta = np.zeros((2, 1))
    energy = Alignment(response="energy").detect(two, theta)
    log = Alignment(response="energy", log1p=True).detect(two, theta)
    assert energy.dtype == log.dtype == np.float32
    assert energy.sum(axis=1).tolist() == [3.5, 0.0]
    assert log.sum(axis=1).tolist() == [np.float32(np.log(4.5)), 0.0]
    assert TASK.detect(two, theta).sum(axis=1).tolist() == [1, 0]


def test_average_image_is_uniform_in_phi_which_is_cyclic() -> None:
    assert (TASK.event_shape, TASK.cyclic_axes) == ((32, 32), (1,))
    columns = images(0.0).sum(axis=1, dtype=float)
    difference = columns[:, 1:] - columns[:, :1]
    mean = difference.mean(axis=0)  # zero, whatever the correlations inside an event
    assert chi2.sf(4000 * mean @ np.linalg.solve(np.cov(difference.T), mean), NUM_COLUMNS - 1) > 1e-4


# The stream


def test_events_do_not_depend_on_how_calls_are_split() -> None:
    theta = np.linspace(-1.5, 1.5, 220)[:, None]
    task, rng = Alignment(), np.random.default_rng(0)
    whole = task.simulate(theta, rng)
    rng = np.random.default_rng(0)  # the same seed and another object: a new stream
    parts = [task.simulate(part, rng) for part in np.split(theta, [1, 32, 33, 100, 116])]
    assert np.array_equal(whole, np.concatenate(parts))


def test_rows_depend_on_their_own_theta_only() -> None:
    mixed = simulate(np.tile([-1.4, 1.4], 100), 200)
    assert np.array_equal(mixed[::2], simulate(-1.4, 200)[::2])
    assert np.array_equal(mixed[1::2], simulate(1.4, 200)[1::2])


def test_no_event_comes_twice() -> None:
    task = Alignment()
    rng = np.random.default_rng(2019)
    streams = chain(task.generate(350, rng), task.generate(150, rng), task.generate(150, np.random.default_rng(1)))
    events = [piece.events(i, i + 1) for piece in streams for i in range(len(piece))]
    assert len({event.momentum.tobytes() for event in events}) == len(events) == 650


def test_a_pickled_task_is_the_same_task_without_the_stream() -> None:
    task = Alignment(radius=4.0)
    theta, rng = np.zeros((20, 1)), np.random.default_rng(5)
    x = task.simulate(theta, rng)
    other = pickle.loads(pickle.dumps(task))
    assert other == task
    assert dataclasses.asdict(other) == dataclasses.asdict(task)
    assert np.array_equal(other.simulate(theta, np.random.default_rng(5)), x)
    assert not np.array_equal(task.simulate(theta, rng), x)


# Bounds and floor


@pytest.mark.parametrize("theta", [3.2, -3.2, np.nan, np.inf, 3.19])
def test_interaction_point_outside_the_sphere_is_refused(theta: float) -> None:
    with pytest.raises(ValueError, match="outside the support of alignment"):
        simulate(np.array([0.0, theta]), 2)
    with pytest.raises(ValueError, match="outside the support of alignment"):
        TASK.detect(one((0, 0, 0), (1, 0, 0)), np.array([[theta]]))


@pytest.mark.parametrize(
    "changed",
    [
        *({"radius": radius} for radius in (1.5, -3.2, np.nan, np.inf)),
        {"response": "miss"},
        {"log1p": True},
        {"particles": "neutral"},
        *({"max_tau0": longest} for longest in (-1, 1e4, np.nan)),
    ],
)
def test_settings_that_make_no_sense_are_refused(changed: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(changed))):
        Alignment(**changed)


def test_floor_is_what_the_fisher_information_allows() -> None:
    theta = np.array([0.0, -0.75, 1.5])
    measured = of_rows(Alignment(), theta, 5000, np.random.default_rng(11))
    floors = [TASK.floor(np.array([t]), 100_000, 160_000) for t in theta]
    assert floors == pytest.approx((1 / 100_000 + 1 / 160_000) / measured, rel=0.15)
    assert TASK.floor(np.zeros(1), 100_000, None) == pytest.approx(floors[0] / (1 + 1 / 1.6))
    few = of_rows(Alignment(), theta[2:], 100, np.random.default_rng(0))
    assert np.isfinite(few).all()  # though no event hits the outermost row


def test_fisher_information_predicts_a_real_estimator() -> None:
    """A linear estimator of theta from sets of events has the variance that the information says."""
    rows, step = images(0.0).sum(axis=2, dtype=float), 0.1
    slope = (images(step).sum(axis=2, dtype=float) - images(-step).sum(axis=2, dtype=float)).mean(axis=0) / (2 * step)
    weights = np.linalg.solve(np.cov(rows.T), slope)
    estimates = (rows - rows.mean(axis=0)) @ weights / (slope @ weights)
    information = of_rows(Alignment(), np.zeros(1), 3000, np.random.default_rng(12))
    assert 1 / estimates.var() == pytest.approx(information[0], rel=0.15)


def test_floor_is_unknown_where_it_was_not_measured() -> None:
    assert np.isnan(TASK.floor(np.array([1.6]), 1000, 1000))
    assert np.isnan(Alignment(radius=10).floor(np.zeros(1), 1000, 1000))
