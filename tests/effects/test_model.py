"""A chain of effects: what acts first, and what acts on particles before there is an event."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from measurements import entry, shape_of

import avobench
from avobench.challenge.shape import Injection, Place
from avobench.effects.model import Model
from avobench.effects.pool import Pool
from avobench.tasks import alignment
from avobench.tasks.alignment import Alignment
from avobench.tasks.carl import Carl
from avobench.tasks.poisson import Poisson
from shapes.images import rocking_frame, wandering_beam

N = 1_000


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch):
    """Pythia generates no more than a test asks for."""
    monkeypatch.setattr(alignment, "CHUNK", 100)


def effect_of(task, name, shape=None):
    return shape_of(entry(task, name), shape)


@pytest.mark.parametrize(
    ("task", "theta", "first", "then"),
    [
        (Poisson(), [1.5], ("overdispersion", [0.2]), ("dead_time", [0.1])),
        (Poisson(), [1.5], ("threshold_loss", [0.4]), ("readout_noise", [1.0])),
        (Carl(), [0.5, -0.5], ("offset", [0.3]), ("flat_background", [0.2])),
        (Carl(), [0.5, -0.5], ("offset", [0.3]), ("quantisation", [0.5])),
    ],
)
def test_effects_act_in_the_order_of_their_stages_whichever_was_added_first(task, theta, first, then):
    (one, phi), (other, psi) = ((effect_of(task, name), values) for name, values in (first, then))
    assert one.stage < other.stage
    phi = [*phi, *((p.low + p.high) / 2 for p in one.parameters[len(phi) :])]
    psi = [*psi, *((p.low + p.high) / 2 for p in other.parameters[len(psi) :])]
    x = Model(task, (one, other)).simulate(np.tile([*theta, *phi, *psi], (N, 1)), np.random.default_rng(0))
    y = Model(task, (other, one)).simulate(np.tile([*theta, *psi, *phi], (N, 1)), np.random.default_rng(0))
    np.testing.assert_array_equal(x, y)
    assert Model(task, (one, other)).newest_acts_last
    assert not Model(task, (other, one)).newest_acts_last
    # From one seed, one that acts earlier changes nothing but what it acts on: nothing, where it is absent.
    absent = [one.parameters[0].null, *phi[1:]]
    z = Model(task, (other, one)).simulate(np.tile([*theta, *psi, *absent], (N, 1)), np.random.default_rng(0))
    alone = Model(task, (other,)).simulate(np.tile([*theta, *psi], (N, 1)), np.random.default_rng(0))
    np.testing.assert_array_equal(z, alone)


def images(task, name, theta, phi, shape=None, n=N):
    at = np.tile([theta, *phi], (n, 1))
    return Model(task, (effect_of(task, name, shape),)).simulate(at, np.random.default_rng(3))


@pytest.mark.parametrize("theta", [-1.2, 0.7])
@pytest.mark.parametrize(
    ("shape", "settings", "phi"),
    [
        # The azimuth of a shape is in turns, and that of a tilt is the axis's.
        (rocking_frame, {"strength": 0.2, "azimuth": 0.9 / (2 * np.pi) + 0.25, "rock": 0, "cycles": 5}, [0.2, 0.9]),
        (wandering_beam, {"strength": 0.8, "azimuth": -0.4 / (2 * np.pi), "wander": 0}, [0.8 / 3.2, -0.4]),
    ],
)
def test_a_tracker_out_of_place_is_what_the_challenge_makes_of_it(theta, shape, settings, phi):
    # Two codes for one geometry, on the same particles: a hit in another cell only where rounding decides.
    task = Alignment()
    where = Place(task, None, np.zeros((1, 1024), np.uint8))
    at = np.full((200, 1), theta)
    expected = Injection(shape, where, settings).measure(task.simulate, at, np.random.default_rng(3))
    found = images(task, shape.family, theta, phi, n=200)
    assert (found != expected).sum() <= 2
    assert (found != task.simulate(at, np.random.default_rng(3))).any(axis=1).mean() > 0.9


def test_particles_below_a_sharp_threshold_are_lost():
    task, threshold = Alignment(), 0.5
    found = images(task, "inefficiency", 0.0, [threshold, 0.05], "soft")
    at, particles = np.zeros((N, 1)), []
    for piece in task.generate(N, np.random.default_rng(3)):
        fast = np.sqrt((piece.momentum**2).sum(axis=0)) > threshold
        particles.append(task.detect(piece.only(fast), at[: len(piece)]))
    fast, whole = np.concatenate(particles), task.simulate(at, np.random.default_rng(3))
    assert int(found.sum()) == pytest.approx(int(fast.sum()), rel=0.005)
    assert found.sum() < 0.9 * whole.sum()
    np.testing.assert_array_equal(images(task, "inefficiency", 0.0, [0, 0.2], "soft"), whole)


def test_what_acts_on_particles_composes_and_comes_first():
    task = Alignment()
    tilt, offset, cells = (effect_of(task, name) for name in ("axial_tilt", "transverse_offset", "inefficiency"))
    pool = Pool(task, N, np.random.default_rng(0))
    tilted, moved, lost, theta = [0.1, 0.3], [0.1, 1.0], [0.2], [0.5]
    # A tilt of the detector after a shift of the beam; and a loss of hits after both, although it was added first.
    models = (tilt, offset), (cells, tilt, offset), (tilt, offset, cells)
    values = tilted + moved, lost + tilted + moved, tilted + moved + lost
    x, y, z = (
        Model(task, effects, events=pool).simulate(np.tile(theta + phi, (N, 1)), np.random.default_rng(1))
        for effects, phi in zip(models, values, strict=True)
    )
    np.testing.assert_array_equal(y, z)
    assert (y <= x).all()
    assert int(y.sum()) == pytest.approx(0.8 * x.sum(), rel=0.01)
    alone = [
        Model(task, (effect,), events=pool).simulate(np.tile(theta + phi, (N, 1)), np.random.default_rng(1))
        for effect, phi in ((tilt, tilted), (offset, moved))
    ]
    assert all((x != one).any(axis=1).mean() > 0.9 for one in alone)


def test_a_task_that_generates_first_need_not_let_its_particles_be_altered():
    """As a user may write one."""
    task, at = Alignment(), np.zeros((20, 1))
    plain = SimpleNamespace(
        generate=task.generate, detect=task.detect, simulate=lambda theta, rng: task.simulate(theta, rng)
    )
    pool = Pool(plain, 50, np.random.default_rng(0))
    np.testing.assert_array_equal(pool.fresh(at, np.random.default_rng(1)), task.simulate(at, np.random.default_rng(1)))
    assert pool(at, np.random.default_rng(1)).shape == (20, 1024)


HUNDREDTHS = st.integers(-300, 300)


@given(HUNDREDTHS, st.integers(1, 300), st.floats(0, 1))
def test_no_parameter_leaves_its_bounds_by_rounding(low, width, u):
    prior = {"a": (low / 100, (low + width) / 100)}
    model = Model(avobench.task(lambda theta, rng: theta[:, 0] + rng.normal(size=len(theta)), prior=prior, name="toy"))
    params = model.from_cube(np.array([[0.0], [u], [1.0]]))
    assert model.task.support.contains(params).all()
