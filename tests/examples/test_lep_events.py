"""The bank of the ALEPH example: what is simulated, and that nothing is twice."""

import lep_events
import numpy as np
import pytest


def test_events_are_charged_particles_of_the_z_and_follow_theta_and_seed():
    few, many, again = (lep_events.simulate(np.array([0.335, 0.68, b]), 300, seed=1) for b in (0.12, 0.15, 0.15))
    assert all((many[name] == again[name]).all() for name in many)
    assert few["count"].mean() + 0.5 < many["count"].mean() == pytest.approx(21.5, abs=1.5)
    assert few["count"].sum() == len(few["momentum"]) == len(few["mass"])
    energy = np.sqrt((few["momentum"] ** 2).sum(axis=1) + few["mass"] ** 2)
    assert np.add.reduceat(energy, np.r_[0, np.cumsum(few["count"])[:-1]]).max() < 91.2
    assert np.unique(np.round(few["mass"], 3)).tolist()[-2:] == pytest.approx([0.494, 0.938], abs=2e-3)


def test_what_is_kept_is_not_simulated_again_unless_theta_is_another_one(tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(lep_events, "FOLDER", tmp_path)
    monkeypatch.setattr(lep_events, "simulate", lambda theta, n, seed: calls.append((theta, n, seed)) or {})
    for theta in (1.0, 1.0, 2.0):
        lep_events.fill("x", np.array([theta]), 10, seed=3)
    assert calls == [([1.0], 10, 3), ([2.0], 10, 3)]
    assert [path.name for path in tmp_path.iterdir()] == ["x.npz"]
