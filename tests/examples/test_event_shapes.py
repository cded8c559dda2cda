"""Observables on events that are worked out by hand, and beside a search of all signs."""

from itertools import product

import event_shapes
import numpy as np
import pytest

ROOT3 = np.sqrt(3)
MERCEDES = [[1, 0, 0], [-0.5, ROOT3 / 2, 0], [-0.5, -ROOT3 / 2, 0]]
"""Three momenta of one size in a plane, at 120 degrees."""
AXES = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
THREE_JETS = [[0, 0, 1], [0.25, 0, -ROOT3 / 4], [-0.25, 0, -ROOT3 / 4]]
"""A momentum of 1, and two of 1/2 at 30 degrees to the opposite direction."""


def of(momenta, mass=0.0):
    """All observables of one event whose particles have one mass."""
    p = np.array([momenta], float)
    return {k: v[0] for k, v in event_shapes.observables(p, np.full(p.shape[:2], mass), beam=10.0).items()}


@pytest.mark.parametrize(
    ("momenta", "expected"),
    [
        ([[0, 0, 4], [0, 0, -4]], {"one_minus_thrust": 0, "thrust_minor": 0, "oblateness": 0, "heavy_jet_mass": 0}),
        ([[0, 0, 4], [0, 0, -4]], {"sphericity": 0, "aplanarity": 0, "c_parameter": 0, "two_jet_resolution": np.inf}),
        # Thrust is along one of them: (1 + 1/2 + 1/2) / 3; major at a right angle: (2 sin 60) / 3.
        (MERCEDES, {"one_minus_thrust": 1 / 3, "thrust_minor": 0, "oblateness": 1 / ROOT3}),
        # Both tensors have the eigenvalues 1/2, 1/2, 0.
        (MERCEDES, {"sphericity": 0.75, "aplanarity": 0, "c_parameter": 0.75}),
        # Energy 2 and momentum 1 in one hemisphere; each pair has 2 (1 - cos 120) = 3. Over the squared energy of 9.
        (MERCEDES, {"heavy_jet_mass": 1 / 3, "two_jet_resolution": np.log(3)}),
        (AXES, {"sphericity": 1, "aplanarity": 0.5, "c_parameter": 1, "one_minus_thrust": 1 - 1 / ROOT3}),
        # Across the diagonal the axes are sqrt(2/3) long, at 60 degrees: 1 + 1/2 + 1/2, or twice cos 30, on both sides.
        (AXES, {"thrust_minor": np.sqrt(2) / 3, "oblateness": np.sqrt(2 / 3) * 2 / 3 - np.sqrt(2) / 3}),
        # The two of 1/2 are joined first: 2 (1/2)^2 (1 - cos 60) / 2^2.
        (THREE_JETS, {"two_jet_resolution": np.log(16), "heavy_jet_mass": 1 / 16}),
        # Along z of 2: 1 and twice cos 30 / 2.
        (THREE_JETS, {"one_minus_thrust": 1 - (1 + ROOT3 / 2) / 2, "oblateness": 0.25}),
    ],
)
def test_shapes_are_those_worked_out_by_hand(momenta, expected):
    got = of(momenta)
    for name, value in expected.items():
        assert got[name] == pytest.approx(value, abs=1e-7), name


def test_spectra_are_those_worked_out_by_hand():
    """A mass of 4 with a momentum of 3 has the energy 5: its rapidity is artanh(3/5) = ln 2."""
    got = of([[0, 0, 3], [0, 0, -3]], mass=4)
    assert got["rapidity_thrust"] == pytest.approx([np.log(2)] * 2)
    assert got["scaled_momentum"] == pytest.approx([0.3] * 2)
    assert got["log_scaled_momentum"] == pytest.approx([np.log(1 / 0.3)] * 2)
    planes = of([[5, 0, 0], [-5, 0, 0], [0, 2, 0], [0, -2, 0], [0, 0, 1], [0, 0, -1]])
    assert planes["pt_in"] == pytest.approx([0, 0, 2, 2, 0, 0])
    assert planes["pt_out"] == pytest.approx([0, 0, 0, 0, 1, 1])


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("k", [2, 3, 6, 7])
def test_thrust_and_major_are_the_largest_of_all_signs(k, flat):
    p = np.random.default_rng(k).normal(size=(5, k, 3)) * [1, 1, 0 if flat else 1]
    total, signs = np.linalg.norm(p, axis=2).sum(axis=1), np.array(list(product([1, -1], repeat=k)))
    value, axis = event_shapes.thrust(p)
    assert value == pytest.approx(np.linalg.norm(signs @ p, axis=2).max(axis=1) / total)
    assert (np.abs(p @ axis[:, :, None]).sum(axis=(1, 2)) / total) == pytest.approx(value)
    across = p - (p @ axis[:, :, None]) * axis[:, None]
    major, second = event_shapes.thrust_major(p, axis)
    assert major == pytest.approx(np.linalg.norm(signs @ across, axis=2).max(axis=1) / total, abs=1e-9)
    assert (second * axis).sum(axis=1) == pytest.approx(0, abs=1e-6)


def test_shapes_do_not_depend_on_direction_order_or_company():
    """Events of several multiplicities at once are each as they are alone, also turned round and in another order."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    events = [rng.normal(size=(k, 3)) for k in (5, 3, 5, 9)]
    mass = np.full(22, 0.14)
    together = event_shapes.reduced(np.array([5, 3, 5, 9]), np.vstack(events), mass, 10.0)
    alone = [of(p[::-1] @ turn, 0.14) for p in events]
    for name, value in together.items():
        parts = [each[name] if np.ndim(each[name]) == 0 else each[name][::-1] for each in alone]
        np.testing.assert_allclose(value, np.hstack(parts), rtol=1e-6, atol=1e-7, err_msg=name)
