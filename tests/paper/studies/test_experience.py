"""Examples of what effects look like, and what is learnt from them."""

import numpy as np
import pytest

from avobench.diagnosis.experience.recogniser import compressed, forward
from avobench.tasks.errors import UsageError
from paper.grammar.simulators import task
from paper.studies import experience
from paper.studies.experience import Examples, Nearby, examples, make, read, trained

N = 10_000
normal = task("normal", ["location", "scale"], lambda t, rng: rng.normal(t[:, 0], np.exp(t[:, 1]))[:, None], 1)


def nearby(theta):
    rng = np.random.default_rng(0)
    return Nearby(normal, np.array(theta), normal.simulate(np.tile(theta, (N, 1)), rng))


def test_examples_are_those_of_their_seed():
    one, again, other = (examples("count", np.random.default_rng(seed), 20) for seed in (0, 0, 1))
    for column in ("portraits", "families", "sentences", "simulators"):
        np.testing.assert_array_equal(getattr(one, column), getattr(again, column))
    assert len(one.portraits) == len(one.families) == len(one.simulators)
    assert not np.array_equal(one.simulators, other.simulators)


def test_theta_is_fitted_before_anything_is_said_to_show():
    near, rng = nearby([0.0, 0.0]), np.random.default_rng(1)
    simulated, p_value = near.beside(normal.simulate(np.tile([0.3, 0.2], (3000, 1)), rng), rng)
    assert p_value > 1e-3
    assert simulated.mean() == pytest.approx(0.3, abs=0.06)
    assert np.log(simulated.std()) == pytest.approx(0.2, abs=0.04)
    assert near.beside(rng.uniform(-2, 2, (3000, 1)), rng)[1] < 1e-10


def test_where_nothing_is_wrong_p_values_are_not_small():
    near, rng = nearby([0.0, 0.0]), np.random.default_rng(2)
    p_values = [near.beside(normal.simulate(np.zeros((2000, 2)), rng), rng)[1] for _ in range(100)]
    assert np.mean(np.array(p_values) < 0.1) < 0.2


def test_what_was_kept_is_not_made_again_and_what_is_missing_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(experience, "PART", 10)
    with pytest.raises(UsageError, match="there are no examples in"):
        read("real", tmp_path)
    make("real", 0, tmp_path)
    before = (tmp_path / "real-0.npz").stat().st_mtime_ns
    make("real", 0, tmp_path)
    assert (tmp_path / "real-0.npz").stat().st_mtime_ns == before
    make("real", 1, tmp_path)
    parts = [Examples.read(tmp_path / f"real-{k}.npz").portraits for k in range(2)]
    assert len(read("real", tmp_path).portraits) == sum(map(len, parts))


def test_a_trained_network_says_the_same_with_its_scale_in_its_weights():
    rng = np.random.default_rng(0)
    portraits = 10 * rng.normal(size=(600, 7)) + 5
    names = np.array(["first", "second", "third"])[portraits[:, :3].argmax(axis=1)]
    pairs = np.stack([names, names], 1)
    families, networks = trained(Examples(portraits.astype(np.float32), pairs, pairs, names))
    told = np.array([np.mean([forward(each, row) for each in networks], axis=0) for row in compressed(portraits)])
    assert (np.array(families)[told.argmax(axis=1)] == names).mean() > 0.9
